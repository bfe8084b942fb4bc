"""Draw an automaton as an SVG: its states as a graph, its transitions numbered, their conditions listed below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

from understudy.model.automaton import Automaton, State
from understudy.model.binding import format_bound_name
from understudy.viz.graph_layout import BADGE, EdgeArrow, NodeBox, place_arrows, place_boxes
from understudy.viz.palette import COLORS, FAINT, INK, LINE, PAPER

Conditions = Mapping[tuple[str, str], Sequence[str]]
"""By (state, next state), the conditions in words of which any one causes this transition."""

FONT = "Inter, 'Segoe UI', 'Helvetica Neue', Arial, 'DejaVu Sans', sans-serif"
MARGIN, HEADING, ROW, WRAP = 28.0, 56.0, 19.0, 78


@dataclass(frozen=True)
class _Edge:
    number: int
    begin: str
    end: str
    color: str
    lines: tuple[tuple[bool, str], ...]
    """Lines of text, each with whether it begins an alternative condition."""


def draw_automaton_svg(automaton: Automaton, conditions: Conditions) -> str:
    """Return an SVG document of the automaton; `conditions` describes in words when each transition is taken.

    Transitions from a state to itself are omitted. UnknownName if `conditions` names a state that does not exist.
    """
    boxes = place_boxes([_size(state) for state in automaton.states])
    edges = _edges(automaton, conditions)
    pairs = [(automaton.index(edge.begin), automaton.index(edge.end)) for edge in edges]
    arrows = place_arrows(boxes, pairs)
    left, top, right, bottom = _extent(boxes, arrows)
    legend = _legend(edges)
    width = max(right - left, _legend_width(edges), 8.2 * len(_title(automaton))) + 2 * MARGIN
    shift_x = (width - (right - left)) / 2 - left
    graph_bottom = HEADING + bottom - top
    height = graph_bottom + (24.0 if edges else 0.0) + legend[1] + MARGIN
    graph = [_arrow(edge, arrow) for edge, arrow in zip(edges, arrows, strict=True)]
    graph += [_start(boxes[0])]
    graph += [_box(state, box) for state, box in zip(automaton.states, boxes, strict=True)]
    graph += [_badge(edge, *arrow.badge) for edge, arrow in zip(edges, arrows, strict=True)]
    title, number = escape(_title(automaton)), len(automaton.states)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.1f} {height:.1f}" role="img" aria-labelledby="title desc" '
        f'font-family="{FONT}">',
        f'<title id="title">Automaton {title}</title>',
        f'<desc id="desc">{escape(_description(automaton, edges))}</desc>',
        _heads(edges),
        f'<rect width="100%" height="100%" fill="{PAPER}"/>',
        f'<text x="{MARGIN}" y="34" font-size="18" font-weight="700" fill="{INK}">{title}</text>',
        f'<text x="{width - MARGIN:.1f}" y="34" font-size="12" text-anchor="end" fill="{FAINT}">'
        f"{number} state{'s' if number != 1 else ''}{', stateless' if automaton.stateless else ''}</text>",
        f'<g transform="translate({shift_x:.1f} {HEADING - top:.1f})">',
        *graph,
        "</g>",
    ]
    if edges:
        rule = graph_bottom + 8.0
        parts.append(f'<path d="M{MARGIN} {rule:.1f}H{width - MARGIN:.1f}" stroke="{LINE}"/>')
        parts.append(f'<g transform="translate({MARGIN} {graph_bottom + 24.0:.1f})">{legend[0]}</g>')
    return "\n".join([*parts, "</svg>", ""])


def _title(automaton: Automaton) -> str:
    return format_bound_name(automaton.name, {name: name for name in automaton.parameters})


def _description(automaton: Automaton, edges: Sequence[_Edge]) -> str:
    states = "; ".join(str(state) for state in automaton.states)
    moves = [f"from {e.begin} to {e.end} when {' '.join(text for _, text in e.lines)}" for e in edges]
    return f"States: {states}. Transitions: {'; '.join(moves) if moves else 'none'}."


def _edges(automaton: Automaton, conditions: Conditions) -> list[_Edge]:
    order = {name: at for at, name in enumerate(automaton.state_names)}
    for begin, end in conditions:
        automaton.state(begin), automaton.state(end)
    pairs = sorted(
        (pair for pair in conditions if pair[0] != pair[1]), key=lambda p: (order[p[0]], order[p[1]])
    )
    return [
        _Edge(number, *pair, COLORS[order[pair[0]] % len(COLORS)], _wrapped(conditions[pair]))
        for number, pair in enumerate(pairs, start=1)
    ]


def _wrapped(texts: Sequence[str]) -> tuple[tuple[bool, str], ...]:
    """Break conditions into lines of at most WRAP characters, with 'or' before each alternative."""
    lines: list[tuple[bool, str]] = []
    for at, text in enumerate(texts or ("always",)):
        line, first = "or" if at else "", True
        for word in text.split():
            if line and len(line) + 1 + len(word) > WRAP:
                lines.append((first, line))
                line, first = word, False
            else:
                line = f"{line} {word}" if line else word
        lines.append((first, line))
    return tuple(lines)


def _subtitle(state: State) -> str:
    if state.flag is not None:
        return f"raises {state.flag}" if state.flag != state.name else "flag"
    if state.behavior is None:
        return "idles"
    runs = format_bound_name(state.behavior, state.binding)
    return "" if runs == state.name else runs


def _size(state: State) -> tuple[float, float]:
    flag = 20.0 if state.flag is not None else 0.0
    return max(84.0, 9.2 * len(state.name) + flag + 30.0, 6.9 * len(_subtitle(state)) + 30.0), 48.0


def _extent(boxes: Sequence[NodeBox], arrows: Sequence[EdgeArrow]) -> tuple[float, float, float, float]:
    xs = [box.x + side * box.width / 2 for box in boxes for side in (-1, 1)]
    ys = [box.y + side * box.height / 2 for box in boxes for side in (-1, 1)]
    points = [arrow.point_at(step / 10) for arrow in arrows for step in range(11)]
    badges = [
        (x + side * BADGE, y + side * BADGE) for x, y in (arrow.badge for arrow in arrows) for side in (-1, 1)
    ]
    xs += [x for x, _ in (*points, *badges)] + [boxes[0].x - boxes[0].width / 2 - 34.0]
    ys += [y for _, y in (*points, *badges)]
    return min(xs), min(ys), max(xs), max(ys) + 6.0


def _heads(edges: Sequence[_Edge]) -> str:
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


def _box(state: State, box: NodeBox) -> str:
    x, y = box.x - box.width / 2, box.y - box.height / 2
    flagged, idle = state.flag is not None, state.behavior is None
    dash = ' stroke-dasharray="5 4"' if flagged else ""
    fill = "#fff8e6" if flagged else "#f3f5f7" if idle else "#eaf3fb"
    stroke = "#b8860b" if flagged else FAINT if idle else "#2f6f9f"
    below = _subtitle(state)
    name_y, flag = (box.y - 2.0 if below else box.y + 5.0), ""
    if flagged:
        at = box.x - 4.6 * len(state.name) - 8.0
        flag = (
            f'<path d="M{at:.1f} {name_y + 2:.1f}V{name_y - 12:.1f}l10 3.5-10 3.5" fill="{stroke}" '
            f'stroke="{stroke}" stroke-width="1.6" stroke-linejoin="round"/>'
        )
    name = f'<text x="{box.x + (7 if flagged else 0):.1f}" y="{name_y:.1f}" font-size="15" font-weight="650"'
    text = f'{name} text-anchor="middle" fill="{INK}">{escape(state.name)}</text>'
    if below:
        text += (
            f'<text x="{box.x:.1f}" y="{box.y + 15:.1f}" font-size="11.5" text-anchor="middle" '
            f'fill="{FAINT}">{escape(below)}</text>'
        )
    return (
        f'<g data-state="{escape(state.name)}">'
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" rx="12" '
        f'fill="{fill}" stroke="{stroke}" stroke-width="1.6"{dash}/>{flag}{text}</g>'
    )


def _arrow(edge: _Edge, arrow: EdgeArrow) -> str:
    (x, y), (over_x, over_y), (to_x, to_y) = arrow.begin, arrow.control, arrow.end
    return (
        f'<path d="M{x:.1f} {y:.1f}Q{over_x:.1f} {over_y:.1f} {to_x:.1f} {to_y:.1f}" fill="none" '
        f'stroke="{edge.color}" stroke-width="1.8" marker-end="url(#head{edge.color[1:]})"/>'
    )


def _badge(edge: _Edge, x: float, y: float) -> str:
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{BADGE}" fill="{PAPER}" stroke="{edge.color}" '
        f'stroke-width="1.8"/>'
        f'<text x="{x:.1f}" y="{y + 4.2:.1f}" font-size="12" font-weight="700" text-anchor="middle" '
        f'fill="{edge.color}">{edge.number}</text>'
    )


def _moves(edge: _Edge) -> str:
    return f"{edge.begin} → {edge.end}"


def _column(edges: Sequence[_Edge]) -> float:
    """Return the x at which conditions begin, right of the longest 'from → to'."""
    return 2 * BADGE + 12.0 + max(7.9 * len(_moves(edge)) for edge in edges) + 14.0


def _legend_width(edges: Sequence[_Edge]) -> float:
    if not edges:
        return 0.0
    return _column(edges) + max(7.3 * len(text) for edge in edges for _, text in edge.lines)


def _legend(edges: Sequence[_Edge]) -> tuple[str, float]:
    """Return the SVG of the list of conditions, and its height."""
    parts, y = [], 0.0
    for edge in edges:
        parts.append(_badge(edge, BADGE, y + BADGE + 1.0))
        parts.append(
            f'<text x="{2 * BADGE + 12:.1f}" y="{y + 16:.1f}" font-size="13" font-weight="650" '
            f'fill="{INK}">{escape(_moves(edge))}</text>'
        )
        for at, (first, text) in enumerate(edge.lines):
            indent = 0.0 if first else 14.0
            parts.append(
                f'<text x="{_column(edges) + indent:.1f}" y="{y + 16 + at * ROW:.1f}" font-size="13" '
                f'fill="{INK}">{escape(text)}</text>'
            )
        y += max(2 * BADGE, ROW * len(edge.lines)) + 9.0
    return "".join(parts), y
