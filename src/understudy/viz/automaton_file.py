"""Render automata as files of pictures, by the ending of the file's name."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from understudy.errors import SettingError
from understudy.model.library import TrainedAutomaton
from understudy.viz.automaton_dot import write_automata_dot
from understudy.viz.automaton_graph import lay_out_taught, stack_graphs
from understudy.viz.automaton_plot import plot_graphs
from understudy.viz.automaton_svg import draw_graphs_svg
from understudy.viz.axes import PIXELS_PER_IN, STYLE, make_figure, measure_text

ENDINGS = (".svg", ".pdf", ".png", ".dot")
DPI = 200


def check_picture_name(path: Path | str, *, where: str) -> str:
    """Return the ending of a picture's file name in small letters; SettingError if it is none of ENDINGS."""
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        remedy = "name a file that ends in .svg, .pdf or .png (pictures) or .dot (text for Graphviz)"
        raise SettingError(where=where, setting=repr(str(path)), problem="is not a picture", remedy=remedy)
    return ending


def render_automata(automata: Sequence[TrainedAutomaton], ending: str) -> bytes:
    """Render automata, one below the other, as a file with one of the ENDINGS; the same ones give the same bytes."""
    if ending == ".dot":
        return write_automata_dot(automata).encode()
    if ending == ".svg":
        return draw_graphs_svg([lay_out_taught(taught) for taught in automata]).encode()
    import matplotlib as mpl

    graphs = [lay_out_taught(taught, measure_text) for taught in automata]
    _, width, height = stack_graphs(graphs)
    with mpl.rc_context(STYLE):
        figure = make_figure(width / PIXELS_PER_IN, height / PIXELS_PER_IN)
        plot_graphs(graphs, figure.add_axes((0.0, 0.0, 1.0, 1.0)))
        buffer = BytesIO()
        undated = {"CreationDate": None} if ending == ".pdf" else None
        figure.savefig(buffer, format=ending[1:], dpi=DPI, facecolor="white", metadata=undated)
    return buffer.getvalue()
