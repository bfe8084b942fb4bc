"""A session that begins before a failure: the robot stands, reads and decides as it did in the run that failed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from msgspec.structs import replace as with_changes
from tests.falsification.planted import FORAGE
from tests.make.goto_sessions import make_goto_session as goto_lesson
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.addons.checks.falsification.failing_world import FailingWorld, FailureFacts
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.open_failure import open_failure
from understudy.addons.checks.falsification.trial import GoalMeasure
from understudy.errors import SessionError, UnknownName
from understudy.judging.evaluate import make_evaluation_task
from understudy.learning.fit import learn
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.world import World
from understudy.training.trainee import Mode

SEED, BEFORE_S, LIMIT_S = 3, 2.0, 60.0


@pytest.fixture
def library() -> Library:
    """A library whose goto was never shown a target to its right."""
    lesson = goto_lesson()
    taught = TrainedAutomaton(replace(lesson.automaton, transitions=dict(learn(lesson))), lesson)
    whole = Library(FORAGE_KIT).with_automaton(taught)
    for automaton in AUTOMATA[1:]:
        whole = whole.with_automaton(TrainedAutomaton(automaton))
    return whole


@pytest.fixture
def failing_world(library: Library) -> FailingWorld:
    """A world in which its forager gets stuck after 5 s or later."""
    measure = GoalMeasure(make_evaluation_task(library, "forage", FORAGE), LIMIT_S)
    trial = Trial(FORAGE, SEED)
    assert measure([trial]).failed.all()
    facts = FailureFacts(
        behavior="forage",
        binding={},
        seed=SEED,
        limit_s=LIMIT_S,
        robustness=-1.0,
        wrong_s=5.0,
        end_hash="",
        found_by="random",
        steps=(),
        why=(),
    )
    return FailingWorld(Path("nowhere"), trial, facts)


def place(world: World) -> tuple[float, float, float]:
    """Where the robot is."""
    robots = world.view().robots
    return float(robots.x[0]), float(robots.y[0]), float(robots.heading[0])


def test_it_begins_as_the_run_was_and_goes_on_like_it(library: Library, failing_world: FailingWorld) -> None:
    session = open_failure(failing_world, library, before_s=BEFORE_S)
    assert (session.automaton.name, session.mode, session.view().targets) == (
        "goto",
        Mode.LIVE,
        {"A": "nearest_food"},
    )
    world = World(FORAGE, [SEED])
    engine = Engine.from_program(world, link(library, "forage", {}))
    for _ in range(round((5.0 - BEFORE_S) / world.tick_s)):
        engine.tick()
    assert isinstance(session.body, World)
    for _ in range(20):
        assert place(session.body) == place(world)
        assert session.view().state == engine.path(0)[-1]
        session.tick()
        engine.tick()
    assert session.lesson.examples == goto_lesson().examples


def test_it_begins_at_the_start_if_the_first_decision_was_wrong(
    library: Library, failing_world: FailingWorld
) -> None:
    early = replace(failing_world, facts=with_changes(failing_world.facts, wrong_s=0.1))
    session = open_failure(early, library, before_s=BEFORE_S)
    world = World(FORAGE, [SEED])
    engine = Engine.from_program(world, link(library, "forage", {}))
    assert isinstance(session.body, World)
    assert (session.automaton.name, session.view().state, session.body.time_s) == ("goto", "start", 0.0)
    for _ in range(20):
        assert place(session.body) == place(world)
        session.tick()
        engine.tick()
        assert session.view().state == engine.path(0)[-1]


def test_a_press_corrects_it(library: Library, failing_world: FailingWorld) -> None:
    session = open_failure(failing_world, library, before_s=BEFORE_S)
    before = session.view().state
    session.direct("left" if before != "left" else "forward")
    session.tick()
    assert len(session.lesson.examples) > len(goto_lesson().examples)
    corrected = library.with_automaton(session.make_trained_automaton())
    assert corrected.taught["goto"].automaton != library.taught["goto"].automaton


def test_it_can_begin_on_another_level(library: Library, failing_world: FailingWorld) -> None:
    with pytest.raises(SessionError, match="'harvest' has no lesson"):
        open_failure(failing_world, library, name="harvest")
    with pytest.raises(UnknownName, match="deposit"):
        open_failure(failing_world, library, name="deposit")
