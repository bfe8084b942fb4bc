"""Lay out the picture of an automaton: states as a graph, numbered transitions, and their conditions listed below.

The picture is plain geometry, which `automaton_svg` and `automaton_plot` draw. Lengths are in pixels of an SVG, y down.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from understudy.model.automaton import Automaton, State
from understudy.model.binding import format_bound_name
from understudy.model.describe import list_conditions_by_switch
from understudy.model.library import TrainedAutomaton
from understudy.viz.graph_layout import BADGE, EdgeArrow, NodeBox, place_arrows, place_boxes
from understudy.viz.palette import COLORS, FAINT, INK

Conditions: TypeAlias = Mapping[tuple[str, str], Sequence[str]]
"""By (state, next state), the conditions in words of which any one causes this transition."""
MeasureText: TypeAlias = Callable[[str, float, bool], float]
"""A function that returns the width of a text of a font size, bold or not."""
ChangeMark: TypeAlias = Literal["", "+", "−", "±", "·"]
"""The change of a part between two versions: added, removed, changed, unchanged; empty where nothing is compared."""

MARGIN, HEADING, ROW, WRAP = 28.0, 56.0, 19.0, 78
TITLE_SIZE, NAME_SIZE, LIST_SIZE, BELOW_SIZE, NOTE_SIZE = 18.0, 15.0, 13.0, 11.5, 12.0
ADDED, REMOVED = "#0072b2", "#b54a00"
"""The colors of added and removed parts; they also have marks, and removed parts broken lines."""


@dataclass(frozen=True)
class GraphNode:
    """A state as it is drawn: its name, and its behavior in small type below."""

    name: str
    below: str
    flagged: bool
    idle: bool
    mark: ChangeMark = ""

    @property
    def label(self) -> str:
        """The name, with the mark of a change before it."""
        return f"{self.mark} {self.name}" if self.mark in ("+", "−", "±") else self.name

    @property
    def fill(self) -> str:
        """The color inside its box."""
        if self.mark == "·":
            return "#f7f8f9"
        return "#fff8e6" if self.flagged else "#f3f5f7" if self.idle else "#eaf3fb"

    @property
    def stroke(self) -> str:
        """The color of its box's line."""
        if self.mark:
            return {"+": ADDED, "−": REMOVED, "±": INK}.get(self.mark, FAINT)
        return "#b8860b" if self.flagged else FAINT if self.idle else "#2f6f9f"

    @property
    def dashes(self) -> tuple[float, float] | None:
        """The lengths of dashes and gaps of its box's line; None for a continuous line."""
        if self.mark == "−":
            return (2.0, 3.0)
        return (5.0, 4.0) if self.flagged else None

    @property
    def line_width(self) -> float:
        """The width of its box's line."""
        return 2.6 if self.mark in ("+", "−", "±") else 1.6


@dataclass(frozen=True)
class GraphLine:
    """A line of the list of conditions; `first` if it begins an alternative."""

    first: bool
    text: str
    mark: ChangeMark = ""

    @property
    def color(self) -> str:
        """The color of its text."""
        return {"+": ADDED, "−": REMOVED, "·": FAINT}.get(self.mark, INK)


@dataclass(frozen=True)
class GraphEdge:
    """A transition as it is drawn: a numbered arrow of the color of the state that it leaves, and its conditions."""

    number: int
    begin: str
    end: str
    color: str
    lines: tuple[GraphLine, ...]
    mark: ChangeMark = ""

    @property
    def moves(self) -> str:
        """The two states, as the list of conditions names them, with the mark of a change before them."""
        return f"{self.mark} {self.begin} → {self.end}".removeprefix("· ").strip()

    @property
    def dashes(self) -> tuple[float, float] | None:
        """The lengths of dashes and gaps of its arrow; None for a continuous line."""
        return (2.5, 3.5) if self.mark == "−" else None

    @property
    def line_width(self) -> float:
        """The width of its arrow."""
        return 2.8 if self.mark in ("+", "±") else 1.8


@dataclass(frozen=True)
class AutomatonGraph:
    """The picture of one automaton, with the upper left corner at (0, 0).

    `boxes` and `arrows` belong to `nodes` and `edges` in order. `rows` has the upper end of each edge's entry in the
    list of conditions, and `column` is where conditions begin.
    """

    title: str
    note: str
    nodes: tuple[GraphNode, ...]
    edges: tuple[GraphEdge, ...]
    boxes: tuple[NodeBox, ...]
    arrows: tuple[EdgeArrow, ...]
    rows: tuple[float, ...]
    column: float
    rule: float
    width: float
    height: float

    def widen(self, width: float) -> AutomatonGraph:
        """Return the same picture of another width, with the graph in its middle."""
        across = (width - self.width) / 2
        boxes = tuple(box.move_by(across, 0.0) for box in self.boxes)
        arrows = tuple(arrow.move_by(across, 0.0) for arrow in self.arrows)
        return replace(self, width=width, boxes=boxes, arrows=arrows)

    @property
    def description(self) -> str:
        """The picture in words, for people who cannot see it."""
        states = "; ".join(f"{node.name} ({node.below})" if node.below else node.name for node in self.nodes)
        moves = [
            f"from {e.begin} to {e.end} when {' '.join(line.text for line in e.lines)}" for e in self.edges
        ]
        return f"States: {states}. Transitions: {'; '.join(moves) if moves else 'none'}."


def stack_graphs(graphs: Sequence[AutomatonGraph]) -> tuple[list[AutomatonGraph], float, float]:
    """Return pictures that are to stand one below the other, all of one width, with that width and their height."""
    width, height = max(graph.width for graph in graphs), sum(graph.height for graph in graphs)
    return [graph.widen(width) for graph in graphs], width, height


def estimate_text_width(text: str, size: float, bold: bool) -> float:
    """Estimate the width of a text in whichever font a browser takes."""
    return len(text) * size * (0.613 if bold else 0.585)


def lay_out_automaton(
    automaton: Automaton, conditions: Conditions, measure: MeasureText = estimate_text_width
) -> AutomatonGraph:
    """Lay out the picture of an automaton; `conditions` describes in words when each transition is taken.

    Transitions from a state to itself are omitted. UnknownName if `conditions` names a state that does not exist.
    """
    order = {name: at for at, name in enumerate(automaton.state_names)}
    for begin, end in conditions:
        automaton.state(begin), automaton.state(end)
    pairs = sorted(
        (pair for pair in conditions if pair[0] != pair[1]), key=lambda p: (order[p[0]], order[p[1]])
    )
    edges = [
        GraphEdge(number, *pair, choose_edge_color(order[pair[0]]), wrap_conditions(conditions[pair]))
        for number, pair in enumerate(pairs, start=1)
    ]
    nodes = [make_graph_node(state) for state in automaton.states]
    number = len(nodes)
    note = f"{number} state{'s' if number != 1 else ''}{', stateless' if automaton.stateless else ''}"
    return lay_out_graph(format_automaton_title(automaton), note, nodes, edges, measure)


def lay_out_taught(taught: TrainedAutomaton, measure: MeasureText = estimate_text_width) -> AutomatonGraph:
    """Lay out the picture of an automaton with conditions that fit its lesson."""
    conditions = list_conditions_by_switch(taught.automaton, taught.lesson)
    return lay_out_automaton(taught.automaton, conditions, measure)


def format_automaton_title(automaton: Automaton) -> str:
    """Return the name of an automaton with its parameters, such as "goto(A)"."""
    return format_bound_name(automaton.name, {name: name for name in automaton.parameters})


def choose_edge_color(state: int) -> str:
    """Return the color of the transitions that leave the state of this index."""
    return COLORS[state % len(COLORS)]


def make_graph_node(state: State, mark: ChangeMark = "") -> GraphNode:
    """Make the node of a state."""
    return GraphNode(state.name, _below(state), state.flag is not None, state.behavior is None, mark)


def _below(state: State) -> str:
    if state.flag is not None:
        return f"raises {state.flag}" if state.flag != state.name else "flag"
    if state.behavior is None:
        return "idles"
    runs = format_bound_name(state.behavior, state.binding)
    return "" if runs == state.name else runs


def wrap_conditions(texts: Sequence[str], mark: ChangeMark = "") -> tuple[GraphLine, ...]:
    """Break conditions into lines of at most WRAP characters, with 'or' before each alternative."""
    lines: list[GraphLine] = []
    for at, text in enumerate(texts or ("always",)):
        line, first = f"{mark} " if mark in ("+", "−") else "or" if at else "", True
        for word in text.split():
            if line and len(line) + 1 + len(word) > WRAP + 2 * bool(mark):
                lines.append(GraphLine(first, line, mark))
                line, first = word, False
            else:
                line = f"{line.rstrip()} {word}" if line else word
        lines.append(GraphLine(first, line, mark))
    return tuple(lines)


def lay_out_graph(
    title: str, note: str, nodes: Sequence[GraphNode], edges: Sequence[GraphEdge], measure: MeasureText
) -> AutomatonGraph:
    """Place nodes and edges, and the list of conditions below them; the first node is the start state."""
    order = {node.name: at for at, node in enumerate(nodes)}
    boxes = place_boxes([_size(node, measure) for node in nodes])
    arrows = place_arrows(boxes, [(order[edge.begin], order[edge.end]) for edge in edges])
    left, top, right, bottom = _extent(boxes, arrows)
    column = 2 * BADGE + 26.0 + max((measure(edge.moves, LIST_SIZE, True) for edge in edges), default=0.0)
    lines = [line for edge in edges for line in edge.lines]
    listed = column + max(
        (14.0 * (not e.first) + measure(e.text, LIST_SIZE, False) for e in lines), default=0.0
    )
    head = measure(title, TITLE_SIZE, True) + 24.0 + measure(note, NOTE_SIZE, False)
    width = max(right - left, listed if edges else 0.0, head) + 2 * MARGIN
    shift_x, shift_y = (width - (right - left)) / 2 - left, HEADING - top
    end = HEADING + bottom - top
    rows, y = [], end + 24.0
    for edge in edges:
        rows.append(y)
        y += max(2 * BADGE, ROW * len(edge.lines)) + 9.0
    return AutomatonGraph(
        title=title,
        note=note,
        nodes=tuple(nodes),
        edges=tuple(edges),
        boxes=tuple(box.move_by(shift_x, shift_y) for box in boxes),
        arrows=tuple(arrow.move_by(shift_x, shift_y) for arrow in arrows),
        rows=tuple(rows),
        column=column,
        rule=end + 8.0,
        width=width,
        height=(y if edges else end) + MARGIN,
    )


def _size(node: GraphNode, measure: MeasureText) -> tuple[float, float]:
    flag = 20.0 if node.flagged else 0.0
    name, below = measure(node.label, NAME_SIZE, True), measure(node.below, BELOW_SIZE, False)
    return max(84.0, name + flag + 30.0, below + 30.0), 48.0


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
