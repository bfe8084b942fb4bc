"""Checks of libraries and behaviors: what is wrong in a lesson, and in which worlds a behavior fails."""
