"""Pictures: a run as paths (PNG) or in motion (GIF), an automaton as a graph (SVG). All from plain data."""

from understudy.pictures.graph import automaton_svg
from understudy.pictures.motion import run_gif
from understudy.pictures.path import path_png

__all__ = ["automaton_svg", "path_png", "run_gif"]
