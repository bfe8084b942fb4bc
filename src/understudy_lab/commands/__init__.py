"""The laboratory's commands: demo, experiment and bench."""
