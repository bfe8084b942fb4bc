"""A chosen goal among other agents: that of a robot is about this robot, that of a coordinator about its robots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.falsification.test_session_setup import find_setup, teach_second_coordinator
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import offer_session_goals
from understudy.judging.properties.free_space import make_clearance, make_covered
from understudy.model.value_kinds import Column
from understudy.sim.kernels.dtypes import TOUCH
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

SEEDS, TICKS, AREA = range(20), 600, 3.0


def teach_robot(state: str, others: str | None) -> Session:
    """The third of four robots does one thing for good, and so do the others."""
    lesson = new_lesson(ROBOTS, "roam", states=[state], features=["sonar_rear"], live=True)
    session = Session(World(SCENARIO, [1]), ROBOTS, lesson, agent=2)
    session.set_other_agents(others)
    session.direct(state)
    session.tick()
    return session


def run_all(session: Session) -> tuple[Column, Column]:
    """Run the worlds; return the least free space of each robot, and the ground that it has covered [B, n]."""
    setup, library = find_setup(session)
    run = setup.start(SEEDS, library, session.automaton.name, {})
    assert isinstance(run.body, World)
    clearance, covered = make_clearance(run.body), make_covered(run.body)
    free, area = clearance(), covered()
    for _ in range(TICKS):
        run.advance(1)
        free, area = np.minimum(free, clearance()), covered()
    return free, area


SESSIONS: list[tuple[str, Callable[[], Session], list[int]]] = [
    ("turns beside idle robots", lambda: teach_robot("left", None), [2]),
    ("turns beside robots that drive", lambda: teach_robot("left", "forwards"), [2]),
    ("wanders beside idle robots", lambda: teach_robot("wander", None), [2]),
    ("the second of two coordinators", teach_second_coordinator, [2, 3]),
]


@pytest.mark.parametrize(
    ("make", "robots"), [each[1:] for each in SESSIONS], ids=[each[0] for each in SESSIONS]
)
def test_a_goal_counts_the_robots_that_it_is_about(make: Callable[[], Session], robots: list[int]) -> None:
    """It holds in a world where it holds for these robots, whatever the others touch or cover."""
    session = make()
    free, area = run_all(session)
    expected = {
        "clearance": (free[:, robots] >= TOUCH).all(axis=1),
        "covered": (area[:, robots] >= AREA).all(axis=1),
    }
    offered = {each.what.partition(" ")[0]: each for each in offer_session_goals(session)}
    assert {each for each in offered if each in expected} == set(expected)
    for what, works in expected.items():
        session.change_design(goal=offered[what])
        setup, library = find_setup(session)
        found = NewWorlds(setup, SEEDS).run(library, session.automaton.name, {})
        assert found.works.tolist() == works.tolist(), what


def test_the_others_matter_to_the_table_above() -> None:
    """Where other robots drive into walls, a goal about all robots would hold in no world."""
    free, area = run_all(teach_robot("left", "forwards"))
    assert (free >= TOUCH).all(axis=1).sum() == 0
    assert (free[:, 2] >= TOUCH).sum() > 10
    assert (area[:, [0, 1, 3]] > area[:, 2:3]).any()


def test_a_goal_of_a_coordinator_is_said_of_its_robots() -> None:
    session = teach_second_coordinator()
    offers = offer_session_goals(session)
    assert [each.name for each in offers][-2:] == [
        "never lets its robots touch anything",
        "covers at least 3 m² of ground in 60 s with each of its robots",
    ]
    session.change_design(goal=offers[-2])
    setup, library = find_setup(session)
    mistakes = NewWorlds(setup, SEEDS).run(library, "lead", {}).mistakes
    assert {each.why for each in mistakes} == {"this does not hold: it never lets its robots touch anything"}
