"""Foragers with planted failures, for the tests of falsification."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from tests.ui.cli.forage_parts import AUTOMATA, goto

from understudy.addons.checks.falsification.trial import GoalMeasure
from understudy.judging.evaluate import make_evaluation_task
from understudy.model.automaton import Automaton
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT

FORAGE = find_scenario("forage")
TOO_FAR = 9.0
"""The distance, m, from which on the planted goto does not start: about one world in 15 has such a way."""


def plant_idleness(distance: float) -> Automaton:
    """Make a goto that never starts where its target is at least so far (m) away."""
    far = Tree((Node(TestKind.BELOW, 0, high=distance, yes=1, no=2), make_leaf(1), make_leaf(STAY)))
    return replace(goto, transitions=MappingProxyType({**goto.transitions, "start": far}))


def make_library(distance: float) -> Library:
    """Make a library whose forager fails where it has so far (m) to go."""
    return Library.from_automata(FORAGE_KIT, plant_idleness(distance), *AUTOMATA[1:])


def make_measure(distance: float = TOO_FAR, limit_s: float | None = 600.0) -> GoalMeasure:
    """Make the measure of such a forager."""
    return GoalMeasure(make_evaluation_task(make_library(distance), "forage", FORAGE), limit_s)
