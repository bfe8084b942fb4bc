"""The experiment with teachers who press wrong buttons and press late, with and without unlearning."""
