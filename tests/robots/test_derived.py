"""Readings that no message holds, by hand, and as simulated worlds have them."""

from __future__ import annotations

from math import cos, inf, isnan, nan, pi, sin

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import Wire, odometry
from tests.robots.twins import ARENA, Rig

from understudy.addons.robots.derived_readings import NOWHERE, DerivedReadings
from understudy.addons.robots.inputs import compute_ranges_and_bearings
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.runtime.body import Reading
from understudy.sim.kernels import collisions
from understudy.sim.scenario.schema import ElapsedSensor, RandomSensor, RobotType, StallSensor

X, Y = Reading("x", Continuous(), "m"), Reading("y", Continuous(), "m")
BLOB = Reading("blob_x", Continuous(), "px", of_targets=True)


def kind(*sensors: StallSensor | RandomSensor | ElapsedSensor) -> RobotType:
    return RobotType(sensors=sensors)


def stuck(path: list[tuple[float, float]], asked_m_s: list[float]) -> list[float]:
    """What `stuck` reads along a path, a place each tenth of a second, of a robot asked for so much before each."""
    derived = DerivedReadings(kind(StallSensor(after_s=1.0)), [X, Y], [])
    return [
        derived.compute(tick / 10, {("x", None): x, ("y", None): y}, asked)["stuck", None]
        for tick, ((x, y), asked) in enumerate(zip(path, asked_m_s, strict=True))
    ]


def test_stuck_is_who_gets_nowhere_for_a_second() -> None:
    assert stuck([(0.0, 0.0)] * 14, [0.3] * 14) == [0.0] * 10 + [1.0] * 4


def test_the_share_is_that_of_simulated_worlds() -> None:
    assert NOWHERE == collisions.STUCK
    for share, is_stuck in ((0.05, 1.0), (0.15, 0.0)):  # as when it slides along a wall
        path = [(0.3 * share * tick / 10, 0.0) for tick in range(14)]
        assert stuck(path, [0.3] * 14)[-1] == is_stuck


def test_who_drives_in_a_circle_is_not_stuck() -> None:
    """Once around in a second, it is where it was."""
    turns = [2 * pi * tick / 10 for tick in range(25)]
    path = [(0.05 * cos(turn), 0.05 * sin(turn)) for turn in turns]
    assert set(stuck(path, [2 * pi * 0.05] * 25)) == {0.0}


def test_who_was_not_asked_to_drive_is_not_stuck() -> None:
    assert stuck([(0.0, 0.0)] * 14, [0.3] * 9 + [0.0] + [0.3] * 4) == [0.0] * 14


def test_time_since_a_blob_was_seen() -> None:
    derived = DerivedReadings(kind(ElapsedSensor(name="unseen", of="blob_x")), [BLOB], ["ball", "dog"])
    seen: list[ReadingKey] = [("blob_x", "ball")]
    found = [
        derived.compute(tick / 2, dict.fromkeys(seen, x), 0.0) for tick, x in enumerate([nan, 80.0, nan, nan])
    ]
    since = [each["unseen", "ball"] for each in found]
    assert isnan(since[0])
    assert since[1:] == [0.0, 0.5, 1.0]
    assert all(isnan(each["unseen", "dog"]) for each in found)


def test_time_since_it_was_stuck() -> None:
    """Simulated worlds have such readings of `stuck`, too."""
    derived = DerivedReadings(
        kind(ElapsedSensor(name="free", of="stuck"), StallSensor(after_s=0.1)), [X, Y], []
    )
    here: dict[ReadingKey, float] = {("x", None): 0.0, ("y", None): 0.0}
    found = [derived.compute(tick / 10, here, asked) for tick, asked in enumerate([0.3, 0.3, 0.0, 0.0])]
    assert [each["stuck", None] for each in found] == [0.0, 1.0, 0.0, 0.0]
    assert [each["free", None] for each in found] == pytest.approx([nan, 0.0, 0.1, 0.2], nan_ok=True)


def test_what_a_robot_tells_itself_is_not_worked_out() -> None:
    told = Reading("stuck", BOOLEAN)
    derived = DerivedReadings(kind(StallSensor(), ElapsedSensor(name="free", of="stuck")), [told, X, Y], [])
    assert [each.name for each in derived.readings] == ["free"]
    assert derived.compute(0.0, {("stuck", None): 1.0}, 0.0) == {("free", None): 0.0}


def test_chance_is_kept_for_its_time_and_another_with_each_robot() -> None:
    def draw_numbers(seed: int) -> list[float]:
        derived = DerivedReadings(kind(RandomSensor(name="chance", every_s=1.0)), [], [], seed=seed)
        return [derived.compute(tick / 4, {}, 0.0)["chance", None] for tick in range(8)]

    one, other = draw_numbers(1), draw_numbers(2)
    assert one == [one[0]] * 4 + [one[4]] * 4
    assert len({*one, *other}) == 4
    assert all(0.0 <= each < 1.0 for each in one)


def test_robots_of_a_team_draw_by_themselves() -> None:
    """With one sequence for all, those that wander would turn together."""
    rig = Rig(("one", "two", "three", "four"), world="patrol")
    assert len(set(rig.twin.sense([("chance", None)])["chance", None])) == 4


def test_places_beyond_all_numbers_are_absent() -> None:
    target = parse_robot(ARENA.format(name="one", world="arena")).targets
    far: dict[ReadingKey, float] = {("x", None): -1e308, ("y", None): 1.7e308, ("heading", None): 0.0}
    assert all(
        isnan(value) for value in compute_ranges_and_bearings(target, far | {("x", None): -1.7e308}).values()
    )
    assert inf not in compute_ranges_and_bearings(target, far).values()


def test_a_robot_far_beyond_the_arena_is_sensed_and_drawn() -> None:
    rig = Rig(("one",))
    rig.hear(0, odometry(1e308))
    rig.twin.sense([("range", "red_flag")])
    rig.twin.view()


def test_readings_are_named_once() -> None:
    file = ARENA.replace(
        "[targets", 'stuck = {{ topic = "s", type = "std_msgs/msg/Bool", field = "data" }}\n[targets'
    )
    robot = Robot(parse_robot(file.format(name="one", world="arena")), Wire())
    assert [each.name for each in robot.readings].count("stuck") == 1
