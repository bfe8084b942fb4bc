"""The experiment with other learners on the same tasks: success by number of decisions and by time."""
