"""The experiment that compares novices who follow the coach's advice with the same novices alone."""
