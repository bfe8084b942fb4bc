"""Hierarchies against automata in one piece: approaching and stopping, and foraging (paper section 4.2)."""
