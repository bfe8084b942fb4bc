"""The hand-written standard task (`_handwritten_kernels`) as a benchmark subject: an upper bound on speed."""

from __future__ import annotations

from math import cos, radians, sin
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.behaviors import Behavior
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.model.tree import Node, TestKind
from understudy_lab.bench import standard_task

READINGS: dict[tuple[str, str | None], int] = {
    ("range", "beacon"): 0,
    ("bearing", "beacon"): 1,
    ("range", "robot"): 2,
    ("bearing", "robot"): 3,
    **{(name, None): 4 + index for index, name in enumerate(standard_task.SECTORS)},
}

LEVELS = 4
SORTED_EVERY = 20
"""The ticks between two sortings of the robots by cell, which keep neighbors close in memory."""


class HandwrittenBaseline:
    """N robots that run one behavior of a library of the standard task."""

    def __init__(
        self, robots: int, library: Library, behavior: str, *, sonar: bool, threads: int = 1
    ) -> None:
        self.robots, self.threads = robots, threads
        self.table = table(library)
        self.root = int(self.table[5][list(library.taught).index(behavior)])
        side = standard_task.side(robots)
        cells = max(1, int(np.ceil(side / 2.0)))
        self.sizes = (
            side,
            standard_task.RADIUS,
            standard_task.SIGHT,
            standard_task.SONAR_RANGE,
            standard_task.STEP,
            standard_task.TURN,
        )
        edges = [
            [f(radians(angle)) for angle in sector for f in (cos, sin)]
            for sector in standard_task.SECTORS.values()
        ]
        self.edges = np.array(edges if sonar else np.empty((0, 4)))
        self.gridded = (
            cells,
            np.zeros(cells * cells + 1, np.int64),
            np.zeros(robots, np.int64),
            np.zeros(robots),
            np.zeros(robots),
        )
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Restore the start."""
        start = standard_task.StartLayout.of(self.robots, seed)
        self.place = np.array([start.x, start.y, start.heading])
        self.moved = np.empty_like(self.place)
        self.beacons = np.column_stack([start.beacon_x, start.beacon_y])
        sizes = np.full(standard_task.OBSTACLES, standard_task.OBSTACLE_RADIUS)
        self.obstacles = np.column_stack([start.obstacle_x, start.obstacle_y, sizes])
        self.stack = np.full((self.robots, LEVELS), self.root, np.int32)
        self.tick = 0

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        from understudy_lab.bench import _handwritten_kernels as kernels

        before = kernels.limit_threads(self.threads)
        for _ in range(ticks):
            kernels.grid(self.place[0], self.place[1], *self.gridded)
            if self.tick % SORTED_EVERY == 0:
                self._sort()
            kernels.step(
                8 * self.threads,
                self.place,
                self.moved,
                self.stack,
                self.beacons,
                self.obstacles,
                self.edges,
                self.sizes,
                self.table,
                self.gridded,
            )
            self.place, self.moved = self.moved, self.place
            self.tick += 1
        kernels.limit_threads(before)

    def _sort(self) -> None:
        members = self.gridded[2]
        self.place = np.ascontiguousarray(self.place[:, members])
        self.stack = self.stack[members]
        members[:] = np.arange(self.robots)


Table: TypeAlias = tuple[NDArray[Any], ...]


def table(library: Library) -> Table:
    """Return the automata of a library as flat arrays; states are numbered across all automata.

    Nodes have (test, feature, yes, no) and (low, high); for a leaf, `yes` is a state. States have the root of their
    tree, the automaton below, the flag raised, and the command (drive, turn). The last array holds the start state of
    each automaton.
    """
    automata = [taught.automaton for taught in library.taught.values()]
    names = [automaton.name for automaton in automata]
    states = [state for automaton in automata for state in automaton.states]
    starts = np.cumsum([0, *(len(automaton.states) for automaton in automata)])[:-1]
    flags = list(dict.fromkeys(state.flag for state in states if state.flag))
    tests: list[tuple[int, int, int, int]] = []
    numbers: list[tuple[float, float]] = []
    roots: list[int] = []
    for automaton, start in zip(automata, starts.tolist(), strict=True):
        features = [_number(bound, flags) for bound in automaton.features]
        for state in automaton.states:
            tree = automaton.transitions.get(state.name)
            roots.append(len(tests) if tree else -1)
            for node in getattr(tree, "nodes", ()):
                tests.append(_test(node, features, start=start, first=roots[-1]))
                numbers.append((node.low, node.high))
    commands = []
    for state in states:
        basic = library.kit.behaviors.get(state.behavior or "", Behavior("idle"))
        commands.append([basic.command.get("drive", 0.0), basic.command.get("turn", 0.0)])
    below = [names.index(state.behavior) if state.behavior in names else -1 for state in states]
    return (
        np.array(tests, np.int32),
        np.array(numbers),
        np.array(roots, np.int32),
        np.array(below, np.int32),
        np.array([flags.index(state.flag) if state.flag else -1 for state in states], np.int32),
        starts.astype(np.int32),
        np.array(commands),
    )


def _number(bound: BoundFeature, flags: list[str]) -> int:
    if isinstance(bound.feature, Feature):
        target = bound.binding[bound.feature.of] if bound.feature.of else None
        return READINGS[bound.feature.reading or "", target]
    return len(READINGS) + flags.index(bound.feature.name)


def _test(node: Node, features: list[int], *, start: int, first: int) -> tuple[int, int, int, int]:
    if node.test == TestKind.LEAF:
        return TestKind.LEAF, 0, start + node.yes, 0
    yes, no = (node.branches[1], node.branches[0]) if node.test == TestKind.LABEL else (node.yes, node.no)
    kind = TestKind.ARC if node.test == TestKind.ARC else TestKind.BELOW
    return kind, features[node.feature], first + yes, first + no
