"""Quotients and differences of readings in exports: all targets compute them as the interpreter does."""

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
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target
from understudy.model.features import Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.runtime.body import Channel, Reading
from understudy.training.lesson_design import parse_feature

READINGS = (
    Reading("range", Continuous(), "m", of_targets=True),
    Reading("speed", Continuous(), "m/s"),
    Reading("x", Continuous(), "m"),
    Reading("heading", Toroidal(), "rad"),
    Reading("bearing", Toroidal(), "rad", of_targets=True),
)
KIT = Kit.from_parts(
    *(
        Feature(each.name, each.kind, each.name, of="A" if each.of_targets else None, unit=each.unit)
        for each in READINGS
    ),
    Behavior("go", Command(drive=1.0)),
    Target("ball"),
)
PAIRS = ("range(ball) / speed", "(range(ball) - x) / speed", "heading - bearing(ball)")


@cache
def prepare(to: str, *, single: bool = False) -> ExportJob:
    """An automaton that goes or not, by quotients, by a quotient of a difference, and by a difference of angles."""
    tree = Tree(
        (
            Node(TestKind.BELOW, 0, high=1.25, yes=4, no=1, absent=3),
            Node(TestKind.BELOW, 1, high=-0.5, yes=3, no=2, absent=4),
            Node(TestKind.ARC, 2, 5.0, 1.0, 4, 3, 3),
            make_leaf(0),
            make_leaf(1),
        )
    )
    features = tuple(parse_feature(Library(KIT), each) for each in PAIRS)
    states = (START, State("go", "go"))
    automaton = Automaton("a", states, features, transitions={"start": tree, "go": tree})
    job = prepare_export(
        Library.from_automata(KIT, automaton), "a", to=to, binding={},
        body=BodyInterface(READINGS, (Channel("drive"),)), fingerprint="drawn", single_precision=single,
    )  # fmt: skip
    assert job.hierarchy.functions_to_write == ()
    assert {str(each) for each in job.hierarchy.readings} == {
        "range(ball)", "speed", "x", "heading", "bearing(ball)"
    }  # fmt: skip
    return job


def test_in_python() -> None:
    job = prepare("python")
    assert {tick.expected.path for tick in job.conformance.ticks} == {(0,), (1,)}
    speed = [str(each) for each in job.hierarchy.readings].index("speed")
    assert {0.0, 1.0} & {tick.readings[speed] for tick in job.conformance.ticks} >= {0.0}
    assert count_mismatches(load_python(job), job) == (len(job.conformance.ticks), 0)


PEERS = [
    ("c99", "gcc", False),
    ("c99", "gcc", True),
    ("json", "node", False),
    ("xstate", "xstate", False),
    ("scxml", "qt", False),
    ("btcpp", "behaviortreepy", False),
]


@pytest.mark.parametrize(("to", "peer", "single"), PEERS)
def test_with_other_programs(to: str, peer: str, single: bool, ask: Ask, tmp_path: Path) -> None:
    job = prepare(to, single=single)
    assert ask(peer, write_job(tmp_path, job, to=to)).counts == (len(job.conformance.ticks), 0)
