"""Real robots in the scenario whose lessons they run, over a wire in memory: what a session senses and commands."""

from __future__ import annotations

from math import isnan, pi, sqrt

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import Wire, odometry
from tests.robots.twins import ARENA, Rig

from understudy.errors import SettingError, UnderstudyError
from understudy.robots.body import Robot
from understudy.robots.file import parse_robot
from understudy.robots.fleet import Fleet
from understudy.robots.guard import ArmingRefused
from understudy.robots.twin import Twin
from understudy.testing import check_body


def test_a_twin_keeps_the_laws_of_bodies() -> None:
    check_body(Rig().twin)


def test_robots_read_where_targets_are() -> None:
    """From (0, 0) the flag at (2, 0) is 2 m ahead; from (2, 0), turned left by half a turn, it is here."""
    rig = Rig()
    rig.hear(0, odometry(0.0))
    rig.hear(1, odometry(1.0, z=sqrt(0.5), w=sqrt(0.5)))  # looks left, along y
    keys = [("range", "red_flag"), ("bearing", "red_flag"), ("range", "blue_flag"), ("sonar_ahead", None)]
    percept = rig.twin.sense(keys)
    assert percept["range", "red_flag"].tolist() == pytest.approx([2.0, 1.0])
    assert percept["bearing", "red_flag"].tolist() == pytest.approx([0.0, 3 * pi / 2])
    assert all(np.isnan(percept[key]).all() for key in keys[2:])  # neither told of, nor a sensor


def test_robots_and_targets_are_drawn_from_the_corner_of_the_fence() -> None:
    rig = Rig()
    rig.hear(0, odometry(0.5, z=1.0, w=0.0))
    rig.twin.sense([])
    view = rig.twin.view()
    assert (view.robots.x[0], view.robots.y[0]) == (1.5, 2.0)
    assert view.robots.heading[0] == pytest.approx(pi)
    assert (len(view.objects.x), view.objects.x[0], view.objects.y[0]) == (1, 3.0, 2.0)


def test_one_robot_arms_where_all_can() -> None:
    rig = Rig()
    rig.seen()
    rig.twin.fleet.arm("a test")
    rig.twin.act({"drive": np.array([1.0, 0.0]), "turn": np.array([0.0, -1.0])})
    assert (rig.sent(0), rig.sent(1)) == ((0.4, 0.0), (0.0, -1.0))


def test_at_rest_robots_are_stopped_again_and_again() -> None:
    rig = Rig()
    rig.seen()
    rig.twin.fleet.arm("a test")
    rig.twin.act({"drive": np.array([1.0, 1.0])})
    assert not rig.twin.idle()
    rig.now += 0.11
    assert rig.twin.idle()
    assert rig.sent(0) == (0.0, 0.0)
    assert rig.twin.fleet.armed


def test_two_robots_of_one_namespace_are_no_fleet() -> None:
    with pytest.raises(SettingError, match="both would obey the same commands; give each its own"):
        Rig(("one", "one"))


def test_a_robot_without_a_world_has_no_twin() -> None:
    robot = Robot(parse_robot(ARENA.format(name="one", world="arena").replace('world = "arena"', "")), Wire())
    with pytest.raises(SettingError, match="name the scenario"):
        Twin(Fleet([robot]))


def test_absent_where_no_odometry_comes() -> None:
    rig = Rig()
    percept = rig.twin.sense([("range", "red_flag")])
    assert all(map(isnan, percept["range", "red_flag"]))


def broken(*_: object) -> None:
    raise OSError("broken")


def test_what_goes_wrong_with_one_robot_keeps_no_other_from_stopping(monkeypatch: pytest.MonkeyPatch) -> None:
    for stop in ("disarm", "emergency", "close"):
        rig = Rig()
        rig.seen()
        rig.twin.fleet.arm("a test")
        monkeypatch.setattr(rig.robots[0], stop, broken)
        with pytest.raises(OSError, match="broken"):
            getattr(rig.twin.fleet, stop)("a test")
        assert not rig.robots[1].armed
        monkeypatch.undo()


def test_where_one_robot_cannot_be_armed_none_is() -> None:
    rig = Rig()
    rig.hear(0, odometry(0.0))
    with pytest.raises(UnderstudyError, match="geofence"):
        rig.twin.fleet.arm("a test")
    assert not rig.twin.fleet.armed
    assert rig.robots[0].stopped == "another robot of the team could not be armed"


@pytest.mark.parametrize(
    ("error", "cause"),
    [
        (KeyError, "its program failed: KeyError"),
        (KeyboardInterrupt, "its program was interrupted"),
        (SystemExit, "its program left"),
    ],
)
def test_robots_tell_why_their_program_left(error: type[BaseException], cause: str) -> None:
    rig = Rig()
    rig.seen()

    def fail() -> None:
        with rig.twin.fleet as fleet:
            fleet.arm("a test")
            raise error

    with pytest.raises(error):
        fail()
    assert [robot.stops[-1].cause for robot in rig.robots] == [cause] * 2


def test_all_robots_of_a_team_are_armed_or_none() -> None:
    rig = Rig()
    rig.seen()
    rig.hear(1, odometry(9.0))  # outside its geofence
    with pytest.raises(ArmingRefused, match="'two' stays disarmed: outside its geofence"):
        rig.twin.fleet.arm("a test")
    assert [robot.armed for robot in rig.robots] == [False, False]
    assert rig.robots[0].stopped == "another robot of the team could not be armed"
