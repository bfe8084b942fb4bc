"""What is infinite is absent: wherever readings enter, infinity of either sign decides as NaN does."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isinf, nan
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import RANGE, Scripted, kit
from tests.export.exports import BODY, load_python
from tests.runtime.random_libraries import Played, draw_library, draw_program, play_random_body, row

from understudy.addons.export.export_automaton import prepare_export
from understudy.judging.named_reading import find_reading
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import behavior
from understudy.model.binding import NOTHING_BOUND
from understudy.model.features import BoundFeature, Feature, Percept, feature
from understudy.model.library import Kit, Library
from understudy.model.squad import Statistic
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Kind, Toroidal
from understudy.runtime.engine.engine import Engine
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.runtime.team.comms import MemberReports
from understudy.runtime.team.members import AgentLayer, Member, MemberGroup, Membership
from understudy.runtime.team.statistics import compute_statistic
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

KINDS = {reading.name: reading.kind for reading in Played.readings}
TICKS, AGENTS = 20, 3


def spoil(percepts: Sequence[Percept], random: Random) -> tuple[list[Percept], list[Percept]]:
    """Make a share of the values of percepts NaN, and the same values infinite, of either sign."""
    absent: list[Percept] = []
    infinite: list[Percept] = []
    for percept in percepts:
        spoiled = {key: np.array([random.random() < 0.3 for _ in column]) for key, column in percept.items()}
        ends = {
            key: np.array([random.choice((inf, -inf)) for _ in column]) for key, column in percept.items()
        }
        absent.append({key: np.where(spoiled[key], nan, column) for key, column in percept.items()})
        infinite.append({key: np.where(spoiled[key], ends[key], column) for key, column in percept.items()})
    return absent, infinite


def play(seed: int) -> tuple[Random, Played, Played]:
    """A random body, with readings that are absent, and with the same ones infinite."""
    random = Random(seed)
    body = play_random_body(random, agents=AGENTS, ticks=TICKS)
    absent, infinite = (Played(each, body.ticks_s, body.time_s) for each in spoil(body.percepts, random))
    return random, absent, infinite


def list_paths(runs: Any, body: Played, program: Any) -> list[Any]:
    """What a run does at each tick: paths, and then what was commanded."""
    run = runs.from_program(body, program)
    paths = []
    for _ in range(TICKS):
        run.tick()
        paths.append([run.path(agent) for agent in range(AGENTS)])
    return [paths, body.commanded]


@pytest.mark.parametrize("runs", [Run, Engine])
@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=40)
def test_runs_and_engines(runs: Any, seed: int) -> None:
    random, absent, infinite = play(seed)
    program = draw_program(random, draw_library(random))
    assert list_paths(runs, infinite, program) == list_paths(runs, absent, program)


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=40)
def test_an_interpreter_alone(seed: int) -> None:
    """It is given rows by whoever likes."""
    random, absent, infinite = play(seed)
    program = draw_program(random, draw_library(random))
    one, other = Interpreter(program), Interpreter(program)
    for tick in range(TICKS):
        now = 0.1 * tick
        rows = [row(program, each.percepts[tick], 0) for each in (absent, infinite)]
        assert one.pulse(rows[0], now) == other.pulse(rows[1], now)
        assert one.path == other.path


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=20)
def test_exported_python(seed: int) -> None:
    random, absent, infinite = play(seed)
    library = draw_library(random)
    name = list(library.taught)[-1]
    binding = {each: random.choice(Played.targets) for each in library.parameters(name)}
    job = prepare_export(library, name, to="python", binding=binding, body=BODY, fingerprint="drawn")
    module = load_python(job)
    one, other = module.Machine(0.0), module.Machine(0.0)
    reference = Interpreter(link(library, name, binding))
    for tick in range(TICKS):
        given_rows = [
            {
                name: float(each.percepts[tick][slot.reading, slot.target][0])
                for name, slot in zip(module.READINGS, job.hierarchy.readings, strict=True)
            }
            for each in (absent, infinite)
        ]
        kept = dict(given_rows[1])
        assert one.step(given_rows[0], 0.1 * tick) == other.step(given_rows[1], 0.1 * tick)
        assert given_rows[1] == kept  # what it is given stays as it is
        reference.pulse(row(reference.program, infinite.percepts[tick], 0), 0.1 * tick)
        assert one.path() == other.path()
        assert tuple(other.path()[0]) == tuple(machine.state for machine in reference.active)


@pytest.mark.parametrize("end", [inf, -inf])
def test_conformance_rows_have_both_ends_of_every_number(end: float) -> None:
    random = Random(3)
    library = draw_library(random)
    name = list(library.taught)[-1]
    binding = dict.fromkeys(library.parameters(name), "ball")
    job = prepare_export(library, name, to="python", binding=binding, body=BODY, fingerprint="drawn")
    slots = job.hierarchy.readings
    numbers = [at for at, slot in enumerate(slots) if not isinstance(slot.kind, Categorical)]
    assert numbers
    assert all(any(tick.readings[at] == end for tick in job.conformance.ticks) for at in numbers)
    labels = set(range(len(slots))) - set(numbers)
    assert not any(isinf(tick.readings[at]) for tick in job.conformance.ticks for at in labels)


# Functions


@feature(Continuous())
def per_load(robot: Any) -> Any:
    """The range per load; infinite where the load is 0, and where the range is."""
    with np.errstate(all="ignore"):
        return robot.range_left / robot.load


@feature(Toroidal())
def backwards(robot: Any) -> Any:
    return robot.load + 3.0


@feature(BOOLEAN)
def is_there(robot: Any) -> Any:
    return np.where(np.isnan(robot.load), 0.0, 1.0)


@feature(BOOLEAN)
def is_label(robot: Any) -> Any:
    return robot.load


@behavior
def follow(robot: Any) -> Any:
    return {"drive": np.where(np.isnan(robot.load), -1.0, robot.load)}


class Loaded(Scripted):
    """Senses this load."""

    def __init__(self, load: Sequence[float]) -> None:
        super().__init__(len(load), {("load", None): lambda _: 0.0, ("seen", None): lambda _: 1.0})
        self.load = np.array(load, np.float64)

    def sense(self, keys: Sequence[tuple[str, str | None]]) -> Percept:
        found = {("load", None): self.load, ("range_left", None): np.ones(self.agents)}
        return {key: found[key] if key in found else np.ones(self.agents) for key in (*keys, *found)}


FUNCTIONS: list[tuple[Feature, list[float], list[float]]] = [  # load, value as a tree sees it
    (per_load, [0.0, -0.0, inf, 2.0], [nan, nan, nan, 0.5]),
    (backwards, [inf, -inf, nan, 1.0], [nan, nan, nan, 4.0]),
    (is_there, [inf, -inf, nan, 1.0], [0.0, 0.0, 0.0, 1.0]),
    (is_label, [inf, -inf, nan, 1.0], [nan, nan, nan, 1.0]),
]


@pytest.mark.parametrize(("part", "load", "expected"), FUNCTIONS)
def test_functions_see_and_give_absent_values(
    part: Feature, load: list[float], expected: list[float]
) -> None:
    """Absent goes to *off*; a value goes to *on*."""
    test = TestKind.LABEL if isinstance(part.kind, Categorical) else TestKind.BELOW
    node = Node(TestKind.BELOW, 0, high=100.0, yes=1, no=1, absent=2)
    if test is TestKind.LABEL:
        node = Node(TestKind.LABEL, 0, absent=2, branches=(2, 1))
    states = (START, State("on", "forward"), State("off", "left"))
    tree = Tree((node, make_leaf(1), make_leaf(2)))
    automaton = Automaton("a", states, (BoundFeature(part),), transitions={"start": tree})
    program = link(Library.from_automata(kit + Kit.from_parts(part), automaton), "a")
    for runs in (Run, Engine):
        run = runs.from_program(Loaded(load), program)
        run.tick()
        went = [run.path(agent) == ("on",) for agent in range(len(load))]
        assert went == [value == value and value != 0.0 for value in expected]


@pytest.mark.parametrize("runs", [Run, Engine])
def test_behaviors_see_absent_values(runs: Any) -> None:
    body = Loaded([inf, -inf, nan, 0.25])
    runs.from_program(body, link(Library(kit + Kit.from_parts(follow)), "follow")).tick()
    assert body.commanded[0]["drive"] == [-1.0, -1.0, -1.0, 0.25]


# Conditions


NAMED: list[tuple[str, Kind]] = [("load", Continuous()), ("seen", BOOLEAN)]


@pytest.mark.parametrize(("name", "kind"), NAMED)
def test_readings_in_conditions(name: str, kind: Kind) -> None:
    body = Loaded([0.0] * 3)
    reading = find_reading(name, Library(Kit.from_parts()), body, binding=NOTHING_BOUND, where="the body")
    assert reading.kind == kind
    values = reading.read({(name, None): np.array([inf, -inf, 1.0])})
    assert np.array_equal(values, [nan, nan, 1.0], equal_nan=True)


def test_features_in_conditions() -> None:
    body = Loaded([inf, -inf, 1.0])
    reading = find_reading("load", Library(kit), body, binding=NOTHING_BOUND, where="the body")
    assert reading.feature is not None
    assert np.array_equal(reading.read(body.sense(reading.keys)), [nan, nan, 1.0], equal_nan=True)


# What members report, and what a lesson keeps


def test_what_members_report() -> None:
    """A member whose reading is infinite says nothing about it, as one whose reading is absent."""
    roster = Membership.from_squads([[Member(0, 0, 0), Member(0, 1, 0), Member(0, 2, 0)]])
    body = Loaded([inf, -inf, 2.0])
    layer = AgentLayer(body, Run.from_program(body, link(Library(kit), "forward")))
    layer.percept = body.sense([("load", None)])
    reports = MemberReports(
        roster,
        [MemberGroup("robot", layer, lambda name, binding: link(Library(kit), name, binding))],
        None,
        None,
        0.1,
    )
    values = reports.readings(("load", None), 0.0)
    assert np.array_equal(values, [nan, nan, 2.0], equal_nan=True)
    measured: dict[Any, float] = {"mean": 2.0, "minimum": 2.0, "maximum": 2.0, "spread": 0.0, "count": 1.0}
    for how, expected in measured.items():
        statistic = Statistic("s", how, "load", below=9.0 if how == "count" else None)
        found = compute_statistic(statistic, values, np.ones(3, np.bool_), roster, Continuous())
        assert found.tolist() == [expected]


@pytest.mark.parametrize("end", [inf, -inf])
def test_a_lesson_keeps_absent_values(end: float) -> None:
    library = Library(kit)
    design: Any = {"states": ["forward", "left"], "features": ["load", "range_of(ball)"]}
    examples = []
    for value in (end, nan):
        loads = (value,) * 3 + (1.0,) * 10
        body = Scripted(1, {**RANGE, ("load", None): loads.__getitem__})
        session = Session(body, library, new_lesson(library, "go", **design))
        for state in ("forward", "left"):
            session.direct(state)
            for _ in range(4):
                session.tick()
        examples.append(repr([each.values for each in session.lesson.examples]))
        record = session.lesson.record
        assert not np.isinf(record.values).any()
        session.test()
        session.tick()
    assert examples[0] == examples[1]
