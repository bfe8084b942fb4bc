"""Pictures: a run as paths (PNG) or in motion (GIF), an automaton as a graph (SVG). All from plain data."""
