"""The experiment that measures how often a switch is learned on the wrong feature, under two orders of tests."""
