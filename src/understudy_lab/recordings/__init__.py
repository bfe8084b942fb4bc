"""The experiment on lessons from recordings."""
