"""Recorded runs: their files in MCAP, and what they hold."""
