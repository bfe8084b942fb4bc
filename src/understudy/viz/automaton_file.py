"""Render automata as files of pictures, by the ending of the file's name."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from understudy.errors import SettingError
from understudy.model.automaton import Automaton
from understudy.model.library import TrainedAutomaton
from understudy.viz.automaton_graph import AutomatonGraph, GraphNode, lay_out_taught, stack_graphs
from understudy.viz.automaton_plot import plot_graphs
from understudy.viz.automaton_svg import draw_graphs_svg
from understudy.viz.axes import PIXELS_PER_IN, STYLE, make_figure, measure_text
from understudy.viz.palette import FAINT, INK

ENDINGS = (".svg", ".pdf", ".png", ".dot")
DPI = 200
WRAP = 36
"""The number of letters after which a condition goes on in the next line."""


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


def write_automata_dot(automata: Sequence[TrainedAutomaton]) -> str:
    """Return Graphviz text of automata: one graph, or a cluster each with lines from states to what they run."""
    graphs = [lay_out_taught(taught) for taught in automata]
    head = [
        f"digraph {_quote(graphs[0].title)} {{",
        "  compound=true; rankdir=LR;",
        f'  node [shape=box, style="rounded,filled", fontname="Helvetica", color="{FAINT}", fontcolor="{INK}"];',
        f'  edge [fontname="Helvetica", fontsize=11, color="{FAINT}", fontcolor="{INK}"];',
    ]
    if len(graphs) == 1:
        return "\n".join([*head, *_list_lines(graphs[0], 0, "  "), "}", ""])
    lines = list(head)
    for at, graph in enumerate(graphs):
        lines += [f"  subgraph cluster_{at} {{", f"    label={_quote(graph.title)};"]
        lines += [*_list_lines(graph, at, "    "), "  }"]
    names = [taught.automaton.name for taught in automata]
    for at, taught in enumerate(automata):
        lines += _list_calls(taught.automaton, at, names)
    return "\n".join([*lines, "}", ""])


def _list_lines(graph: AutomatonGraph, at: int, indent: str) -> list[str]:
    order = {node.name: index for index, node in enumerate(graph.nodes)}
    lines = [f"{indent}s{at}_{index} [{_describe_node(node)}];" for index, node in enumerate(graph.nodes)]
    lines += [f"{indent}b{at} [shape=point, width=0.12];", f"{indent}b{at} -> s{at}_0;"]
    for edge in graph.edges:
        label = _quote("\n".join(_wrap(" ".join(line.text for line in edge.lines))))
        begin, end = (f"s{at}_{order[name]}" for name in (edge.begin, edge.end))
        lines.append(f'{indent}{begin} -> {end} [label={label}, color="{edge.color}"];')
    return lines


def _describe_node(node: GraphNode) -> str:
    label = _quote(f"{node.name}\n{node.below}" if node.below else node.name)
    dashes = ', style="rounded,filled,dashed"' if node.flagged else ""
    return f'label={label}, fillcolor="{node.fill}", color="{node.stroke}"{dashes}'


def _list_calls(automaton: Automaton, at: int, names: Sequence[str]) -> list[str]:
    """List dotted lines from the states of an automaton to the automata that they run."""
    return [
        f"  s{at}_{index} -> b{names.index(state.behavior)} "
        f"[style=dotted, arrowhead=none, lhead=cluster_{names.index(state.behavior)}];"
        for index, state in enumerate(automaton.states)
        if state.behavior in names
    ]


def _wrap(text: str) -> list[str]:
    from textwrap import wrap

    return wrap(text, WRAP, break_long_words=False, break_on_hyphens=False) or [""]


def _quote(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
