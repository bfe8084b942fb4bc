"""Recordings of real robots (MCAP): write, read and replay them."""
