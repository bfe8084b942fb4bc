"""The runtimes: what a body is, and how automata decide for one (docs/semantics.md)."""
