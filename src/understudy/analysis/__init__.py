"""Analysis: explanations of recorded runs, and tests that lessons still give the automata they should."""
