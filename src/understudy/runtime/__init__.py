"""The runtimes: what a body is, and how automata decide for one (ARCHITECTURE sections 1, 3 and 6)."""
