"""Draw automata as an SVG: states as graphs, transitions numbered, their conditions listed below."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from understudy.model.automaton import Automaton
from understudy.viz.automaton_graph import (
    BELOW_SIZE,
    LIST_SIZE,
    MARGIN,
    NAME_SIZE,
    NOTE_SIZE,
    ROW,
    TITLE_SIZE,
    AutomatonGraph,
    Conditions,
    GraphEdge,
    GraphNode,
    estimate_text_width,
    lay_out_automaton,
    stack_graphs,
)
from understudy.viz.graph_layout import BADGE, EdgeArrow, NodeBox
from understudy.viz.palette import FAINT, INK, LINE, PAPER

FONT = "Inter, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif"


def draw_automaton_svg(automaton: Automaton, conditions: Conditions) -> str:
    """Return an SVG document of the automaton; `conditions` describes in words when each transition is taken.

    Transitions from a state to itself are omitted. UnknownName if `conditions` names a state that does not exist.
    """
    return draw_graphs_svg([lay_out_automaton(automaton, conditions)])


def draw_graphs_svg(graphs: Sequence[AutomatonGraph]) -> str:
    """Return an SVG document with the pictures of automata, one below the other."""
    graphs, width, height = stack_graphs(graphs)
    title = escape(", ".join(graph.title for graph in graphs))
    described = escape(" ".join(graph.description for graph in graphs))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" role="img" aria-labelledby="title desc" '
        f'font-family="{FONT}">',
        f'<title id="title">Automaton {title}</title>',
        f'<desc id="desc">{described}</desc>',
        _heads([edge for graph in graphs for edge in graph.edges]),
        f'<rect width="100%" height="100%" fill="{PAPER}"/>',
    ]
    top = 0.0
    for graph in graphs:
        parts += [f'<g transform="translate(0 {top:.1f})">', *_graph(graph), "</g>"]
        top += graph.height
    return "\n".join([*parts, "</svg>", ""])


def _graph(graph: AutomatonGraph) -> list[str]:
    width = graph.width
    parts = [
        _text(MARGIN, 34.0, graph.title, TITLE_SIZE, bold=True),
        _text(width - MARGIN, 34.0, graph.note, NOTE_SIZE, anchor="end", color=FAINT),
        "<g>",
        *(_arrow(edge, arrow) for edge, arrow in zip(graph.edges, graph.arrows, strict=True)),
        _start(graph.boxes[0]),
        *(_box(node, box) for node, box in zip(graph.nodes, graph.boxes, strict=True)),
        *(_badge(edge, *arrow.badge) for edge, arrow in zip(graph.edges, graph.arrows, strict=True)),
        "</g>",
    ]
    if graph.edges:
        parts.append(f'<path d="M{MARGIN} {graph.rule:.1f}H{width - MARGIN:.1f}" stroke="{LINE}"/>')
    for edge, y in zip(graph.edges, graph.rows, strict=True):
        parts.append(_badge(edge, MARGIN + BADGE, y + BADGE + 1.0))
        parts.append(_text(MARGIN + 2 * BADGE + 12, y + 16, edge.moves, LIST_SIZE, bold=True))
        for at, line in enumerate(edge.lines):
            x = MARGIN + graph.column + (0.0 if line.first else 14.0)
            parts.append(_text(x, y + 16 + at * ROW, line.text, LIST_SIZE, color=line.color))
    return parts


def _text(
    x: float, y: float, text: str, size: float, *, bold: bool = False, anchor: str = "", color: str = INK
) -> str:
    weight = ' font-weight="650"' if bold else ""
    where = f' text-anchor="{anchor}"' if anchor else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}"{weight}{where} fill="{color}">'
        f"{escape(text)}</text>"
    )


def _heads(edges: Sequence[GraphEdge]) -> str:
    marks = "".join(
        f'<marker id="head{color[1:]}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="7" '
        f'markerHeight="7" orient="auto"><path d="M0 0.8 9.6 5 0 9.2 2.2 5Z" fill="{color}"/></marker>'
        for color in dict.fromkeys([INK, *(edge.color for edge in edges)])
    )
    return f"<defs>{marks}</defs>"


def _start(box: NodeBox) -> str:
    x, y = box.x - box.width / 2, box.y
    return (
        f'<circle cx="{x - 28:.1f}" cy="{y:.1f}" r="5" fill="{INK}"/>'
        f'<path d="M{x - 23:.1f} {y:.1f}H{x - 3:.1f}" stroke="{INK}" stroke-width="1.8" '
        f'marker-end="url(#head{INK[1:]})"/>'
    )


def _box(node: GraphNode, box: NodeBox) -> str:
    x, y = box.x - box.width / 2, box.y - box.height / 2
    name_y, flag = (box.y - 2.0 if node.below else box.y + 5.0), ""
    if node.flagged:
        at = box.x + 7 - estimate_text_width(node.label, NAME_SIZE, True) / 2 - 18.0
        flag = (
            f'<path d="M{at:.1f} {name_y + 2:.1f}V{name_y - 12:.1f}l10 3.5-10 3.5" fill="{node.stroke}" '
            f'stroke="{node.stroke}" stroke-width="1.6" stroke-linejoin="round"/>'
        )
    text = _text(
        box.x + (7 if node.flagged else 0), name_y, node.label, NAME_SIZE, bold=True, anchor="middle"
    )
    if node.below:
        text += _text(box.x, box.y + 15, node.below, BELOW_SIZE, anchor="middle", color=FAINT)
    return (
        f'<g data-state="{escape(node.name)}">'
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" rx="12" '
        f'fill="{node.fill}" stroke="{node.stroke}" stroke-width="{node.line_width}"{_dashes(node.dashes)}/>'
        f"{flag}{text}</g>"
    )


def _dashes(dashes: tuple[float, float] | None) -> str:
    return "" if dashes is None else f' stroke-dasharray="{dashes[0]:g} {dashes[1]:g}"'


def _arrow(edge: GraphEdge, arrow: EdgeArrow) -> str:
    (x, y), (over_x, over_y), (to_x, to_y) = arrow.begin, arrow.control, arrow.end
    return (
        f'<path d="M{x:.1f} {y:.1f}Q{over_x:.1f} {over_y:.1f} {to_x:.1f} {to_y:.1f}" fill="none" '
        f'stroke="{edge.color}" stroke-width="{edge.line_width}" '
        f'marker-end="url(#head{edge.color[1:]})"{_dashes(edge.dashes)}/>'
    )


def _badge(edge: GraphEdge, x: float, y: float) -> str:
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{BADGE}" fill="{PAPER}" stroke="{edge.color}" '
        f'stroke-width="1.8"/>'
        + _text(x, y + 4.2, str(edge.number), 12, bold=True, anchor="middle", color=edge.color)
    )
