"""Plot the examples of one state of a lesson, and what is learned from them, in the plane of two features."""

from __future__ import annotations

from cmath import phase, rect
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

from understudy.errors import SettingError, UnknownName
from understudy.learning.fit import learn
from understudy.model.automaton import Automaton, Transition
from understudy.model.describe import format_value
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import list_cuts
from understudy.model.value_kinds import TAU, Categorical, Toroidal
from understudy.viz.axes import escape_math, make_axes
from understudy.viz.feature_axis import AxisCell, FeatureAxis
from understudy.viz.palette import COLORS, FAINT, INK, PAPER, blend_color

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


WIDE_IN, TALL_IN = 6.2, 4.0
HATCHES = ("x", "//", r"\\", "--", "||", "+", "..", "/")
"""The hatch of each next state, which tells regions apart without colors."""
SMOOTH = 160
"""The number of cells across the axes on which a classifier is asked, which has no thresholds."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""The marker of each next state, which tells states apart without colors."""
SIZE, SMALL, RING, MOST_RINGS = 7.5, 3.5, 4.5, 3
"""Sizes of marks, in points: of an example from a press, of a watched one, and the growth for each further example at
the same place, which ends after MOST_RINGS of them."""
WORDS = {
    ExampleKind.DIRECTIVE: "pressed",
    ExampleKind.CONFIRMATION: "confirmed",
    ExampleKind.DEFAULT: "default",
    ExampleKind.WATCHED: "watched",
}
_CROSS: dict[str, Any] = {"marker": "x", "ms": 11, "color": INK, "mew": 1.4}


def plot_lesson(
    lesson: Lesson,
    x: str,
    y: str,
    *,
    state: str | None = None,
    at: Mapping[str, float | str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Plot a lesson's examples in one state and the regions of the learned next states in the plane of two features.

    The tree decides on other features as at the values `at`; by default at the middle of the examples' values.
    """
    automaton = lesson.automaton
    across, up = find_feature(automaton, x), find_feature(automaton, y)
    if across == up:
        where, problem = f"plot of lesson {lesson.name!r}", f"is {y!r}, as is x"
        raise SettingError(where=where, setting="y", problem=problem, remedy="name two features")
    state = _choose_state(lesson, state)
    examples = [each for each in lesson.examples if automaton.stateless or each.state == state]
    function = learn(lesson).get(state)
    plane = _Plane(lesson, state, examples, function, (across, up), at or {})
    axes = make_axes(WIDE_IN, TALL_IN) if ax is None else ax
    plane.draw(axes)
    return axes


def find_feature(automaton: Automaton, name: str) -> int:
    """Return the index of an automaton's feature, given as "distance_to(A)", or "distance_to" if it has one only."""
    names = [str(bound) for bound in automaton.features]
    if name in names:
        return names.index(name)
    indices = [index for index, bound in enumerate(automaton.features) if bound.feature.name == name]
    if len(indices) == 1:
        return indices[0]
    raise UnknownName(what="feature", name=name, where=f"automaton {automaton.name!r}", known=names)


def _choose_state(lesson: Lesson, state: str | None) -> str:
    """Return the state to plot: the one that was named, or the only one with examples."""
    counts = Counter(example.state for example in lesson.examples)
    where = f"plot of lesson {lesson.name!r}"
    if state is not None:
        lesson.automaton.state(state)
    elif counts and (lesson.automaton.stateless or len(counts) == 1):
        return next(iter(counts))
    elif counts:
        remedy = f"name one of the states with examples: {', '.join(counts)}"
        raise SettingError(where=where, setting="state", problem="is missing", remedy=remedy)
    if not counts or (not lesson.automaton.stateless and not counts[str(state)]):
        has = f"name a state that has some: {', '.join(counts)}" if counts else "show something first"
        what = "has no examples" if state is None or not counts else f"is {state!r}, which has no examples"
        raise SettingError(where=where, setting="state", problem=what, remedy=has)
    return str(state)


@dataclass(frozen=True)
class _Region:
    """A rectangle of one outcome, in positions of both axes."""

    left: float
    right: float
    low: float
    high: float
    outcome: int


class _Plane:
    """The plane of two features, with the examples of one state and the learned decisions."""

    def __init__(
        self,
        lesson: Lesson,
        state: str,
        examples: Sequence[Example],
        function: Transition | None,
        axes: tuple[int, int],
        at: Mapping[str, float | str],
    ) -> None:
        self._automaton, self._state, self._examples = lesson.automaton, state, examples
        self._function, self._across, self._up = function, *axes
        features = lesson.automaton.features
        cuts: list[list[float]] = [[] for _ in features]
        if isinstance(function, Tree):
            cuts = list_cuts(function, len(features))
        self.x, self.y = (
            FeatureAxis(features[axis], [example.values[axis] for example in examples], cuts[axis])
            for axis in axes
        )
        self._fixed = [_middle(bound, [e.values[i] for e in examples]) for i, bound in enumerate(features)]
        for name, value in at.items():
            index = find_feature(lesson.automaton, name)
            self._fixed[index] = _parse_value(features[index], value)
        self._stay = self._automaton.index(state)

    def draw(self, axes: Axes) -> None:
        regions = self._list_regions()
        for region in regions:
            self._draw_region(axes, region)
        self._draw_borders(axes)
        places = [
            (self.x.position(example.values[self._across]), self.y.position(example.values[self._up]))
            for example in self._examples
        ]
        marks = draw_examples(axes, self._examples, places, self._automaton.state_names)
        self.x.write_ticks(axes, "x")
        self.y.write_ticks(axes, "y")
        what = "all states" if self._automaton.stateless else f"state {self._state}"
        axes.set_title(
            escape_math(f"{self._automaton.name}, {what}"),
            loc="left",
            fontsize=10,
            fontweight="bold",
            color=INK,
        )
        fixed = self._describe_fixed()
        if fixed:
            axes.text(
                1.0, 1.015, fixed, transform=axes.transAxes, ha="right", va="bottom", fontsize=8, color=FAINT
            )
        self._draw_legend(axes, {region.outcome for region in regions}, marks)

    def _decide(self, x: AxisCell, y: AxisCell) -> int:
        if self._function is None:
            return self._stay
        values = list(self._fixed)
        values[self._across], values[self._up] = x.sample, y.sample
        outcome = self._function.decide(values)
        return self._stay if outcome == STAY else outcome

    def _grid(self) -> tuple[list[AxisCell], list[AxisCell], list[list[int]]]:
        if self._function is None or isinstance(self._function, Tree):
            xs, ys = self.x.cells, self.y.cells
        else:
            xs, ys = self.x.divide(SMOOTH), self.y.divide(SMOOTH)
        return xs, ys, [[self._decide(x, y) for x in xs] for y in ys]

    def _list_regions(self) -> list[_Region]:
        """List rectangles that cover the plane, joined along rows and then where rows are alike."""
        xs, ys, outcomes = self._grid()
        regions: list[_Region] = []
        before: dict[tuple[float, float, int], _Region] = {}
        for y, row in zip(ys, outcomes, strict=True):
            now: dict[tuple[float, float, int], _Region] = {}
            for left, right, outcome in _join_row(xs, row):
                key = (left, right, outcome)
                below = before.get(key)
                if below is not None and below.high == y.low:
                    regions.remove(below)
                    now[key] = _Region(left, right, below.low, y.high, outcome)
                else:
                    now[key] = _Region(left, right, y.low, y.high, outcome)
                regions.append(now[key])
            before = now
        return regions

    def _draw_region(self, axes: Axes, region: _Region) -> None:
        from matplotlib.patches import Rectangle

        color, hatch = self._look(region.outcome)
        axes.add_patch(
            Rectangle(
                (region.left, region.low), region.right - region.left, region.high - region.low,
                fc=blend_color(color, PAPER, 0.10), ec=blend_color(color, PAPER, 0.32), hatch=hatch, lw=0.0, zorder=0,
            )
        )  # fmt: skip

    def _draw_borders(self, axes: Axes) -> None:
        """Draw lines where the decision changes."""
        from matplotlib.collections import LineCollection

        xs, ys, outcomes = self._grid()
        lines = []
        for row, y in enumerate(ys):
            for column, x in enumerate(xs):
                here = outcomes[row][column]
                if column and xs[column - 1].high == x.low and outcomes[row][column - 1] != here:
                    lines.append([(x.low, y.low), (x.low, y.high)])
                if row and ys[row - 1].high == y.low and outcomes[row - 1][column] != here:
                    lines.append([(x.low, y.low), (x.high, y.low)])
        axes.add_collection(
            LineCollection(lines, colors=INK, linewidths=1.2, zorder=1, label="boundaries"), autolim=False
        )

    def _look(self, outcome: int) -> tuple[str, str]:
        """Return the color and the hatch of a next state; staying is plain gray."""
        if outcome == self._stay:
            return FAINT, ""
        return COLORS[outcome % len(COLORS)], HATCHES[outcome % len(HATCHES)]

    def _describe_fixed(self) -> str:
        """Describe the values of the other features that the function decides on."""
        features = self._automaton.features
        others = {index for index in range(len(features)) if index not in (self._across, self._up)}
        if isinstance(self._function, Tree):
            others &= {node.feature for node in self._function.nodes}
        if self._function is None or not others:
            return ""
        return "at " + ", ".join(
            f"{features[i]} = {format_value(features[i], self._fixed[i])}" for i in sorted(others)
        )

    def _draw_legend(self, axes: Axes, outcomes: set[int], marks: Sequence[Artist]) -> None:
        from matplotlib.patches import Patch

        names = self._automaton.state_names
        entries: list[Artist] = []
        for outcome in sorted(outcomes, key=lambda each: (each != self._stay, each)):
            color, hatch = self._look(outcome)
            says = f"stays in {names[outcome]}" if outcome == self._stay else f"goes to {names[outcome]}"
            if self._automaton.stateless:
                says = f"next: {names[outcome]}"
            entries.append(
                Patch(
                    fc=blend_color(color, PAPER, 0.10),
                    ec=blend_color(color, PAPER, 0.6),
                    hatch=hatch,
                    label=escape_math(says),
                )
            )
        axes.legend(
            handles=[*entries, *marks], loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=8.5,
            borderaxespad=0.0, labelspacing=0.7, handlelength=1.8, handleheight=1.2,
        )  # fmt: skip


def _join_row(xs: Sequence[AxisCell], row: Sequence[int]) -> list[tuple[float, float, int]]:
    """Join neighboring cells of one outcome to (left, right, outcome)."""
    joined: list[tuple[float, float, int]] = []
    for cell, outcome in zip(xs, row, strict=True):
        if joined and joined[-1][2] == outcome and joined[-1][1] == cell.low:
            joined[-1] = (joined[-1][0], cell.high, outcome)
        else:
            joined.append((cell.low, cell.high, outcome))
    return joined


def _middle(bound: BoundFeature, values: Sequence[float]) -> float:
    """Return the median of values, their mean direction or the most common label; NaN if most are absent."""
    present = [value for value in values if value == value]
    if 2 * len(present) < len(values) or not present:
        return float("nan")
    if isinstance(bound.kind, Categorical):
        return Counter(present).most_common(1)[0][0]
    if isinstance(bound.kind, Toroidal):
        turn = TAU / bound.kind.period
        return (phase(sum(rect(1.0, turn * value) for value in present)) / turn) % bound.kind.period
    return float(median(present))


def _parse_value(bound: BoundFeature, value: float | str) -> float:
    """Return a value given as a number, or as a label of a categorical feature."""
    if isinstance(bound.kind, Categorical) and isinstance(value, str):
        if value not in bound.kind.labels:
            raise UnknownName(what="label", name=value, where=f"feature {bound}", known=bound.kind.labels)
        return float(bound.kind.labels.index(value))
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise SettingError(
            where="plot of a lesson", setting=f"at[{str(bound)!r}]", problem=f"is {value!r}", remedy="give a number"
        ) from None  # fmt: skip
    return bound.kind.check(number, where=str(bound))


def draw_examples(
    axes: Axes, examples: Sequence[Example], places: Sequence[tuple[float, float]], states: Sequence[str]
) -> list[Artist]:
    """Draw examples at their places, and return the entries of a legend; `states` are those of the automaton.

    Further examples at one place are drawn as larger rings around the first.
    """
    groups = defaultdict[tuple[ExampleKind, int, int], list[tuple[float, float]]](list)
    crossed: list[tuple[float, float]] = []
    before = Counter[tuple[float, float]]()
    for example, place in zip(examples, places, strict=True):
        groups[example.kind, states.index(example.next), min(before[place], MOST_RINGS)].append(place)
        before[place] += 1
        if example.quarantined:
            crossed.append(place)
    for (kind, outcome, ring), group in groups.items():
        look = _look(kind, outcome)
        if ring:
            look |= {"ms": SIZE + RING * ring, "mfc": "none"}
        axes.plot(*zip(*group, strict=True), ls="", zorder=4 - 0.1 * ring, clip_on=False, **look)
    if crossed:
        axes.plot(*zip(*crossed, strict=True), ls="", zorder=5, clip_on=False, **_CROSS)
    return _list_entries({(kind, outcome) for kind, outcome, _ in groups}, states, crossed=bool(crossed))


def _look(kind: ExampleKind, outcome: int) -> dict[str, Any]:
    color = COLORS[outcome % len(COLORS)]
    filled = kind in (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION)
    size = SMALL if kind == ExampleKind.WATCHED else SIZE
    marker = MARKERS[outcome % len(MARKERS)]
    return {"marker": marker, "ms": size, "mfc": color if filled else PAPER, "mec": color, "mew": 1.4}


def _list_entries(
    kinds_and_outcomes: set[tuple[ExampleKind, int]], states: Sequence[str], *, crossed: bool
) -> list[Artist]:
    from matplotlib.lines import Line2D

    order = list(WORDS)
    entries: list[Artist] = [
        Line2D([], [], ls="", label=escape_math(f"{WORDS[kind]}: {states[outcome]}"), **_look(kind, outcome))
        for kind, outcome in sorted(kinds_and_outcomes, key=lambda each: (order.index(each[0]), each[1]))
    ]
    return [*entries, *([Line2D([], [], ls="", label="in quarantine", **_CROSS)] if crossed else [])]
