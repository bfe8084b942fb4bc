"""Squads, coordinators and the messages between them (paper section 5)."""
