"""Plot decision trees with matplotlib: tests from the left to the right, outcomes in a column of boxes each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, Node, TestKind, Tree
from understudy.model.tree_regions import find_known_absent, list_yes_values
from understudy.model.tree_text import FeatureText, list_cuts
from understudy.model.value_kinds import Categorical
from understudy.viz.axes import (
    make_picture_axes,
    measure_points_per_unit,
    measure_text,
    open_picture,
    write_scaled_text,
)
from understudy.viz.palette import COLORS, FAINT, INK, PAPER, blend_color

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TEXT, SIDE_TEXT = 13.0, 11.0
BOX_TALL, ROW_TALL, GAP, MARGIN = 28.0, 40.0, 34.0, 16.0
NEVER_SHOWN = "stays: never shown"


@dataclass
class _TreeBox:
    """A node as it is drawn: its text, the outcome of a leaf, and the boxes to its right with what leads there."""

    text: str
    outcome: int | None
    depth: int
    below: list[tuple[str, _TreeBox]]
    row: float = 0.0

    def list_boxes(self) -> list[_TreeBox]:
        """List this box and all that follow, parents before their children."""
        boxes, waiting = list[_TreeBox](), [self]  # no recursion: noise grows trees deep
        while waiting:
            box = waiting.pop()
            boxes.append(box)
            waiting.extend(following for _, following in reversed(box.below))
        return boxes


def plot_tree(
    tree: Tree,
    ax: Axes | None = None,
    *,
    features: Sequence[BoundFeature] = (),
    states: Sequence[str] = (),
    vectors: Sequence[Sequence[float]] = (),
) -> Axes:
    """Plot a tree; features and states without a name are numbered from 1.

    Thresholds are rounded such that the given feature vectors stay on their sides.
    """
    boxes = _arrange(_make_boxes(tree, _NodeText(tree, features, states, vectors)))
    depths = range(1 + max(box.depth for box in boxes))
    levels = [[box for box in boxes if box.depth == depth] for depth in depths]
    widths = [max(_box_width(box) for box in level) for level in levels]
    gaps = [
        GAP
        + max((measure_text(label, SIDE_TEXT, False) for box in level for label, _ in box.below), default=0.0)
        for level in levels
    ]
    lefts = [MARGIN + sum(widths[:depth]) + sum(gaps[:depth]) for depth in depths]
    width = lefts[-1] + widths[-1] + MARGIN
    height = 2 * MARGIN + ROW_TALL * (1 + max(box.row for box in boxes))
    axes = make_picture_axes(width, height) if ax is None else ax
    open_picture(axes, width, height)
    for box in boxes:
        for label, following in box.below:
            _branch(axes, box, following, label, lefts, widths)
        _box(axes, box, lefts[box.depth])
    return axes


class _NodeText:
    """The texts in the boxes of a tree and beside its branches."""

    def __init__(
        self,
        tree: Tree,
        features: Sequence[BoundFeature],
        states: Sequence[str],
        vectors: Sequence[Sequence[float]],
    ) -> None:
        self._features, self._states = features, states
        used = max(len(features), 1 + max(node.feature for node in tree.nodes))
        self._absent = find_known_absent(tree, used)
        columns = list(zip(*vectors, strict=True)) or [()] * len(features)
        rows = zip(features, list_cuts(tree, used), self._absent, columns, strict=False)
        self._words = [
            FeatureText(bound, cuts, known_absent=absent, values=there) for bound, cuts, absent, there in rows
        ]

    def name(self, feature: int) -> str:
        return str(self._features[feature]) if feature < len(self._features) else f"feature {feature + 1}"

    def outcome(self, outcome: int) -> str:
        if outcome == STAY:
            return "stay"
        return self._states[outcome] if outcome < len(self._states) else f"state {outcome + 1}"

    def test(self, node: Node) -> str:
        name = self.name(node.feature)
        if node.test == TestKind.LABEL:
            return f"{name} is …"
        if node.feature < len(self._features):
            return self._words[node.feature].statement(
                list_yes_values(node, self._features[node.feature].kind)
            )
        if node.test == TestKind.ABSENT:
            return f"{name} is absent"
        if node.test == TestKind.BELOW:
            return f"{name} is below {node.high:.3g}"
        if node.low <= node.high:
            return f"{name} is between {node.low:.3g} and {node.high:.3g}"
        return f"{name} is at least {node.low:.3g} or below {node.high:.3g}"

    def label(self, node: Node, index: int) -> str:
        kind = self._features[node.feature].kind if node.feature < len(self._features) else None
        return kind.labels[index] if isinstance(kind, Categorical) else f"label {index + 1}"

    def branches(self, node: Node) -> list[tuple[str, int]]:
        """Return what leads to each child, and the child's index; absence where it was shown."""
        ways: dict[int, list[str]] = {}
        unknown: list[tuple[str, int]] = []
        sides = [("yes", node.yes), ("no", node.no)]
        if node.test == TestKind.LABEL:
            sides = [(self.label(node, index), child) for index, child in enumerate(node.branches)]
        if node.test != TestKind.ABSENT and self._absent[node.feature]:
            sides.append(("absent", node.absent))
        for text, child in sides:
            if child == STAY:
                unknown.append((text, child))
            else:
                ways.setdefault(child, []).append(text)
        return [(" or ".join(texts), child) for child, texts in ways.items()] + (
            [(" or ".join(text for text, _ in unknown), STAY)] if unknown else []
        )


def _make_boxes(tree: Tree, words: _NodeText) -> _TreeBox:
    def make(index: int, depth: int) -> _TreeBox:
        if index == STAY:
            return _TreeBox(NEVER_SHOWN, STAY, depth, [])
        node = tree.nodes[index]
        if node.test == TestKind.LEAF:
            return _TreeBox(words.outcome(node.yes), node.yes, depth, [])
        return _TreeBox(words.test(node), None, depth, [])

    root = make(0, 0)
    waiting = [(0, root)]
    while waiting:
        index, box = waiting.pop()
        if index == STAY or tree.nodes[index].test == TestKind.LEAF:
            continue
        for text, child in words.branches(tree.nodes[index]):
            following = make(child, box.depth + 1)
            box.below.append((text, following))
            waiting.append((child, following))
    return root


def _arrange(root: _TreeBox) -> list[_TreeBox]:
    """Give each leaf a row of its own and each test the middle of what follows it; return all boxes."""
    boxes, row = root.list_boxes(), 0.0
    for box in boxes:
        if not box.below:
            box.row, row = row, row + 1
    for box in reversed(boxes):
        if box.below:
            box.row = (box.below[0][1].row + box.below[-1][1].row) / 2
    return boxes


def _box_width(box: _TreeBox) -> float:
    return measure_text(box.text, TEXT, box.outcome is not None) + 24


def _middle(box: _TreeBox) -> float:
    return MARGIN + ROW_TALL * (box.row + 0.5)


def _branch(
    axes: Axes,
    box: _TreeBox,
    following: _TreeBox,
    label: str,
    lefts: Sequence[float],
    widths: Sequence[float],
) -> None:
    start = lefts[box.depth] + _box_width(box)
    end, y, to_y = lefts[following.depth], _middle(box), _middle(following)
    turn = lefts[box.depth] + widths[box.depth] + 14
    thick = measure_points_per_unit(axes)
    axes.plot([start, turn, turn, end], [y, y, to_y, to_y], color=FAINT, lw=1.4 * thick, zorder=1)
    write_scaled_text(axes, turn + 6, to_y - 4, label, SIDE_TEXT, color=FAINT)


def _box(axes: Axes, box: _TreeBox, left: float) -> None:
    from matplotlib.patches import FancyBboxPatch

    wide = _box_width(box)
    color = (
        INK if box.outcome is None else FAINT if box.outcome == STAY else COLORS[box.outcome % len(COLORS)]
    )
    fill = PAPER if box.outcome is None else blend_color(color, PAPER, 0.12)
    y, thick = _middle(box), measure_points_per_unit(axes)
    rounding = 4 if box.outcome is None else 12
    never = box.text == NEVER_SHOWN
    shape = FancyBboxPatch(
        (left + 12, y - BOX_TALL / 2 + 12), wide - 24, BOX_TALL - 24, boxstyle=f"round,pad=12,rounding_size={rounding}",
        fc=fill, ec=color, lw=1.5 * thick, ls=(0.0, (3.0, 2.0)) if never else "-", zorder=3,
    )  # fmt: skip
    axes.add_patch(shape)
    write_scaled_text(
        axes, left + 12, y + 4.6, box.text, TEXT, bold=box.outcome is not None, color=FAINT if never else INK
    )
