"""Pictures: a run as paths (PNG) or in motion (GIF), an automaton as a graph (SVG). All from plain data."""

from understudy.viz.automaton_svg import automaton_svg
from understudy.viz.path_png import path_png
from understudy.viz.run_gif import run_gif

__all__ = ["automaton_svg", "path_png", "run_gif"]
