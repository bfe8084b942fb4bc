"""Recordings of real robots (MCAP): writing, reading and replaying them."""
