"""Real robots in the scenario whose lessons they run, over a wire in memory: what a session senses and commands."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from tests.robots.rovers import Wire, odometry
from tests.robots.twins import ARENA, Rig

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot, parse_robot
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import SettingError, UnderstudyError
from understudy.records.header import RunInfo
from understudy.records.reader import read_recording
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import list_reading_keys
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
    rig.send_odometry()
    rig.twin.fleet.arm("a test")
    rig.twin.act({"drive": np.array([1.0, 0.0]), "turn": np.array([0.0, -1.0])})
    assert (rig.sent(0), rig.sent(1)) == ((0.4, 0.0), (0.0, -1.0))


def test_at_rest_robots_are_stopped_again_and_again() -> None:
    rig = Rig()
    rig.send_odometry()
    rig.twin.fleet.arm("a test")
    rig.twin.act({"drive": np.array([1.0, 1.0])})
    assert not rig.twin.idle()
    rig.now += 0.11
    assert rig.twin.idle()
    assert rig.sent(0) == (0.0, 0.0)
    assert rig.twin.fleet.armed


def test_two_robots_of_one_namespace_are_no_fleet() -> None:
    with pytest.raises(SettingError, match="both would get the same commands; give each its own"):
        Rig(("one", "one"))


def test_a_robot_without_a_world_has_no_twin() -> None:
    robot = Robot(parse_robot(ARENA.format(name="one", world="arena").replace('world = "arena"', "")), Wire())
    with pytest.raises(SettingError, match="name the scenario"):
        DigitalTwin(Fleet([robot]))


def test_absent_where_no_odometry_comes() -> None:
    rig = Rig()
    percept = rig.twin.sense([("range", "red_flag")])
    assert all(map(isnan, percept["range", "red_flag"]))


def broken(*_: object) -> None:
    raise OSError("broken")


def test_what_goes_wrong_with_one_robot_keeps_no_other_from_stopping(monkeypatch: pytest.MonkeyPatch) -> None:
    for stop in ("disarm", "emergency_stop", "close"):
        rig = Rig()
        rig.send_odometry()
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
    assert rig.robots[0].stop_cause == "another robot of the team could not be armed"


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
    rig.send_odometry()

    def fail() -> None:
        with rig.twin.fleet as fleet:
            fleet.arm("a test")
            raise error

    with pytest.raises(error):
        fail()
    assert [robot.stops[-1].cause for robot in rig.robots] == [cause] * 2


def record_sessions(path: Path, rig_of: Callable[[RunRecorder], Rig]) -> None:
    """Two sessions, of two ticks and of one, with a press in each."""
    with RunRecorder(path) as recorder:
        rig = rig_of(recorder)
        rig.send_odometry()
        for session, presses in (("one", ["forward", "left"]), ("two", ["right"])):
            rig.twin.follow(lambda: [("forward",), ()])
            rig.twin.record(RunInfo(library=session))
            for state in presses:
                rig.twin.record_action(0, state)
                rig.now += 0.1
                rig.twin.sense(list_reading_keys(rig.twin))
                rig.twin.act({"drive": np.zeros(2)})


def test_sessions_of_one_recording_are_kept_apart(tmp_path: Path) -> None:
    path = tmp_path / "two.mcap"
    record_sessions(path, lambda recorder: Rig(recorder=recorder))
    found = [read_recording(path, run=run) for run in (1, 2, None)]
    assert [each.head.ran.library for each in found] == ["one", "two", "two"]
    assert [[press.state for press in each.records[0].presses] for each in found] == [
        ["forward", "left"],
        ["right"],
        ["right"],
    ]
    assert [(each.ticks, each.runs) for each in found] == [(2, 2), (1, 2), (1, 2)]
    with pytest.raises(SettingError, match="its run is 3; count from 1 to 2"):
        read_recording(path, run=3)


def test_robots_of_one_namespace_in_two_domains_are_recorded_apart(tmp_path: Path) -> None:
    """With the files of both, though these have one name, too."""
    path = tmp_path / "two.mcap"

    def rig_of(recorder: RunRecorder) -> Rig:
        rig = Rig(recorder=recorder)
        text = ARENA.format(name="one", world="arena")
        robots = []
        for domain, wire in enumerate(rig.wires):
            place = tmp_path / str(domain) / "one.toml"
            place.parent.mkdir()
            place.write_text(f"domain = {domain}\n{text}", encoding="utf-8")
            robots.append(Robot(load_robot(place), wire, path=place, clock=rig.clock))
        rig.names, rig.twin = ("one", "one"), DigitalTwin(Fleet(robots), recorder=recorder)
        return rig

    record_sessions(path, rig_of)
    found = read_recording(path, run=1)
    assert (found.ticks, len(found.records), len(set(found.head.names))) == (2, 2, 2)
    assert [f"domain = {domain}" in "".join(found.head.files.values()) for domain in (0, 1)] == [True, True]


def test_robots_that_cannot_move_are_no_members_of_their_squad() -> None:
    """Disarmed, outside its geofence, silent: none of them counts, so that nobody waits for it."""
    rig = Rig(("one", "two", "three", "four"))
    rig.send_odometry()
    assert rig.twin.failed.tolist() == [True] * 4  # nobody has armed them
    rig.twin.fleet.arm("a test")
    assert rig.twin.failed.tolist() == [False] * 4
    rig.robots[0].disarm("a test")
    rig.hear(1, odometry(9.0))
    assert rig.twin.failed.tolist() == [True, True, False, False]
    rig.now += 5.0
    rig.hear(2, odometry(0.0))
    assert rig.twin.failed.tolist() == [True, True, False, True]
    assert (
        rig.robots[3].unfitness == "outside its geofence"
    )  # which is where it is, as long as it does not say
