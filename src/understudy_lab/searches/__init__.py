"""The experiment with three searches for failing worlds, on robots that seldom fail."""
