"""A client of a service of ROS 2, whose answer is the outcome of a skill."""

from __future__ import annotations

from typing import Any

from understudy.addons.robots.ros.interfaces import Interfaces, ServiceTypes
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.skills.action_client import GRACE_S
from understudy.addons.robots.skills.execution import Execution
from understudy.records.messages import MessageRefused
from understudy.sim.skill_parts import ABORTED, REJECTED, SUCCEEDED

SUCCESS = "success"
"""The field of a response that says whether it went well, as in std_srvs; without it, any answer counts as success."""


class ServiceClient:
    """A client of the service `name` (/rover/beep). A request cannot be taken back."""

    def __init__(self, name: str, types: ServiceTypes, interfaces: Interfaces, transport: Transport) -> None:
        self._name, self._types = name, types
        self._interfaces, self._transport = interfaces, transport
        self.find_problem()  # over DDS, this connects to the service

    def find_problem(self) -> str:
        """Return why requests cannot be sent now; empty if they can."""
        return self._transport.find_service_problem(self._name, self._types.wire)

    def cancel(self) -> None:
        """Do nothing: a request cannot be taken back."""

    def repeat_cancellations(self) -> None:
        """Do nothing: there are none."""

    def start(self, request: Any, execution: Execution, *, timeout_s: float) -> None:
        """Send a request; the execution ends with its answer."""
        types = self._types
        if problem := self.find_problem():
            execution.end(REJECTED, problem)
            return

        def answered(answer: bytes | None) -> None:
            try:
                response = None if answer is None else self._interfaces.decode(types.response, answer)
            except MessageRefused as error:
                execution.end(ABORTED, error.problem)
                return
            execution.result = response
            if response is None:
                execution.end(ABORTED, f"{self._name} did not answer")
            elif getattr(response, SUCCESS, True):
                execution.end(SUCCEEDED)
            else:
                execution.end(ABORTED, f"{self._name} answered that it failed")

        data = self._interfaces.encode(types.request, request)
        self._transport.call(self._name, types.wire, data, answered, timeout_s=timeout_s + GRACE_S)
