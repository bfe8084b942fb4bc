"""Plot what changed between two versions of an automaton: both as one graph, with a mark on each change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from understudy.model.automaton import Automaton, State
from understudy.model.describe import list_conditions_by_switch
from understudy.model.diff import AutomatonDiff
from understudy.viz.automaton_graph import (
    ADDED,
    REMOVED,
    AutomatonGraph,
    ChangeMark,
    GraphEdge,
    GraphLine,
    GraphNode,
    MeasureText,
    estimate_text_width,
    format_automaton_title,
    lay_out_graph,
    make_graph_node,
    wrap_conditions,
)
from understudy.viz.automaton_plot import plot_graphs
from understudy.viz.automaton_svg import draw_graphs_svg
from understudy.viz.axes import measure_text
from understudy.viz.palette import FAINT, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EDGE_COLORS: Mapping[ChangeMark, str] = {"+": ADDED, "−": REMOVED, "±": INK, "·": FAINT}


def plot_diff(diff: AutomatonDiff, ax: Axes | None = None) -> Axes:
    """Plot the differences of two versions: + added, − removed, ± changed; the rest is gray."""
    return plot_graphs([lay_out_diff(diff, measure_text)], ax)


def draw_diff_svg(diff: AutomatonDiff) -> str:
    """Return the plot of differences as an SVG document."""
    return draw_graphs_svg([lay_out_diff(diff)])


def lay_out_diff(diff: AutomatonDiff, measure: MeasureText = estimate_text_width) -> AutomatonGraph:
    """Lay out the graph of two versions of an automaton, with a mark on each state and transition."""
    old, new = diff.before.automaton, diff.after.automaton
    names = dict.fromkeys([*new.state_names, *old.state_names])
    nodes = [_node(old, new, name) for name in names]
    before = list_conditions_by_switch(old, diff.before.lesson)
    after = list_conditions_by_switch(new, diff.after.lesson)
    order = {name: at for at, name in enumerate(names)}
    pairs = sorted({*before, *after}, key=lambda pair: (order[pair[0]], order[pair[1]]))
    edges = [
        _edge(number, pair, before.get(pair), after.get(pair)) for number, pair in enumerate(pairs, start=1)
    ]
    return lay_out_graph(format_automaton_title(new), _summarize(diff), nodes, edges, measure)


def _node(old: Automaton, new: Automaton, name: str) -> GraphNode:
    was, is_now = _find_state(old, name), _find_state(new, name)
    if was is None or is_now is None:
        state = was or is_now or State(name)
        return make_graph_node(state, "−" if is_now is None else "+")
    node = make_graph_node(is_now, "·")
    if was == is_now:
        return node
    former = make_graph_node(was).below or was.name
    return GraphNode(name, f"{former} → {node.below or name}", node.flagged, node.idle, "±")


def _find_state(automaton: Automaton, name: str) -> State | None:
    return automaton.state(name) if name in automaton.state_names else None


def _edge(
    number: int, pair: tuple[str, str], before: Sequence[str] | None, after: Sequence[str] | None
) -> GraphEdge:
    lines: list[GraphLine] = []
    marks: list[ChangeMark] = []
    for text in dict.fromkeys([*(before or ()), *(after or ())]):
        unchanged = text in (before or ()) and text in (after or ())
        mark: ChangeMark = "·" if unchanged else "+" if text in (after or ()) else "−"
        lines += wrap_conditions([text], mark)
        marks.append(mark)
    whole: ChangeMark = (
        "·" if set(marks) == {"·"} else "+" if before is None else "−" if after is None else "±"
    )
    return GraphEdge(number, *pair, EDGE_COLORS[whole], tuple(lines), whole)


def _summarize(diff: AutomatonDiff) -> str:
    """Return the numbers of lines added and removed by topic, such as "conditions +2 −1, examples +3"."""
    topics = []
    for topic, lines in diff.items():
        counts = {
            mark: sum(line.startswith(sign) for line in lines) for mark, sign in (("+", "+"), ("−", "-"))
        }
        numbers = " ".join(f"{mark}{count}" for mark, count in counts.items() if count)
        topics.append(f"{topic} {numbers}")
    return ", ".join(topics) or "nothing changed"
