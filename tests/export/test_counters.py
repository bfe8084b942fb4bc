"""Counters that change by the largest numbers allowed: all targets count them as the interpreter does."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from tests.export.exports import count_mismatches, load_python, write_job
from tests.export.recorded_answers import Ask

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.target_files import ExportJob
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import MOST_COUNTED, Behavior, increment, set_counter
from understudy.model.features import BoundFeature, CounterFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Continuous
from understudy.runtime.body import Channel, Reading

READINGS = (Reading("x", Continuous(), "m"),)
KIT = Kit.from_parts(
    Feature("x", Continuous(), "x", unit="m"),
    CounterFeature("laps"),
    Behavior("add", changes=(increment("laps", MOST_COUNTED),)),
    Behavior("drop", changes=(set_counter("laps", -MOST_COUNTED),)),
)


@cache
def prepare(to: str) -> ExportJob:
    """An automaton whose counter grows to three times 2**53, state by state, and then begins at -2**53 again."""
    states = (START, State("one", "add"), State("other", "add"), State("down", "drop"))

    def ask_x(following: int) -> Tree:
        return Tree(
            (
                Node(TestKind.BELOW, 1, high=2.5 * MOST_COUNTED, yes=1, no=3, absent=4),
                Node(TestKind.BELOW, 0, high=1.0, yes=2, no=4, absent=4),
                make_leaf(following),
                make_leaf(3),
                make_leaf(0),
            )
        )

    features = tuple(BoundFeature(KIT.features[name]) for name in ("x", "laps"))
    transitions = {"start": ask_x(1), "one": ask_x(2), "other": ask_x(1), "down": ask_x(2)}
    automaton = Automaton("a", states, features, transitions=transitions)
    return prepare_export(
        Library.from_automata(KIT, automaton), "a", to=to, binding={},
        body=BodyInterface(READINGS, (Channel("drive"),)), fingerprint="drawn", single_precision=False,
    )  # fmt: skip


def test_in_python() -> None:
    job = prepare("python")
    assert {tick.expected.path for tick in job.conformance.ticks} == {(0,), (1,), (2,), (3,)}
    assert count_mismatches(load_python(job), job) == (len(job.conformance.ticks), 0)


PEERS = [
    ("c99", "gcc"),
    ("json", "node"),
    ("xstate", "xstate"),
    ("scxml", "qt"),
    ("btcpp", "behaviortreepy"),
]


@pytest.mark.parametrize(("to", "peer"), PEERS)
def test_with_other_programs(to: str, peer: str, ask: Ask, tmp_path: Path) -> None:
    job = prepare(to)
    assert ask(peer, write_job(tmp_path, job, to=to)).counts == (len(job.conformance.ticks), 0)
