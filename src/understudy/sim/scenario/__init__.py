"""Scenarios, the descriptions of worlds: their schema, files and checks."""
