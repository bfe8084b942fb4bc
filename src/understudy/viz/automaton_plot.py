"""Plot automata with matplotlib: states as graphs, transitions numbered, their conditions listed below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from understudy.model.automaton import Automaton
from understudy.model.library import TrainedAutomaton
from understudy.viz.automaton_graph import (
    BELOW_SIZE,
    LIST_SIZE,
    MARGIN,
    NAME_SIZE,
    NOTE_SIZE,
    ROW,
    TITLE_SIZE,
    AutomatonGraph,
    GraphEdge,
    GraphNode,
    lay_out_taught,
    stack_graphs,
)
from understudy.viz.axes import (
    make_picture_axes,
    measure_points_per_unit,
    measure_text,
    open_picture,
    write_scaled_text,
)
from understudy.viz.graph_layout import BADGE, EdgeArrow, NodeBox
from understudy.viz.palette import FAINT, INK, LINE, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_automaton(automaton: Automaton | TrainedAutomaton, ax: Axes | None = None) -> Axes:
    """Plot an automaton; thresholds are rounded such that examples stay on their sides, if it has a lesson."""
    taught = TrainedAutomaton(automaton) if isinstance(automaton, Automaton) else automaton
    return plot_graphs([lay_out_taught(taught, measure_text)], ax)


def plot_graphs(graphs: Sequence[AutomatonGraph], ax: Axes | None = None) -> Axes:
    """Plot the pictures of automata, one below the other, into axes; new axes have the size of the pictures."""
    graphs, width, height = stack_graphs(graphs)
    axes = make_picture_axes(width, height) if ax is None else ax
    open_picture(axes, width, height)
    top = 0.0
    for graph in graphs:
        _Pen(axes, top).draw(graph)
        top += graph.height
    return axes


class _Pen:
    """A drawer of one picture, `top` units below the upper edge of axes."""

    def __init__(self, axes: Axes, top: float) -> None:
        self.axes, self.top = axes, top
        self.thick = measure_points_per_unit(axes)
        """The factor from units to points, for the widths of lines."""

    def draw(self, graph: AutomatonGraph) -> None:
        self.text(MARGIN, 34.0, graph.title, TITLE_SIZE, bold=True)
        self.text(graph.width - MARGIN, 34.0, graph.note, NOTE_SIZE, align="right", color=FAINT)
        for edge, arrow in zip(graph.edges, graph.arrows, strict=True):
            self.arrow(edge, arrow)
        self.start(graph.boxes[0])
        for node, box in zip(graph.nodes, graph.boxes, strict=True):
            self.node(node, box)
        for edge, arrow in zip(graph.edges, graph.arrows, strict=True):
            self.badge(edge, *arrow.badge)
        if graph.edges:
            ends = (MARGIN, graph.width - MARGIN)
            self.axes.plot(ends, [graph.rule + self.top] * 2, color=LINE, lw=self.thick, zorder=1)
        for edge, y in zip(graph.edges, graph.rows, strict=True):
            self.badge(edge, MARGIN + BADGE, y + BADGE + 1.0)
            self.text(MARGIN + 2 * BADGE + 12, y + 16, edge.moves, LIST_SIZE, bold=True)
            for at, line in enumerate(edge.lines):
                x = MARGIN + graph.column + (0.0 if line.first else 14.0)
                self.text(x, y + 16 + at * ROW, line.text, LIST_SIZE, color=line.color)

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float,
        *,
        bold: bool = False,
        align: str = "left",
        color: str = INK,
    ) -> None:
        write_scaled_text(self.axes, x, y + self.top, text, size, bold=bold, align=align, color=color)

    def node(self, node: GraphNode, box: NodeBox) -> None:
        from matplotlib.patches import FancyBboxPatch, PathPatch
        from matplotlib.path import Path

        corner = (box.x - box.width / 2 + 12, box.y - box.height / 2 + 12 + self.top)
        shape = FancyBboxPatch(
            corner, box.width - 24, box.height - 24, boxstyle="round,pad=12,rounding_size=12", mutation_aspect=1.0,
            fc=node.fill, ec=node.stroke, lw=node.line_width * self.thick, ls=_line_style(node.dashes), zorder=3,
        )  # fmt: skip
        self.axes.add_patch(shape)
        name_y = box.y - 2.0 if node.below else box.y + 5.0
        if node.flagged:
            at = box.x + 7 - measure_text(node.label, NAME_SIZE, True) / 2 - 16.0
            y = name_y + self.top
            flag = Path([(at, y + 2), (at, y - 12), (at + 10, y - 8.5), (at, y - 5)])
            self.axes.add_patch(
                PathPatch(flag, fc=node.stroke, ec=node.stroke, lw=1.6 * self.thick, zorder=4)
            )
        self.text(
            box.x + (7 if node.flagged else 0), name_y, node.label, NAME_SIZE, bold=True, align="center"
        )
        if node.below:
            self.text(box.x, box.y + 15, node.below, BELOW_SIZE, align="center", color=FAINT)

    def start(self, box: NodeBox) -> None:
        from matplotlib.patches import Circle

        x, y = box.x - box.width / 2, box.y + self.top
        self.axes.add_patch(Circle((x - 28, y), 5, fc=INK, ec="none", zorder=2))
        self.curve(((x - 23, y), (x - 13, y), (x - 3, y)), INK, 1.8, None)

    def arrow(self, edge: GraphEdge, arrow: EdgeArrow) -> None:
        moved = arrow.move_by(0.0, self.top)
        self.curve((moved.begin, moved.control, moved.end), edge.color, edge.line_width, edge.dashes)

    def curve(
        self,
        points: tuple[tuple[float, float], ...],
        color: str,
        wide: float,
        dashes: tuple[float, float] | None,
    ) -> None:
        from matplotlib.patches import PathPatch, Polygon
        from matplotlib.path import Path

        (over_x, over_y), (x, y) = points[1:]
        length = max(((x - over_x) ** 2 + (y - over_y) ** 2) ** 0.5, 1e-9)
        ahead, beside = (x - over_x) / length, (y - over_y) / length
        neck = (x - 8 * ahead, y - 8 * beside)
        path = Path([points[0], points[1], neck], [Path.MOVETO, Path.CURVE3, Path.CURVE3])
        self.axes.add_patch(
            PathPatch(
                path,
                fc="none",
                ec=color,
                lw=wide * self.thick,
                ls=_line_style(dashes),
                capstyle="butt",
                zorder=2,
            )
        )
        corners = [(0.0, 0.0), (-12.0, 5.3), (-9.2, 0.0), (-12.0, -5.3)]
        head = [(x + a * ahead - b * beside, y + a * beside + b * ahead) for a, b in corners]
        self.axes.add_patch(Polygon(head, fc=color, ec="none", zorder=2))

    def badge(self, edge: GraphEdge, x: float, y: float) -> None:
        from matplotlib.patches import Circle

        place = (x, y + self.top)
        self.axes.add_patch(Circle(place, BADGE, fc=PAPER, ec=edge.color, lw=1.8 * self.thick, zorder=5))
        self.text(x, y + 4.2, str(edge.number), 12.0, bold=True, align="center", color=edge.color)


def _line_style(dashes: tuple[float, float] | None) -> str | tuple[float, tuple[float, float]]:
    return "-" if dashes is None else (0.0, (dashes[0] / 1.6, dashes[1] / 1.6))
