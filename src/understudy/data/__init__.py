"""Data of lessons and runs as episodes and data frames, for statistics, figures and other programs."""
