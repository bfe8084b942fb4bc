"""Monitors of properties: in compiled runs as tick by tick, and how near to failing a run came."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace as change
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.errors import SettingError, UnderstudyError, UnknownName
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.properties.monitor import PropertyOutcomes, monitor_property
from understudy.judging.properties.run_property import make_property_task, run_property
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import ArenaRegion, Goal
from understudy.sim.team.libraries import collect_libraries
from understudy_lab.bench.patrol import lead

FORAGE = change(
    find_scenario("forage"),
    regions={"west": ArenaRegion(box=(0, 0, 6, 12)), "corner": ArenaRegion(center=(0, 0), radius=3)},
)
LIBRARY = Library.from_automata(make_scenario_kit(FORAGE), *AUTOMATA)
SEEDS = (0, 1, 2, 3)
A = {"A": "station"}


def make(kind: str, what: str, seconds: float | None = None, **more: Any) -> Property:
    start = SeededWorlds("forage", SEEDS, more.pop("limit_s", 120.0))
    return Property(
        kind=PropertyKind(kind), what=what, seconds=seconds, start=start, behavior="forage", **more
    )


def watch(subject: Property, *, fused: bool) -> PropertyOutcomes:
    task = make_property_task(subject, LIBRARY, FORAGE)
    run = task.make_run(FORAGE, SEEDS)
    assert isinstance(run, ProgramRun)
    assert run.is_fused
    if not fused:
        run._plan = None  # as if it could not be compiled
    return monitor_property(subject, run, task.criteria.flags)


CASES = [
    make("always", "goal is reached", 150.0),
    make("always", "goal is reached", 1800.0),
    make("always", "done is raised", 40.0, targets=Binding(A)),
    make("never", "done is raised", targets=Binding(A)),
    make("always", "food_stored is at least 2 units", 30.0),
    make("never", "distance(robot, station) is below 30 cm"),
    make("never", "robot is in corner"),
    make("never longer", "robot is in west", 60.0),
    make("progress", "progress", 60.0),
]


@pytest.mark.parametrize("subject", CASES, ids=str)
def test_at_once_as_tick_by_tick(subject: Property) -> None:
    if subject.targets:
        subject = Property(**{**vars_of(subject), "behavior": "goto"})
    fused, ticked = (watch(subject, fused=each) for each in (True, False))
    assert fused.failed_s == pytest.approx(ticked.failed_s, nan_ok=True)
    assert fused.reached_s == pytest.approx(ticked.reached_s, nan_ok=True)
    assert fused.robustness == pytest.approx(ticked.robustness)
    assert ((fused.robustness > 0) == fused.held).all()
    assert (np.abs(fused.robustness) <= 1.0).all()


def vars_of(subject: Property) -> dict[str, Any]:
    return {name: getattr(subject, name) for name in Property.__slots__}


@pytest.mark.parametrize("limit", [0.5, 0.05])
def test_it_fails_in_the_tick_in_which_the_condition_first_holds(limit: float) -> None:
    """The distance is read again, tick by tick, from another run of the same worlds."""
    subject = make("never", f"distance(robot, station) is below {limit} m")
    found = watch(subject, fused=True)
    run = make_property_task(subject, LIBRARY, FORAGE).make_run(FORAGE, SEEDS)
    distance = run.find_reading("distance_to(station)")
    apart = [distance.read()[:, 0]]
    for _ in range(1200):
        run.advance(1)
        apart.append(distance.read()[:, 0])
    near = np.array(apart) < limit
    first = np.where(near.any(axis=0), near.argmax(axis=0) * 0.1, np.nan)
    assert found.held.all() == (limit < 0.1)
    assert found.failed_s == pytest.approx(first, nan_ok=True)
    least = np.min(apart, axis=0)
    for held, value, robustness in zip(found.held, least, found.robustness, strict=True):
        if held:
            assert robustness == pytest.approx((value - limit) / (limit + abs(value - limit)))


@pytest.mark.parametrize(
    ("what", "held"),
    [
        ("food_stored is above 0 units", True),
        ("food_stored is at least 0 units", False),
        ("food_stored is below 0 units", True),
        ("food_stored is at most 0 units", False),
        ("food_stored is not absent and at_station is maybe or food_stored is absent", None),
        ("food_left is yes and food_stored is above 0 units", True),
        ("food_left is yes or food_stored is above 0 units", False),
        ("robot is in west and food_left is no", True),
        ("robot is in west or food_left is yes", False),
    ],
)
def test_at_the_first_moment(what: str, held: bool | None) -> None:
    """The robot has no food yet, and there is some."""
    if held is None:
        with pytest.raises(UnknownName):
            watch(make("never", what, limit_s=0.0), fused=True)
        return
    found = watch(make("never", what, limit_s=0.0), fused=True)
    assert found.held.tolist() == [held] * len(SEEDS)
    assert ((found.robustness > 0) == found.held).all()


def test_robustness_of_times() -> None:
    reached = watch(make("always", "goal is reached", 1800.0), fused=True)
    assert reached.robustness == pytest.approx((1800.0 - reached.reached_s) / 1800.0)
    late = watch(make("always", "goal is reached", 1.0), fused=True)
    assert late.robustness == pytest.approx(-1.0), "all of the food is left"
    half = watch(make("always", "goal is reached", 150.0), fused=True)
    assert (half.robustness[~half.held] > -1.0).all()
    assert half.failed_s[~half.held] == pytest.approx(150.0)


def test_the_nearest_robot_and_its_way_count_as_progress() -> None:
    """The goal is a place: it comes nearer while the robot drives there."""
    where = change(FORAGE, goal=Goal(target="station", within=0.5))
    subject = Property(
        kind=PropertyKind.PROGRESS, what="progress", seconds=10.0, start=SeededWorlds("forage", SEEDS),
        behavior="goto", targets=Binding(A),
    )  # fmt: skip
    assert run_property(subject, LIBRARY, where).failures == 0
    still = Property(**{**vars_of(subject), "behavior": "load_food", "targets": Binding()})
    outcomes = run_property(still, LIBRARY, where).outcomes
    assert outcomes.failed_s == pytest.approx(11.0), "it is looked at once a second"
    assert (outcomes.robustness < 0).all()


def test_in_a_team() -> None:
    """A coordinator's flag, and distances between the robots below it."""
    known = dict(collect_libraries(SCENARIO, ROBOTS, lambda name, kit: Library.from_automata(kit, lead())))
    start = SeededWorlds("patrol", (1, 2), 30.0)
    behavior = next(iter(known["patrol"].taught))
    never = Property(
        kind=PropertyKind.NEVER,
        what="distance(robot, robot) is below 10 cm",
        start=start,
        behavior=f"patrol/{behavior}",
    )
    result = run_property(never, known, SCENARIO)
    assert result.failures == 0, "they are discs of 20 cm"
    assert (result.outcomes.robustness > 0).all()
    near = Property(**{**vars_of(never), "what": "distance(robot, robot) is below 100 m"})
    assert run_property(near, known, SCENARIO).outcomes.failed_s == pytest.approx(0.0)


REFUSED: list[tuple[str, type[UnderstudyError], str]] = [  # condition, what is said
    ("front is below 1 m", UnknownName, "has no feature or reading 'front'"),
    ("distance_to(moon) is below 1 m", UnknownName, "has no target 'moon'"),
    ("distance_to(station) is below 1", SettingError, "'1' has no unit"),
    ("distance_to(station) is below 1 s", SettingError, "'1 s' does not fit"),
    ("distance_to(station) is yes", SettingError, "write 'distance_to(station) is below 0.5 m'"),
    ("at_station is below 1", SettingError, "write 'at_station is yes'"),
    ("at_station is maybe", UnknownName, "has no label 'maybe'"),
    ("robot is in pit", UnknownName, "has no region 'pit'; it has west and corner"),
    ("wolf is in west", UnknownName, "has no robots or objects 'wolf'"),
    ("distance(robot) is below 1 m", SettingError, "write distance(robot, robot)"),
    ("distance(robot, wolf) is below 1 m", UnknownName, "has no robots or objects 'wolf'"),
    ("failed is raised", UnknownName, "has no flag 'failed'"),
    ("station is reached", SettingError, "write 'goal is reached'"),
]


@pytest.mark.parametrize(("what", "error", "said"), REFUSED)
def test_what_is_refused(what: str, error: type[UnderstudyError], said: str) -> None:
    with pytest.raises(error) as refused:
        watch(make("never", what), fused=True)
    assert said in str(refused.value)


@pytest.mark.parametrize("kind", ["always", "progress"])
def test_a_world_without_a_goal(kind: str) -> None:
    subject = make(kind, "goal is reached" if kind == "always" else "progress", 10.0)
    with pytest.raises(
        SettingError, match=r"scenario 'forage': goal is missing; give the scenario a \[goal\]"
    ):
        run_property(subject, LIBRARY, change(FORAGE, goal=None))
