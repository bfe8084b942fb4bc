"""The trainer: a session in real time, with everything that a user interface shows and controls."""
