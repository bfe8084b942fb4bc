"""The experiment: a patrol whose agents each have a computer and a link of their own, over lossy networks."""
