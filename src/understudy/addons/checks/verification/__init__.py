"""Verification of taught automata: what can go wrong is found from their trees, without a run."""
