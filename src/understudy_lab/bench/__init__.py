"""Measurements of speed against other programs, in one run on one machine."""
