"""Scenario files: what a world is made of, and the checks on it."""
