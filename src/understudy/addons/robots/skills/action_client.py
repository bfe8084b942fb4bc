"""A client of an action of ROS 2, which sends goals, receives feedback and results, and cancels goals.

An action is three services (send_goal, cancel_goal, get_result) and a topic with feedback.
"""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from math import inf
from threading import Lock
from typing import Any, TypeAlias

import numpy as np

from understudy.addons.robots.ros.interfaces import CANCEL, ActionTypes, Interfaces
from understudy.addons.robots.ros.transport import Answered, Transport
from understudy.addons.robots.skills.execution import Execution
from understudy.records.messages import MessageRefused
from understudy.sim.skill_parts import ABORTED, REJECTED, SUCCEEDED

CANCEL_S = 0.5
"""The time for which an answer to a request to cancel is awaited, in s; without one it is sent again."""
CANCELS = 60
"""The largest number of requests to cancel one goal, for each time that it has to be cancelled."""
GOAL_SUCCEEDED = 4
"""The status of a goal that was reached (action_msgs/msg/GoalStatus)."""
GOALS = 16
"""The number of latest goals that are cancelled if they may still run."""
GRACE_S = 5.0
"""The time, in s, for which an answer is awaited after the time limit of a skill."""


class Cancellation:
    """The cancellation of one goal, which starts when the goal has to end. Methods may be called from any thread.

    Parameters
    ----------
    send
        Function that sends the request to cancel the goal, and passes the answer on.
    find_problem
        Function that returns why the request cannot be sent now; empty if it can.
    clock
        Function that returns monotonic time, in s.
    """

    def __init__(
        self, send: Callable[[Answered], None], find_problem: Callable[[], str], clock: Callable[[], float]
    ) -> None:
        self._send, self._find_problem, self._clock = send, find_problem, clock
        self._may_run, self._left, self._due_s = True, 0, -inf
        self._round = 0
        self._lock = Lock()

    def start(self) -> None:
        """Cancel the goal if it may still run: ask at once, unless an answer is awaited."""
        with self._lock:
            if not self._may_run:
                return
            self._left = CANCELS
        self.repeat()

    def restart(self) -> None:
        """Cancel the goal by a new request, for a server that may have answered earlier ones before it had the goal."""
        with self._lock:
            self._may_run, self._due_s = True, -inf
            self._round += 1
        self.start()

    def repeat(self) -> None:
        """Send the request again if it is due; call this often. Nothing is sent while the server is not there."""
        if not self._left or self._find_problem():
            return
        with self._lock:
            now = self._clock()
            if not self._left or now < self._due_s:
                return
            self._left, self._due_s = self._left - 1, now + CANCEL_S
            answered = partial(self._accept_answer, self._round)
        self._send(answered)

    def finish(self) -> None:
        """Send no more requests: the goal does not run."""
        with self._lock:
            self._may_run, self._left = False, 0

    def _accept_answer(self, round: int, answer: bytes | None) -> None:
        if answer is not None and round == self._round:
            self.finish()


ReadFeedback: TypeAlias = Callable[[Any], Mapping[str, float]]


class ActionClient:
    """A client of the action `name` (/rover/navigate_to_pose)."""

    def __init__(
        self,
        name: str,
        types: ActionTypes,
        interfaces: Interfaces,
        transport: Transport,
        read_feedback: ReadFeedback,
        *,
        clock: Callable[[], float],
    ) -> None:
        self._name, self._types, self._interfaces = name, types, interfaces
        self._transport, self._read_feedback, self._clock = transport, read_feedback, clock
        self._cancel = interfaces.find_service(CANCEL)
        self._current: tuple[bytes, Execution] | None = None
        self._cancellations: deque[Cancellation] = deque(maxlen=GOALS)
        self.find_problem()  # over DDS, this connects to the services, so that the first goal can be sent at once
        transport.find_service_problem(f"{name}/_action/get_result", types.get_result.wire)
        self._find_cancel_problem()
        transport.watch(f"{name}/_action/feedback", types.feedback_message, self._hear_feedback)

    def find_problem(self) -> str:
        """Return why goals cannot be sent now; empty if they can."""
        return self._transport.find_service_problem(
            f"{self._name}/_action/send_goal", self._types.send_goal.wire
        )

    def start(self, goal: Any, execution: Execution, *, timeout_s: float) -> None:
        """Send a goal; the execution ends when the robot reports it, or an answer is lost.

        If one is lost, the goal may run on: it is cancelled, and may be so while later goals run.
        """
        id, service = uuid.uuid4().bytes, f"{self._name}/_action/send_goal"
        send_goal, timeout_s = self._types.send_goal, timeout_s + GRACE_S
        if problem := self.find_problem():
            execution.end(REJECTED, problem)
            return
        self._current = (id, execution)
        cancellation = Cancellation(partial(self._send_cancel, id), self._find_cancel_problem, self._clock)
        self._cancellations.append(cancellation)
        request = self._interfaces.make(send_goal.request, goal_id=self._make_id(id), goal=goal)

        def accepted(answer: bytes | None) -> None:
            response = self._decode(send_goal.response, answer)
            if response is None:
                execution.end(ABORTED, f"{self._name} did not answer")
                cancellation.restart()
            elif not response.accepted:
                cancellation.finish()
                execution.end(REJECTED, f"{self._name} did not accept the goal")
            elif execution.runs:
                self._ask_for_result(id, execution, cancellation, timeout_s)
            else:  # cancelled before the robot had heard of the goal
                cancellation.restart()

        data = self._interfaces.encode(send_goal.request, request)
        self._transport.call(service, send_goal.wire, data, accepted, timeout_s=timeout_s)

    def cancel(self) -> None:
        """Cancel all goals that may still run."""
        for each in self._cancellations:
            each.start()

    def repeat_cancellations(self) -> None:
        """Send requests to cancel goals again that were not answered; call this often."""
        for each in self._cancellations:
            each.repeat()

    def _ask_for_result(
        self, id: bytes, execution: Execution, cancellation: Cancellation, timeout_s: float
    ) -> None:
        get_result = self._types.get_result

        def ended(answer: bytes | None) -> None:
            response = self._decode(get_result.response, answer)
            if response is None:
                execution.end(ABORTED, f"{self._name} left")
                cancellation.start()
                return
            cancellation.finish()
            execution.result = response.result
            if response.status == GOAL_SUCCEEDED:
                execution.end(SUCCEEDED)
            else:
                execution.end(ABORTED, f"{self._name} ended with status {response.status}")

        request = self._interfaces.make(get_result.request, goal_id=self._make_id(id))
        data = self._interfaces.encode(get_result.request, request)
        service = f"{self._name}/_action/get_result"
        self._transport.call(service, get_result.wire, data, ended, timeout_s=timeout_s)

    def _find_cancel_problem(self) -> str:
        return self._transport.find_service_problem(f"{self._name}/_action/cancel_goal", self._cancel.wire)

    def _send_cancel(self, id: bytes, answered: Answered) -> None:
        request = self._interfaces.make(self._cancel.request)
        request.goal_info.goal_id = self._make_id(id)
        data = self._interfaces.encode(self._cancel.request, request)
        service = f"{self._name}/_action/cancel_goal"
        self._transport.call(service, self._cancel.wire, data, answered, timeout_s=CANCEL_S)

    def _hear_feedback(self, data: bytes, at_s: float) -> None:
        message = self._decode(self._types.feedback_message.name, data)
        if message is None or self._current is None:
            return
        id, execution = self._current
        if bytes(message.goal_id.uuid) == id and execution.runs:
            execution.feedback = self._read_feedback(message.feedback)

    def _decode(self, type: str, data: bytes | None) -> Any:
        """Decode a message; None if there is no message, or its bytes are invalid."""
        if data is None:
            return None
        try:
            return self._interfaces.decode(type, data)
        except MessageRefused:
            return None

    def _make_id(self, id: bytes) -> Any:
        return self._interfaces.make("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(id, np.uint8))
