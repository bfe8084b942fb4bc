"""Counters, timers and the time in a state change in exported code as they do in the interpreter."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.export.exports import (
    BODY,
    WHOLE_KIT,
    count_mismatches,
    load_python,
    write_job,
)
from tests.export.recorded_answers import Ask

from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.target_files import ExportJob
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf

STATES = (
    START,
    *(State(name, name) for name in ("click", "lap", "unclick", "slip", "no_laps", "three_laps")),
)
FEATURES = tuple(
    BoundFeature(WHOLE_KIT.features[name]) for name in ("load", "watch", "laps", "bell", "time_in_state")
)
LOAD, WATCH, LAPS, BELL, TIME = range(5)
CLICK, LAP, UNCLICK, SLIP, NO_LAPS, THREE_LAPS = range(1, 7)


def draw_tree() -> Tree:
    """A tree that asks everything an automaton remembers, and goes to states that change it."""
    nodes = (
        Node(TestKind.BELOW, LOAD, high=0.5, yes=1, no=4, absent=9),
        Node(TestKind.ABSENT, WATCH, yes=10, no=2),  # not set: click
        Node(TestKind.BELOW, WATCH, high=0.25, yes=11, no=3, absent=15),  # just set: lap
        Node(TestKind.BELOW, LAPS, high=3.0, yes=12, no=14),  # few laps: unclick, else no_laps
        Node(TestKind.BELOW, LOAD, high=2.0, yes=5, no=8),
        Node(TestKind.ABSENT, BELL, yes=13, no=6),  # not set: slip
        Node(TestKind.BELOW, BELL, high=0.15, yes=15, no=7, absent=9),  # just set: three_laps
        Node(TestKind.BELOW, TIME, high=0.15, yes=9, no=14),
        Node(TestKind.BELOW, LAPS, high=1.0, yes=11, no=12),
    )
    outcomes = (STAY, CLICK, LAP, UNCLICK, SLIP, NO_LAPS, THREE_LAPS)
    return Tree((*nodes, *map(make_leaf, outcomes)))


def prepare(to: str, *, single: bool = False, stateless: bool = False) -> ExportJob:
    names = [state.name for state in STATES]
    transitions = dict.fromkeys(names, draw_tree()) if stateless else {name: draw_tree() for name in names}
    automaton = Automaton("a", STATES, FEATURES, (), stateless, transitions)
    library = Library.from_automata(WHOLE_KIT, automaton)
    job = prepare_export(
        library, "a", to=to, binding={}, body=BODY, fingerprint="drawn", single_precision=single
    )
    reached, leaves = job.conformance.leaves
    assert reached >= leaves - 2 * len(STATES)  # some states cannot be in with some memory
    return job


@pytest.mark.parametrize("stateless", [False, True], ids=["by state", "stateless"])
def test_in_python(stateless: bool) -> None:
    job = prepare("python", stateless=stateless)
    assert count_mismatches(load_python(job), job) == (len(job.conformance.ticks), 0)


@pytest.mark.parametrize("stateless", [False, True], ids=["by state", "stateless"])
@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_in_c(single: bool, stateless: bool, ask: Ask, tmp_path: Path) -> None:
    job = prepare("c99", single=single, stateless=stateless)
    assert ask("gcc", write_job(tmp_path, job, to="c99")).counts == (len(job.conformance.ticks), 0)


def test_in_documents(ask: Ask, tmp_path: Path) -> None:
    job = prepare("json", stateless=True)
    assert ask("node", write_job(tmp_path, job, to="json")).counts == (len(job.conformance.ticks), 0)
