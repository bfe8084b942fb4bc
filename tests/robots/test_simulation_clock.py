"""Robots that tick by the clock of a simulation: faster, slower, not at all, and begun anew."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, STAMPED, Wire, sonar
from tests.robots.twins import ARENA
from tests.runtime.agents.test_lost_agents import make_team
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.diagnostics import diagnose_connection
from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.simulation_clock import CLOCK, TIME, SimulationClock
from understudy.addons.robots.twin import DigitalTwin
from understudy.model.library import Library
from understudy.records.messages import decode_message, encode_message, make_message
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.network import LocalNetwork
from understudy.sim.kit import make_scenario_kit
from understudy.ui.cli.commands.run_robot import LOOK_S, LiveRun

SIMULATED = "use_sim_time = true\n"


def clock_at(seconds: float) -> bytes:
    whole = int(seconds)
    now = make_message("builtin_interfaces/msg/Time", sec=whole, nanosec=round((seconds - whole) * 1e9))
    return encode_message(TIME, make_message(TIME, clock=now))


TIMES = [  # what comes on /clock, and the time since the first of it
    ([], 0.0),
    ([1234.5], 0.0),
    ([1234.5, 1235.0], 0.5),
    ([1234.5, 1234.5], 0.0),
    ([1234.5, 1235.0, 0.0, 0.25], 0.75),  # the simulation was reset
]


@pytest.mark.parametrize(("came", "elapsed"), TIMES)
def test_time_is_what_has_passed_in_the_simulation(came: list[float], elapsed: float) -> None:
    wire = Wire()
    clock = SimulationClock(wire)
    wire.deliver(CLOCK, b"\x00\x01\x00\x00", 0.0)
    for seconds in came:
        wire.deliver(CLOCK, clock_at(seconds), 0.0)
    assert clock() == pytest.approx(elapsed)


def test_a_robot_has_the_time_and_the_stamps_of_the_simulation() -> None:
    wire, clock = Wire(), SimulatedClock()
    text = SIMULATED + ROVER.replace("[commands]", f'[commands]\ntype = "{STAMPED}"')
    robot = Robot(parse_robot(text), wire, clock=clock)
    wire.deliver("/rover/sonar", sonar(1.0), clock())
    for seconds in (50.0, 53.25):
        wire.deliver(CLOCK, clock_at(seconds), clock())
    robot.sense([("sonar_ahead", None)])
    assert robot.time_s == 3.25
    robot.arm("Ada")
    robot.act({"drive": np.array([1.0])})
    stamp = decode_message(STAMPED, wire.sent[-1][1]).header.stamp
    assert (stamp.sec, stamp.nanosec) == (53, 250_000_000)


def test_a_robot_whose_simulation_stands_still_is_stopped() -> None:
    """By this computer's clock: no tick comes."""
    wire, clock = Wire(), SimulatedClock()
    robot = Robot(parse_robot(SIMULATED + ROVER), wire, clock=clock)
    wire.deliver("/rover/sonar", sonar(1.0), 100.0)
    wire.deliver(CLOCK, clock_at(50.0), 100.0)
    robot.sense([("sonar_ahead", None)])
    robot.arm("Ada")
    robot.act({"drive": np.array([1.0])})
    assert robot.stop_cause == ""
    clock.advance(0.3)
    wire.deliver("/rover/sonar", sonar(1.0), clock())
    robot.guard.check()
    assert robot.stop_cause != ""


@dataclass
class Simulation:
    """A simulation that advances a little each time the program sleeps."""

    wire: Wire
    rate: float
    seconds: float = 10.0
    slept_s: float = 0.0

    def sleep(self, seconds: float) -> None:
        self.slept_s += seconds
        self.seconds += seconds * self.rate
        self.wire.deliver(CLOCK, clock_at(self.seconds), 0.0)


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_ticks_follow_the_simulation(rate: float) -> None:
    wire = Wire()
    simulation = Simulation(wire, rate)
    twin = DigitalTwin(Fleet([Robot(parse_robot(SIMULATED + ARENA.format(name="one", world="arena")), wire)]))
    wire.deliver(CLOCK, clock_at(10.0), 0.0)
    library = Library(make_scenario_kit(twin.scenario))
    run = LiveRun(twin, dict.fromkeys(twin.scenario.types, library), {}, sleep=simulation.sleep)
    while run.ticks < 21:
        run.tick()
    assert simulation.slept_s == pytest.approx(2.0 / rate, abs=0.2)
    assert twin.time_s == pytest.approx(2.0, abs=0.1)


def test_a_run_whose_simulation_stands_still_still_looks_at_keys() -> None:
    wire = Wire()
    twin = DigitalTwin(Fleet([Robot(parse_robot(SIMULATED + ARENA.format(name="one", world="arena")), wire)]))
    library = Library(make_scenario_kit(twin.scenario))
    slept: list[float] = []
    run = LiveRun(twin, dict.fromkeys(twin.scenario.types, library), {}, sleep=slept.append)
    for _ in range(3):
        run.tick()
    assert run.ticks == 1
    assert set(slept) == {LOOK_S}


def test_leases_go_by_the_computers_own_clock() -> None:
    """The body's time stands still, and the order ends all the same."""
    now = [0.0]
    network = LocalNetwork()
    team = make_team(network, deputies=(), near=-1e9)
    node = network.join("scout_1")
    row = team.rows["scout_1"]
    team.robots["scout_1"] = agent = Agent(
        team.plan.make_agent_spec("scout_1"), row, node, clock=lambda: now[0]
    )
    for _ in range(3):
        team.tick()
        now[0] += 0.1
    assert agent.follower is not None
    assert agent.follower.order is not None
    team.stop("pair_0")
    for _ in range(12):
        agent.sense()
        agent.obey()
        now[0] += 0.1
    assert agent.follower.order is None


def test_a_clock_that_never_comes_is_reported_by_the_check() -> None:
    robot = Robot(parse_robot(SIMULATED + ROVER), Wire())
    said = [each for each in diagnose_connection(robot, seconds=0.0).problems if "/clock" in each]
    assert said == [
        "use_sim_time: nothing comes on /clock; start the simulation with its clock, or leave it out of the file"
    ]
