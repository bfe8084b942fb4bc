"""Targets of exports, one module for each, and their table."""
