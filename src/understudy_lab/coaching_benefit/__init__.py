"""Novices who follow the coach, beside the same novices left to themselves."""
