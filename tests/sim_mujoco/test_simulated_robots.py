"""Simulated robots as ROS 2 robots: what they publish, what they obey, and their files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from math import inf, isnan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from msgspec.structs import replace
from tests.processes import end_with_tests
from tests.robots.domains import own_domain
from tests.robots.rovers import Wire
from tests.sim_mujoco.drawing import draws
from tests.ui.cli.commands import run
from tests.waiting import wait_until

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.robot_files import (
    IMAGE,
    ODOMETRY,
    check_ros,
    format_robot_file,
    format_team_file,
    list_robot_names,
    list_sensor_topics,
)
from understudy.addons.bridges.mujoco.ros_robots import Simulation
from understudy.addons.robots.camera.image_decoding import decode_image
from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot_file import load_team, parse_robot
from understudy.addons.robots.ros.frame_tree import TRANSFORMS, FrameTree
from understudy.addons.robots.ros.message_readings import compute_heading
from understudy.errors import SettingError
from understudy.records.messages import TWIST, decode_message, encode_twist
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Lidar, Scenario
from understudy.sim.sensing.range_sensors import RANGE
from understudy.ui.cli.commands.robots_simulate import _leaving_orderly

ROOT = Path(__file__).parents[2]
DOMAIN = str(own_domain())
SHIPPED = ["arena", "forage", "patrol", "soccer", "rooms"]


def make_simulation(name: str, tick_s: float = 0.05) -> tuple[Simulation, Wire]:
    wire = Wire()
    return Simulation(MujocoBody(replace(load_scenario(name), tick_s=tick_s), [0]), wire), wire


def last(wire: Wire, topic: str, type: str) -> Any:
    return decode_message(type, next(data for name, data in reversed(wire.sent) if name == topic))


def test_robots_are_named_by_type_and_number() -> None:
    assert list_robot_names(load_scenario("soccer")) == ("humanoid",)
    assert list_robot_names(load_scenario("patrol")) == tuple(f"pioneer_{k}" for k in (1, 2, 3, 4))


@pytest.mark.parametrize("name", SHIPPED)
def test_files_are_robots_of_their_world(name: str) -> None:
    scenario = load_scenario(name)
    for number, robot in enumerate(list_robot_names(scenario)):
        file = parse_robot(format_robot_file(scenario, number, world=name, domain=7, rate_hz=20.0))
        assert (file.name, file.namespace, file.world, file.domain) == (robot, f"/{robot}", name, 7)
        kind = scenario.types[file.kind or ""]
        assert (file.commands.drive_m_s, file.limits.speed_m_s) == (kind.speed, kind.speed)


def test_with_a_router_they_speak_zenoh() -> None:
    scenario, router = load_scenario("soccer"), "tcp/localhost:7447"
    file = parse_robot(format_robot_file(scenario, 0, world="soccer", domain=7, rate_hz=20.0, router=router))
    assert (file.transport, file.router) == ("zenoh", router)


def test_a_team_is_its_robots(tmp_path: Path) -> None:
    scenario = load_scenario("patrol")
    (tmp_path / "team.toml").write_text(format_team_file(scenario))
    team, paths = load_team(tmp_path / "team.toml")
    assert (team.name, [path.name for path in paths]) == (
        "patrol",
        [f"pioneer_{k}.toml" for k in (1, 2, 3, 4)],
    )


def test_a_twist_moves_it_and_it_stops_by_itself() -> None:
    simulation, wire = make_simulation("arena")
    start = simulation.body.arenas[0].pose(0)
    wire.deliver("/rover/cmd_vel", encode_twist(TWIST, speed_m_s=0.3, turn_rad_s=0.5), 10.0)
    for tick in range(3):
        simulation.tick(10.0 + 0.05 * tick)  # the last 0.1 s after it: before its deadline
    said = last(wire, "/rover/odom", ODOMETRY)
    assert 0.1 < said.twist.twist.linear.x < 0.3
    assert said.twist.twist.angular.z > 0.1
    assert said.pose.pose.position.x != start.x
    for tick in range(20):
        simulation.tick(10.16 + 0.05 * tick)
    assert last(wire, "/rover/odom", ODOMETRY).twist.twist.linear.x == pytest.approx(0.0, abs=1e-3)


def test_its_frame_is_where_its_odometry_says() -> None:
    simulation, wire = make_simulation("arena")
    wire.deliver("/rover/cmd_vel", encode_twist(TWIST, speed_m_s=0.3, turn_rad_s=0.5), 10.0)
    for tick in range(3):
        simulation.tick(10.0 + 0.05 * tick)
    tree, said = FrameTree(), last(wire, "/rover/odom", ODOMETRY)
    tree.update(last(wire, "/tf", TRANSFORMS), 7.0)
    found = tree.locate(said.header.frame_id, said.child_frame_id)
    assert (said.header.frame_id, said.child_frame_id) == ("rover/odom", "rover/base_link")
    at = said.pose.pose.position
    assert found == (at.x, at.y, compute_heading(said.pose.pose.orientation), 7.0)


BAD = [b"", b"\x00\x01\x00\x00", encode_twist(TWIST, speed_m_s=inf, turn_rad_s=0.0), os.urandom(52)[:20]]


@pytest.mark.parametrize("data", BAD, ids=range(len(BAD)))
def test_what_is_no_twist_moves_nothing(data: bytes) -> None:
    simulation, wire = make_simulation("arena")
    wire.deliver("/rover/cmd_vel", data, 10.0)
    for tick in range(4):
        simulation.tick(10.0 + 0.05 * tick)
    assert simulation.body.arenas[0].pose(0).speed == pytest.approx(0.0, abs=1e-3)


def test_sonar_is_as_rep_117_has_it() -> None:
    simulation, wire = make_simulation("arena")
    simulation.body.place(0, 0.6, 5.0, np.pi)  # 0.4 m from the left wall, facing it
    simulation.tick(0.0)
    ahead = last(wire, "/rover/sonar/sonar_ahead", RANGE)
    assert ahead.range == pytest.approx(0.4, abs=0.05)
    assert (ahead.min_range, ahead.max_range) == (0.0, 3.0)
    simulation.body.place(0, 6.0, 0.3, 0.0)
    topics = [each.name for each in list_sensor_topics(simulation.robots[0].kind) if each.type == RANGE]
    found = [last(wire, f"/rover/{topic}", RANGE).range for topic in topics]
    assert all(each == inf or each < 3.0 for each in found)


@draws
def test_what_is_published_reads_as_the_body_senses_it() -> None:
    """Through messages and a robot's own senses: the same sonar, pose and blobs."""
    simulation, wire = make_simulation("patrol")
    file = parse_robot(format_robot_file(load_scenario("patrol"), 0, world="patrol", domain=0, rate_hz=20.0))
    there = Wire()
    senses = SensorInputs(file, there)
    body = simulation.body
    keys = [
        ("sonar_rear", None),
        *((name, target) for name in ("blob_x", "blob_size") for target in body.targets),
    ]
    sensed = body.sense(keys)
    simulation.tick(0.0)
    for topic, data in wire.sent:
        if topic.startswith("/pioneer_1/"):
            there.deliver(topic, data, 0.0)
    heard = senses.values(0.0)
    for key in keys:
        assert heard[key] == pytest.approx(float(sensed[key][0]), abs=1e-6, nan_ok=True)
    image = last(wire, "/pioneer_1/image_raw", IMAGE)
    assert (image.width, image.height, image.encoding, image.step) == (160, 120, "rgb8", 480)
    pixels = decode_image(image.data, encoding="rgb8", width=160, height=120, step=480)
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20


def test_a_lidar_is_a_laser_scan_and_reads_as_the_body_senses_it() -> None:
    """All its readings from one message, through the robot's file."""
    lidar = Lidar(beams=24, range=4.0, sectors={"front": (-50.0, 50.0), "rear": (100.0, 260.0)}, clear=0.6)
    scenario = load_scenario("rooms")
    kinds = {name: replace(kind, sensors=(lidar,)) for name, kind in scenario.types.items()}
    scenario = replace(scenario, types=kinds, features={}, targets={}, goal=None)
    wire, there = Wire(), Wire()
    body = MujocoBody(scenario, [3])
    simulation = Simulation(body, wire)
    senses = SensorInputs(
        parse_robot(format_robot_file(scenario, 0, world="rooms", domain=0, rate_hz=20.0)), there
    )
    keys = [(reading.name, None) for reading in body.readings]
    assert len(keys) == 24 + 2 * 3
    sensed = body.sense(keys)
    simulation.tick(0.0)
    scans = [(topic, data) for topic, data in wire.sent if topic.endswith("/scan/beam")]
    assert len(scans) == 1
    there.deliver(*scans[0], 0.0)
    heard = senses.values(0.0)
    for key in keys:
        assert heard[key] == pytest.approx(float(sensed[key][0]), abs=1e-5, nan_ok=True), key


def test_a_robot_whose_lidar_hits_nothing_goes_on() -> None:
    """There is no nearest return then, whose bearing could be told; where no scan comes, it stops."""
    lidar = Lidar(beams=24, range=0.1, sectors={"front": (-50.0, 50.0)}, clear=0.1)
    scenario = load_scenario("rooms")
    kinds = {name: replace(kind, sensors=(lidar,)) for name, kind in scenario.types.items()}
    scenario = replace(scenario, types=kinds, features={}, targets={}, goal=None)
    wire, there = Wire(), Wire()
    senses = SensorInputs(
        parse_robot(format_robot_file(scenario, 0, world="rooms", domain=0, rate_hz=20.0)), there
    )
    Simulation(MujocoBody(scenario, [3]), wire).tick(0.0)
    for topic, data in wire.sent:
        if topic != "/tf":
            there.deliver(topic, data, 0.0)
    assert isnan(senses.values(0.0)["front_bearing", None])
    assert senses.find_missing(0.0) is None
    assert senses.find_missing(9.0) is not None


def _all_came(said: dict[str, Any]) -> bool:
    return all(each["messages"] > 2 for each in said["arrivals"])


@draws
@pytest.mark.timed
def test_a_person_without_hardware_finds_all_there(tmp_path: Path) -> None:
    """`robots simulate` in one process, and `robots check` in this one, over DDS."""
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    command = [sys.executable, "-m", "understudy.ui.cli", "robots", "simulate", "soccer", "--domain", DOMAIN]
    command += ["--write-files", str(tmp_path), "--seconds", "600", "--rate", "10"]
    with subprocess.Popen(
        end_with_tests(command), cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as process:
        try:
            assert process.stdout is not None
            while "Ctrl-C" not in (line := process.stdout.readline()):
                assert line, "it ended early"
            said: list[dict[str, Any]] = []

            def came() -> bool:
                """On a busy machine it takes a while to find who is there."""
                file = tmp_path / "humanoid.toml"
                said.append(json.loads(run("robots", "check", file, "--seconds", 1.0, "--json").stdout))
                return _all_came(said[-1])

            wait_until(came)
            assert not said[-1]["lacks"]
        finally:
            process.terminate()  # as Ctrl-C
            process.wait(60)
    assert process.returncode == 0


def test_a_robot_that_is_not_there_is_named() -> None:
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    result = run("robots", "simulate", "arena", "--domain", DOMAIN, "--only", "rower")
    assert result.exit_code != 0
    assert "no robot 'rower'; did you mean 'rover'? It has rover and referee" in result.output


def simulate_for_a_moment(*arguments: object) -> str:
    """What the command says on one line."""
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    result = run("robots", "simulate", *arguments, "--domain", DOMAIN, "--seconds", "0.1")
    return " ".join(result.output.split())


def test_a_file_that_a_person_changed_is_left_and_that_is_said(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    for _ in range(2):
        assert f"Wrote {file}" in simulate_for_a_moment("arena", "--write-files", tmp_path)
    file.write_text(mine := file.read_text() + "# of my own\n")
    said = simulate_for_a_moment("arena", "--write-files", tmp_path)
    assert "exists with other content and was left as it is; remove it" in said
    assert file.read_text() == mine


def test_what_cannot_be_simulated_is_refused_before_files_are_written(tmp_path: Path) -> None:
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    result = run("robots", "simulate", "boxes", "--write-files", tmp_path)
    assert result.exit_code != 0
    assert "objects[1].pull is not there in physics" in " ".join(result.output.split())
    assert list(tmp_path.iterdir()) == []


def test_a_world_may_lie_anywhere() -> None:
    world = 'C:\\my "worlds"\\arena.toml'
    file = parse_robot(format_robot_file(load_scenario("arena"), 0, world=world, domain=0, rate_hz=20.0))
    assert file.world == world


def rename_type(name: str) -> Scenario:
    """The arena, whose robot is of a type of that name."""
    scenario = load_scenario("arena")
    (group,), (kind,) = scenario.robots, scenario.types.values()
    return replace(scenario, robots=(replace(group, type=name),), types={name: kind})


@pytest.mark.parametrize("name", ["my rover", "2d", "r\u00f6ver", "r-1"])
def test_names_that_topics_cannot_have_are_refused(name: str) -> None:
    with pytest.raises(SettingError, match=f"types.{name} is not a valid name in ROS 2; begin with a letter"):
        check_ros(rename_type(name))
    check_ros(rename_type("rover_2"))


def test_without_robots_there_is_nothing_to_simulate() -> None:
    with pytest.raises(SettingError, match="robots are none; give one at least"):
        check_ros(replace(load_scenario("arena"), robots=()))


def test_one_of_several_ends_without_who_began_them() -> None:
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    alone = ("--only", "referee", "--parent", os.getpid(), "--seconds", 10**6)
    result = run("robots", "simulate", "arena", "--domain", DOMAIN, *alone)
    assert result.exit_code == 0, result.output


def test_an_interrupt_that_gets_lost_ends_it_nevertheless() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with _leaving_orderly() as left:
        with suppress(KeyboardInterrupt):  # as where something is called back that cannot raise
            signal.raise_signal(signal.SIGTERM)
        assert left.is_set()
    assert signal.getsignal(signal.SIGTERM) is before
