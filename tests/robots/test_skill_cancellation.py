"""Cancellations of goals whose answers were lost: over a wire whose services answer when a test says so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rigs import ODOM, SONAR, Rig
from tests.robots.rovers import Wire, odometry, sonar
from tests.robots.skill_rigs import DEFINITIONS, NAVIGATE, OUTCOMES, write_skill_robot

from understudy.addons.robots.ros.interfaces import CANCEL, Interfaces
from understudy.addons.robots.ros.transport import Answered, WireType
from understudy.addons.robots.skills.action_client import CANCEL_S, CANCELS

INTERFACES = Interfaces(DEFINITIONS)
TYPES, CANCEL_TYPES = INTERFACES.find_action(NAVIGATE), INTERFACES.find_service(CANCEL)
ACCEPTED = INTERFACES.encode(
    TYPES.send_goal.response, INTERFACES.make(TYPES.send_goal.response, accepted=True)
)
REFUSED = INTERFACES.encode(TYPES.send_goal.response, INTERFACES.make(TYPES.send_goal.response))
REACHED = INTERFACES.encode(TYPES.get_result.response, INTERFACES.make(TYPES.get_result.response, status=4))
CANCELLED = INTERFACES.encode(CANCEL_TYPES.response, INTERFACES.make(CANCEL_TYPES.response))
TICK_S = 0.1


class ServiceWire(Wire):
    """Services that are there if `offered`, and whose latest requests wait in `waiting` for their answers."""

    def __init__(self) -> None:
        super().__init__()
        self.offered = True
        self.goals: list[bytes] = []
        self.cancelled: list[bytes] = []
        """The ids of goals that were to be cancelled, one for each request."""
        self.waiting: dict[str, Answered] = {}

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        name = service.rpartition("/")[2]
        self.waiting[name] = answered
        if name == "send_goal":
            goal = INTERFACES.decode(TYPES.send_goal.request, request)
            self.goals.append(bytes(goal.goal_id.uuid))
        elif name == "cancel_goal":
            goal = INTERFACES.decode(CANCEL_TYPES.request, request).goal_info
            self.cancelled.append(bytes(goal.goal_id.uuid))

    def find_service_problem(self, service: str, type: WireType) -> str:
        return "" if self.offered else f"nobody offers {service}"

    def answer(self, name: str, data: bytes | None) -> None:
        self.waiting.pop(name)(data)


class SkillRig:
    """An armed rover that carries out go_to(dock), by a clock that `tick` sets."""

    def __init__(self) -> None:
        self.wire, self.issued = ServiceWire(), 0.0
        self.rig = Rig(write_skill_robot(), wire=self.wire).ready()
        self.robot = self.rig.robot

    def tick(self, skill: str | None = "go_to", *, anew: bool = False) -> None:
        self.rig.now += TICK_S
        self.rig.hear(SONAR, sonar(2.0))
        self.rig.hear(ODOM, odometry(0.0))
        self.robot.sense([])
        self.issued += anew
        number = self.robot.index_skill(skill, {"A": "dock"}) if skill else 0
        columns = {"skill": number, "issued": self.issued}
        self.robot.act({name: np.array([float(value)]) for name, value in columns.items()})

    def wait(self, seconds: float, skill: str | None = "go_to") -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick(skill)

    def lose(self, name: str) -> None:
        """Send a goal, and lose the answer of one of its services."""
        self.tick(anew=True)
        if name == "get_result":
            self.wire.answer("send_goal", ACCEPTED)
        self.wire.answer(name, None)

    @property
    def outcomes(self) -> list[str]:
        last = self.robot.skills.skills["go_to"].last.outcome
        return [each for each in OUTCOMES if each == last]


SERVICES = ["send_goal", "get_result"]


@pytest.mark.parametrize("lost", SERVICES)
def test_a_goal_whose_answer_is_lost_is_cancelled_until_that_is_answered(lost: str) -> None:
    """It counts as aborted at once; the goal may run on, so it is cancelled at once, too."""
    rig = SkillRig()
    rig.lose(lost)
    assert (rig.outcomes, rig.wire.cancelled) == (["aborted"], rig.wire.goals)
    rig.wire.answer("cancel_goal", None)
    rig.wait(CANCEL_S + TICK_S)
    assert rig.wire.cancelled == rig.wire.goals * 2
    rig.wire.answer("cancel_goal", CANCELLED)
    rig.wait(3 * CANCEL_S)
    rig.tick(None)
    assert rig.wire.cancelled == rig.wire.goals * 2


@pytest.mark.parametrize("lost", SERVICES)
def test_a_goal_is_cancelled_once_its_server_is_there_again(lost: str) -> None:
    rig = SkillRig()
    rig.tick(anew=True)
    if lost == "get_result":
        rig.wire.answer("send_goal", ACCEPTED)
    rig.wire.offered = False
    rig.wire.answer(lost, None)
    rig.wait(CANCEL_S * CANCELS * 2)
    assert rig.wire.cancelled == []
    rig.wire.offered = True
    rig.tick()
    assert rig.wire.cancelled == rig.wire.goals


LEAVES: list[Callable[[SkillRig], object]] = [
    lambda rig: rig.tick(None),
    lambda rig: rig.robot.disarm("Ada said so"),
    lambda rig: rig.robot.guard.stop_until_next_command("a test"),
    lambda rig: rig.robot.close(),
]


STOPPED = [*(("go_to", leave) for leave in LEAVES), *((None, leave) for leave in LEAVES[1:])]


@pytest.mark.parametrize(("state", "leave"), STOPPED)
def test_what_stops_the_robot_cancels_a_goal_whose_answer_was_lost(
    state: str | None, leave: Callable[[SkillRig], object]
) -> None:
    """It is in the goal's state or in another one, and requests were repeated in vain as often as they may be."""
    rig = SkillRig()
    rig.lose("get_result")
    rig.wait(CANCEL_S * CANCELS * 3, state)
    before = len(rig.wire.cancelled)
    rig.wait(3 * CANCEL_S, state)
    assert CANCELS <= before == len(rig.wire.cancelled) <= 2 * CANCELS
    leave(rig)
    assert rig.wire.cancelled == rig.wire.goals * (before + 1)


def test_a_new_goal_runs_while_the_one_before_is_cancelled() -> None:
    rig = SkillRig()
    rig.lose("get_result")
    rig.tick(anew=True)
    rig.wire.answer("send_goal", ACCEPTED)
    rig.wait(3 * CANCEL_S)
    first, second = rig.wire.goals
    assert len(rig.wire.cancelled) >= 3
    assert set(rig.wire.cancelled) == {first}
    rig.wire.answer("get_result", REACHED)
    assert rig.outcomes == ["succeeded"]
    assert second not in rig.wire.cancelled


def test_a_cancellation_is_repeated_while_the_program_is_paused() -> None:
    """A paused session senses nothing, and commands rest."""
    rig = SkillRig()
    rig.lose("get_result")
    for _ in range(10):
        rig.rig.now += TICK_S
        rig.rig.hear(SONAR, sonar(2.0))
        rig.robot.act({})
    assert len(rig.wire.cancelled) >= 2


def test_a_goal_that_the_robot_heard_of_late_is_cancelled_again() -> None:
    """A server may answer a request to cancel before it has the goal, of which it says that it is unknown."""
    rig = SkillRig()
    rig.tick(anew=True)
    rig.tick(None)
    early = rig.wire.waiting["cancel_goal"]
    rig.wire.answer("send_goal", ACCEPTED)
    early(CANCELLED)
    assert rig.wire.cancelled == rig.wire.goals * 2
    rig.wait(CANCEL_S + TICK_S, None)
    assert rig.wire.cancelled == rig.wire.goals * 3
    rig.wire.answer("cancel_goal", CANCELLED)
    rig.wait(3 * CANCEL_S, None)
    assert rig.wire.cancelled == rig.wire.goals * 3


ENDS = [  # the answers to a goal
    {"send_goal": REFUSED},
    {"send_goal": ACCEPTED, "get_result": REACHED},
]


@pytest.mark.parametrize("answers", ENDS, ids=["rejected", "reached"])
def test_a_goal_whose_end_is_reported_is_not_cancelled(answers: dict[str, bytes]) -> None:
    rig = SkillRig()
    rig.tick(anew=True)
    for name, data in answers.items():
        rig.wire.answer(name, data)
    rig.tick(None)
    rig.robot.disarm("Ada said so")
    assert rig.wire.cancelled == []


def test_a_result_ends_a_cancellation_that_is_not_answered() -> None:
    rig = SkillRig()
    rig.tick(anew=True)
    rig.wire.answer("send_goal", ACCEPTED)
    rig.tick(None)
    rig.wire.answer("get_result", REACHED)
    rig.wait(3 * CANCEL_S, None)
    assert rig.wire.cancelled == rig.wire.goals
