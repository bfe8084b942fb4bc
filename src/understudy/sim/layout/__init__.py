"""Lay out new worlds: places of objects and robots, and the geometry that this needs."""
