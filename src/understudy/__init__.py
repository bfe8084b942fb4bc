"""Understudy: robots and robot teams that learn by being shown."""
