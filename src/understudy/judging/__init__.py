"""Rollouts of behaviors, measurements and comparisons of their runs, explanations, and properties."""
