"""Pictures from plain data: a run as paths (PNG) or animated (GIF), an automaton as a graph (SVG)."""
