"""Lessons, sessions and runs as episodes and data frames, for statistics, figures and other programs."""
