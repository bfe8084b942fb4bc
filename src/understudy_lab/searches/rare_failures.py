"""Foragers that fail in about one of a thousand worlds, made from a taught one by two rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log
from types import MappingProxyType

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import GoalMeasure, TrialResults
from understudy.judging.evaluate import make_evaluation_task
from understudy.model.automaton import Automaton
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree
from understudy.model.value_kinds import Column
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import Scenario

SLOW, CIRCLING = "slow", "circling"
SCENARIO: Scenario = find_scenario("forage")
WANTED_SHARE = 0.001
"""The share of worlds in which each robot is to fail."""
CALIBRATION_WORLDS: Mapping[str, int] = MappingProxyType({SLOW: 20_000, CIRCLING: 4_000})
"""The number of worlds by which the limit, or the distance, is chosen."""
NEAREST_M, FARTHEST_M = 0.02, 0.4
"""The range in which the distance is looked for, m."""
HALVINGS = 14
"""The number of times that the range is halved, to 0.02 mm: within 0.3 mm, the share went from none to 1.4 %."""
CIRCLING_LIMIT_S = 600.0
"""The time limit of circling robots, s: about twice that of slow ones."""
ARRIVED_M = 1.0
"""The distance up to which the tests for distances in a GoTo's trees decide whether it has arrived, m."""


@dataclass(frozen=True, slots=True)
class RareFailure:
    """A robot that seldom fails, as a measure for searches.

    `setting` is the time limit of a slow robot, s, or the distance at which a circling one has arrived, m. It fails in
    `failed` of the worlds by which the setting was chosen.
    """

    measure: GoalMeasure
    setting: float
    failed: int


def make_slow(library: Library, seeds: Sequence[int]) -> RareFailure:
    """Set the time limit of a forager such that it is exceeded in one of a thousand of these worlds."""
    times_s = find_times(run_forager(make_measure(library), seeds))
    limit_s = choose_limit(times_s)
    return RareFailure(make_measure(library, limit_s), limit_s, int((times_s > limit_s).sum()))


def make_circling(library: Library, seeds: Sequence[int]) -> RareFailure:
    """Set the distance at which a forager has arrived so small that it circles forever in one of a thousand worlds."""

    def make(distance_m: float) -> GoalMeasure:
        changed = set_arrival_distance(library.automaton("goto"), distance_m)
        return make_measure(library.with_automaton(TrainedAutomaton(changed)), CIRCLING_LIMIT_S)

    distance_m, failed = choose_distance(
        lambda distance_m: int(run_forager(make(distance_m), seeds).failed.sum()), worlds=len(seeds)
    )
    return RareFailure(make(distance_m), distance_m, failed)


MAKERS: Mapping[str, Callable[[Library, Sequence[int]], RareFailure]] = MappingProxyType(
    {SLOW: make_slow, CIRCLING: make_circling}
)
"""The function for each rule that makes a robot from a library and the seeds of worlds."""


def make_measure(library: Library, limit_s: float | None = None) -> GoalMeasure:
    """Make the measure of the foraging of a library with a time limit, s; None: that of the scenario."""
    return GoalMeasure(make_evaluation_task(library, "forage", SCENARIO), limit_s)


def run_forager(measure: GoalMeasure, seeds: Sequence[int]) -> TrialResults:
    """Run a forager in the worlds of these seeds."""
    return measure([Trial(SCENARIO, seed) for seed in seeds])


def find_times(results: TrialResults) -> Column:
    """Find the times of runs [n], s; infinity for those that did not reach the goal."""
    return np.where(results.failed, np.inf, results.progress_s)


def choose_limit(times_s: Column) -> float:
    """Choose the least of these times (s) that at most the wanted share of them exceeds.

    If more runs never reach the goal, it is the longest time of those that do.
    """
    finite = times_s[np.isfinite(times_s)]
    limit_s = np.quantile(times_s, 1.0 - WANTED_SHARE, method="inverted_cdf")
    return float(min(limit_s, finite.max()))


def find_arrival_tests(automaton: Automaton) -> list[float]:
    """Find the distances of all tests in a GoTo's trees that decide whether it has arrived, m."""
    return [
        node.high
        for tree in automaton.transitions.values()
        if isinstance(tree, Tree)
        for node in tree.nodes
        if _is_arrival_test(node, automaton)
    ]


def set_arrival_distance(automaton: Automaton, distance_m: float) -> Automaton:
    """Return a GoTo whose tests that decide whether it has arrived are all for this distance, m."""

    def change(tree: Tree) -> Tree:
        return Tree(
            tuple(
                node._replace(high=distance_m) if _is_arrival_test(node, automaton) else node
                for node in tree.nodes
            )
        )

    changed = {
        state: change(tree) if isinstance(tree, Tree) else tree
        for state, tree in automaton.transitions.items()
    }
    return replace(automaton, transitions=MappingProxyType(changed))


def _is_arrival_test(node: Node, automaton: Automaton) -> bool:
    is_distance = node.test == TestKind.BELOW and (
        automaton.features[node.feature].feature.name == "distance_to"
    )
    return is_distance and node.high <= ARRIVED_M


def choose_distance(count_failures: Callable[[float], int], *, worlds: int) -> tuple[float, int]:
    """Choose a distance for which a robot fails in about the wanted share of worlds, by halving a range.

    Parameters
    ----------
    count_failures
        Returns the number of failing worlds for a distance, m. It falls with the distance.
    worlds
        The number of worlds.

    Returns
    -------
    tuple[float, int]
        Of the distances that were tried, the one whose failures are nearest to the wanted number, by their ratio with
        half a failure added to both; and its failures.
    """
    low, high, wanted = NEAREST_M, FARTHEST_M, WANTED_SHARE * worlds
    tried: list[tuple[float, int]] = []
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        failed = count_failures(middle)
        tried.append((middle, failed))
        low, high = (middle, high) if failed > wanted else (low, middle)
    return min(tried, key=lambda each: abs(log((each[1] + 0.5) / (wanted + 0.5))))
