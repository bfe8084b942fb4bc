"""Skills of a robot over Zenoh, as rmw_zenoh has them: keys, tokens and attachments of services; programs that die."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.processes import end_with_tests
from tests.robots.routers import Router
from tests.robots.rovers import ODOMETRY, RANGE, TWIST, odometry, sonar
from tests.robots.skill_rigs import DEFINITIONS, OUTCOMES, Conduct, write_skill_robot
from tests.robots.skill_servers import Server
from tests.waiting import wait_until

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.clock import MonotonicClock
from understudy.records.messages import decode_message, encode_twist

ROOT = Path(__file__).parents[2]
ALL = bytes(16)
"""The id that means all goals, as only the watchdog sends it."""
STEP_S = 0.001
"""The time that passes for the robot in a tick, s; ticks of this test are at least five times as long."""


class TickedClock(MonotonicClock):
    """Time that passes only as the test lets it, and waiting in real time, for threads of transports."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


class SkilledRig:
    """A rover over a transport, with a second one as its driver: what arrives there is `heard`.

    Nothing is too late for the robot, however busy the machine is.
    """

    def __init__(self, endpoint: str, text: str | None = None) -> None:
        self.clock = TickedClock()
        self.transport, self.driver = self.open(endpoint), self.open(endpoint)
        self.heard: list[tuple[float, float]] = []
        self.driver.subscribe("/rover/cmd_vel", TWIST, self._obey)
        self.ranges = self.driver.publisher("/rover/sonar", RANGE)
        self.odometries = self.driver.publisher("/rover/odom", ODOMETRY)
        self.robot = Robot(parse_robot(text or write_skill_robot()), self.transport, clock=self.clock)
        self.issued = 0.0

    def open(self, endpoint: str) -> Transport:
        return ZenohTransport(43, endpoint, clock=self.clock)

    def _obey(self, data: bytes, at_s: float) -> None:
        twist = decode_message(TWIST, data)
        self.heard.append((twist.linear.x, twist.angular.z))

    def speak(self) -> None:
        self.ranges(sonar(2.0))
        self.odometries(odometry(0.0))

    def is_heard(self) -> bool:
        self.speak()
        return self.robot.senses.value("sonar_ahead", self.robot.now_s) == 2.0

    def ready(self, *, skills: bool = True) -> None:
        """Arm it once it hears its sensors, and its skills are there."""
        wait_until(lambda: not skills or not self.robot.skills.find_problems())
        wait_until(self._is_armed)

    def _is_armed(self) -> bool:
        if self.is_heard():
            self.robot.arm("Ada")
        return self.robot.armed

    def tick(self, skill: str | None = None, *, anew: bool = False) -> None:
        """One tick in a state that carries out a skill, which was entered now or before."""
        self.clock.now_s += STEP_S
        self.speak()
        self.robot.sense([])
        self.issued += anew
        number = self.robot.index_skill(skill, {"A": "dock"} if skill == "go_to" else {}) if skill else 0
        columns = {"skill": number, "issued": self.issued}
        self.robot.act({name: np.array([float(value)]) for name, value in columns.items()})

    def read(self, name: str) -> float:
        return float(self.robot.sense([(name, None)])[name, None][0])

    def outcomes(self, skill: str = "go_to") -> list[str]:
        return [each for each in OUTCOMES if self.read(f"{skill}_{each}") > 0]

    def run_until(self, reached: Callable[[], object], skill: str = "go_to") -> None:
        """Tick in the same state until something is so."""

        def tick_until() -> object:
            self.tick(skill)
            return reached()

        wait_until(tick_until)

    def close(self) -> None:
        self.robot.close()
        self.driver.close()


@contextmanager
def open_rig(
    router: Router, conduct: Conduct = "succeed", text: str | None = None, **about: Any
) -> Iterator[tuple[SkilledRig, Server]]:
    with Server(router.endpoint, conduct, **about) as server:
        rig = SkilledRig(router.endpoint, text)
        try:
            rig.ready(skills=not about)
            yield rig, server
        finally:
            rig.close()


def starts(rig: SkilledRig) -> None:
    """Let it begin to carry out go_to(dock), until its server tells how far that is."""
    rig.tick("go_to", anew=True)
    rig.run_until(lambda: not isnan(rig.read("go_to_distance_remaining")))


def leaves(rig: SkilledRig, server: Server) -> None:
    starts(rig)
    rig.tick(anew=True)
    wait_until(lambda: server.cancelled)
    rig.tick()
    assert rig.outcomes() == []


def is_disarmed(rig: SkilledRig, server: Server) -> None:
    starts(rig)
    sent = len(rig.heard)
    rig.robot.disarm("Ada said so")
    wait_until(lambda: server.cancelled and len(rig.heard) > sent)
    assert rig.heard[-1] == (0.0, 0.0)
    assert len(server.goals) == 1


def leaves_at_once(rig: SkilledRig, server: Server) -> None:
    """The robot had not heard of the goal yet."""
    rig.tick("go_to", anew=True)
    rig.tick(anew=True)
    wait_until(lambda: server.cancels and all(each.is_set() for each in server.cancels.values()))


def ends(rig: SkilledRig, server: Server) -> None:
    """The goal, and then a service that is called once."""
    outcome = {"succeed": "succeeded", "abort": "aborted", "reject": "rejected"}[server.conduct]
    rig.tick("go_to", anew=True)
    rig.run_until(rig.outcomes)
    assert rig.outcomes() == [outcome]
    pose = server.goals[0].goal.pose
    assert (pose.header.frame_id, pose.pose.position.x, pose.pose.position.y) == ("map", 1.5, -2.0)
    assert (len(server.goals), server.cancelled) == (1, [])
    if outcome != "rejected":
        assert rig.read("go_to_distance_remaining") == 1.0
        rig.tick("beep", anew=True)
        rig.run_until(lambda: rig.outcomes("beep"), "beep")
        assert (rig.outcomes("beep"), server.requests) == ([outcome], 1)


def is_never_answered(rig: SkilledRig, server: Server) -> None:
    for skill in ("go_to", "beep"):
        rig.tick(skill, anew=True)
        rig.run_until(lambda: rig.outcomes(skill), skill)  # noqa: B023
        assert rig.outcomes(skill) == ["timed_out"]


SHORT = write_skill_robot().replace("timeout_s = 30", "timeout_s = 0.05")
TRIALS: list[tuple[Callable[[SkilledRig, Server], None], Conduct, str | None]] = [
    (ends, "succeed", None),
    (ends, "abort", None),
    (ends, "reject", None),
    (leaves, "run", None),
    (leaves_at_once, "run", None),
    (is_disarmed, "run", None),
    (is_never_answered, "silent", SHORT),
]


@pytest.mark.timed
@pytest.mark.parametrize(("tries", "conduct", "text"), TRIALS)
def test_goals_and_services_over_zenoh(
    router: Router, tries: Callable[[SkilledRig, Server], None], conduct: Conduct, text: str | None
) -> None:
    with open_rig(router, conduct, text) as (rig, server):
        tries(rig, server)


@pytest.mark.timed
def test_a_server_of_another_definition_is_told(router: Router, tmp_path: Path) -> None:
    """Its hash differs: a goal of ours would be garbage to it."""
    (tmp_path / "nav2_msgs" / "action").mkdir(parents=True)
    (tmp_path / "std_srvs" / "srv").mkdir(parents=True)
    for part in ("nav2_msgs/action/NavigateToPose.action", "std_srvs/srv/Trigger.srv"):
        text = (DEFINITIONS / part).read_text().replace("string behavior_tree", "string tree")
        (tmp_path / part).write_text(text)
    with open_rig(router, definitions=tmp_path) as (rig, server):
        said = "has another definition of nav2_msgs/action/NavigateToPose_SendGoal"
        wait_until(lambda: said in rig.robot.skills.find_problems().get("go_to", ""))
        rig.tick("go_to", anew=True)
        assert (rig.outcomes(), server.goals) == (["rejected"], [])


@pytest.mark.timed
def test_a_server_that_dies_aborts_the_goal_and_rejects_the_next(router: Router) -> None:
    command = end_with_tests([sys.executable, "-m", "tests.robots.skill_servers", router.endpoint])
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=ROOT) as process:
        rig = SkilledRig(router.endpoint)
        try:
            rig.ready()
            starts(rig)
            process.kill()
            rig.run_until(rig.outcomes)
            assert rig.outcomes() == ["aborted"]
            wait_until(rig.robot.skills.find_problems)
            rig.tick("go_to", anew=True)
            rig.run_until(rig.outcomes)
            assert rig.outcomes() == ["rejected"]
            assert "nobody offers /rover/navigate_to_pose" in rig.robot.skills.skills["go_to"].last.problem
        finally:
            process.kill()
            rig.close()


@pytest.mark.timed
def test_a_goal_is_cancelled_when_its_router_restarts() -> None:
    """Its server goes on meanwhile: the answer is lost, so it counts as aborted, and has to be cancelled."""
    first = Router()
    with open_rig(first, "run") as (rig, server):
        starts(rig)
        first.close()
        rig.run_until(rig.outcomes)
        assert (rig.outcomes(), server.cancelled) == (["aborted"], [])
        with Router(first.endpoint):
            rig.run_until(lambda: all(each.is_set() for each in server.cancels.values()))
        assert len(server.goals) == 1


@pytest.mark.timed
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_the_watchdog_cancels_the_goal_of_a_program_that_is_gone(
    tmp_path: Path, number: signal.Signals
) -> None:
    """On a router of its own: a watchdog goes on for a second, and would cancel the goals of the next test."""
    path, heard = tmp_path / "rover.toml", list[bytes]()
    with Router() as router, Server(router.endpoint, "run") as server:
        path.write_text(write_skill_robot().replace("[limits]", f'router = "{router.endpoint}"\n[limits]', 1))
        driver = ZenohTransport(43, router.endpoint)
        driver.subscribe("/rover/cmd_vel", TWIST, lambda data, _: heard.append(data))
        ranges = driver.publisher("/rover/sonar", RANGE)

        def goes_on() -> bool:
            """Whether a goal runs that was not cancelled: on a busy machine, the robot is stopped now and then."""
            ranges(sonar(2.0))
            ids = [bytes(goal.goal_id.uuid) for goal in server.goals]
            return bool(ids) and ids[-1] in server.asked and not server.cancels[ids[-1]].is_set()

        command = end_with_tests([sys.executable, "-m", "tests.robots.skill_decider", str(path)])
        with subprocess.Popen(command, cwd=ROOT) as decider:
            try:
                wait_until(goes_on)
                sent, asked = len(heard), len(server.cancelled)
                decider.send_signal(number)
                wait_until(lambda: ALL in server.cancelled[asked:] and len(heard) > sent)
                assert set(heard) == {encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=0.0)}
                assert all(each.is_set() for each in server.cancels.values())
            finally:
                decider.kill()
                driver.close()
