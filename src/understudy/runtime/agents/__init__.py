"""Agents of a team that decide for themselves, each in a process of its own, and exchange messages."""
