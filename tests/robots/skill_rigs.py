"""A rover with skills over a wire in memory: its servers behave as a test says, by the clock of the test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from tests.robots.rovers import ROVER, TWIST, Wire, odometry, sonar
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.recording_transport import RecordingTransport
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.interfaces import CANCEL, Interfaces
from understudy.addons.robots.ros.transport import Answered, Transport, WireType
from understudy.records.messages import decode_message
from understudy.records.recorder import RunRecorder

DEFINITIONS = Path(__file__).with_name("interfaces")
NAVIGATE, TRIGGER = "nav2_msgs/action/NavigateToPose", "std_srvs/srv/Trigger"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
Conduct: TypeAlias = Literal["run", "succeed", "abort", "reject", "silent"]
SKILLS = f"""
definitions = "{DEFINITIONS}"
transport = "zenoh"
"""
TABLES = """
[skills.go_to]
action = "navigate_to_pose"
type = "nav2_msgs/action/NavigateToPose"
goal = { "pose.header.frame_id" = "map", "pose.pose.position.x" = "A.x", "pose.pose.position.y" = "A.y" }
feedback = ["distance_remaining"]
timeout_s = 30
moves = true

[skills.beep]
service = "beep"
type = "std_srvs/srv/Trigger"
timeout_s = 30

[targets.dock]
at = [1.5, -2.0]

[targets.home]
at = [0.0, 0.5]
"""
OUTCOMES = ("succeeded", "aborted", "rejected", "timed_out")
TICK_S, CHECKS = 0.1, 5
"""The time between ticks, and the number of checks of the guard in it."""
PATIENCE_S = 60.0


def write_skill_robot(tables: str = TABLES) -> str:
    """The robot file of a rover with skills."""
    return ROVER.replace("\n[limits]", f"{SKILLS}\n[limits]", 1) + tables


@dataclass
class Call:
    """A call of a service that has not been answered."""

    service: str
    request: bytes
    answered: Answered
    due_s: float


class ServedWire(Wire):
    """A wire with the action /rover/navigate_to_pose and the service /rover/beep; `conduct` says what they do.

    A goal sends feedback (the distance left: 3, 2, 1) and ends as `conduct` says; "run" goes on until cancelled. What
    was called is answered, and feedback arrives, when `serve` is called.
    """

    def __init__(self, clock: Callable[[], float], conduct: Conduct = "succeed") -> None:
        super().__init__()
        self.conduct, self._clock = conduct, clock
        self.is_there = True
        self.goals: list[Any] = []
        self.requests = 0
        self.cancelled: list[bytes] = []
        """The ids of goals that were to be cancelled, one for each request."""
        self._ended: set[bytes] = set()
        self._left: dict[bytes, list[float]] = {}
        self._calls: list[Call] = []
        self._feedback: list[Callable[[bytes, float], None]] = []
        self._interfaces = Interfaces(DEFINITIONS)
        self._types, self._cancel = (
            self._interfaces.find_action(NAVIGATE),
            self._interfaces.find_service(CANCEL),
        )
        self._trigger = self._interfaces.find_service(TRIGGER)

    def watch(self, topic: str, type: WireType, received: Callable[[bytes, float], None]) -> None:
        self._feedback.append(received)

    def find_service_problem(self, service: str, type: WireType) -> str:
        return "" if self.is_there else f"nobody offers {service}"

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        self.sent.append((service, request))
        if service.endswith("cancel_goal"):  # counted at once: whatever stops the robot must not wait
            asked = self._interfaces.decode(self._cancel.request, request)
            self.cancelled.append(bytes(asked.goal_info.goal_id.uuid))
        self._calls.append(Call(service, request, answered, self._clock() + timeout_s))

    def leave(self) -> None:
        """Let the servers die: what was called is not answered, and nothing can be called."""
        self.is_there = False
        calls, self._calls = self._calls, []
        for each in calls:
            each.answered(None)

    def serve(self) -> None:
        """Answer what was called before, and send feedback of the goals that run."""
        calls, self._calls = self._calls, []
        for each in calls:
            if each.due_s <= self._clock():
                each.answered(None)
            elif not self._serve(each.service.rpartition("/")[2], each):
                self._calls.append(each)

    def _serve(self, name: str, call: Call) -> bool:
        """Answer a call; return False if it has to wait."""
        return {
            "send_goal": self._accept,
            "get_result": self._tell_result,
            "cancel_goal": self._take_back,
            "beep": self._beep,
        }[name](call)

    def _answer(self, call: Call, type: str, **values: Any) -> bool:
        call.answered(self._interfaces.encode(type, self._interfaces.make(type, **values)))
        return True

    def _accept(self, call: Call) -> bool:
        if self.conduct == "silent":
            return False
        request = self._interfaces.decode(self._types.send_goal.request, call.request)
        self.goals.append(request)
        self._left[bytes(request.goal_id.uuid)] = [3.0, 2.0, 1.0]
        return self._answer(call, self._types.send_goal.response, accepted=self.conduct != "reject")

    def _tell_result(self, call: Call) -> bool:
        request = self._interfaces.decode(self._types.get_result.request, call.request)
        id, answer = bytes(request.goal_id.uuid), partial(self._answer, call, self._types.get_result.response)
        if id in self._ended:
            return answer(status=CANCELED)
        if self._left[id]:
            feedback = self._interfaces.make(f"{NAVIGATE}_Feedback", distance_remaining=self._left[id].pop(0))
            type = self._types.feedback_message.name
            message = self._interfaces.make(type, goal_id=request.goal_id, feedback=feedback)
            for received in self._feedback:
                received(self._interfaces.encode(type, message), self._clock())
            return False
        if self.conduct == "run":
            return False
        return answer(status=ABORTED if self.conduct == "abort" else SUCCEEDED)

    def _take_back(self, call: Call) -> bool:
        request = self._interfaces.decode(self._cancel.request, call.request)
        id = bytes(request.goal_info.goal_id.uuid)
        self._ended |= {*self._left} if id == bytes(16) else {id}
        return self._answer(call, self._cancel.response)

    def _beep(self, call: Call) -> bool:
        if self.conduct == "silent":
            return False
        self.requests += 1
        return self._answer(call, self._trigger.response, success=self.conduct == "succeed")


class SkillRig:
    """A rover in simulated time whose skills are served by `wire`, and what it was sent (`heard`)."""

    def __init__(
        self,
        conduct: Conduct = "succeed",
        text: str | None = None,
        *,
        path: Path = Path("robot.toml"),
        recorder: RunRecorder | None = None,
        clock: SimulatedClock | None = None,
    ) -> None:
        self.clock = clock or SimulatedClock()
        self.wire = ServedWire(self.clock, conduct)
        transport: Transport = self.wire
        if recorder is not None:
            transport = RecordingTransport(transport, recorder)
        self.robot = Robot(parse_robot(text or write_skill_robot()), transport, path=path, clock=self.clock)
        self.issued, self.target, self.decided_s = 0.0, "dock", -inf

    @property
    def heard(self) -> list[tuple[float, float]]:
        """The speeds that were sent, m/s and rad/s."""
        twists = [decode_message(TWIST, data) for topic, data in self.wire.sent if topic == "/rover/cmd_vel"]
        return [(twist.linear.x, twist.angular.z) for twist in twists]

    def speak(self) -> None:
        """Let the sensors speak."""
        self.wire.deliver("/rover/sonar", sonar(2.0), self.clock())
        self.wire.deliver("/rover/odom", odometry(0.0), self.clock())

    def ready(self) -> SkillRig:
        """Arm it, all its readings there."""
        self.speak()
        self.robot.arm("Ada")
        return self

    def pass_tick(self) -> None:
        """Let the time of a tick pass, in which its guard looks, its sensors speak and its skills are served."""
        for _ in range(CHECKS):
            self.pass_check()

    def pass_check(self) -> None:
        """Let the time pass until the guard looks again."""
        self.clock.advance(TICK_S / CHECKS)
        self.speak()
        self.wire.serve()
        self.robot.guard.check()

    def tick(self, skill: str | None = None, **about: Any) -> None:
        """Decide as `act` does; then the time of the tick passes."""
        self.act(skill, **about)
        self.pass_tick()

    def act(
        self, skill: str | None = None, *, anew: bool = False, drive: float = 0.0, to: str | None = None
    ) -> None:
        """Decide in a state that carries out a skill, which was entered now or before."""
        self.decided_s = self.clock()
        self.robot.sense([])
        self.issued += anew
        self.target = to or self.target
        binding = {"A": self.target} if skill == "go_to" else {}
        number = self.robot.index_skill(skill, binding) if skill else 0
        columns = {"drive": drive, "skill": number, "issued": self.issued}
        self.robot.act({name: np.array([float(value)]) for name, value in columns.items()})

    def read(self, name: str) -> float:
        """A reading of this tick."""
        return float(self.robot.sense([(name, None)])[name, None][0])

    def outcomes(self, skill: str = "go_to") -> list[str]:
        """The outcome that its readings say; empty while there is none."""
        return [each for each in OUTCOMES if self.read(f"{skill}_{each}") > 0]

    def run_until(self, reached: Callable[[], object], skill: str = "go_to") -> None:
        """Tick in the same state until something is so."""
        until_s = self.clock() + PATIENCE_S
        while not reached():
            assert self.clock() < until_s, "it was never so"
            self.tick(skill)
