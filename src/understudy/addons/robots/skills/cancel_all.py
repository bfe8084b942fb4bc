"""Cancel all goals of a robot's actions, from any sender, by a program that knows none of them."""

from __future__ import annotations

from collections.abc import Callable

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.interfaces import CANCEL, Interfaces
from understudy.addons.robots.ros.transport import Transport
from understudy.clock import REAL_TIME

AGAIN_S = 0.2
"""The time between two requests while the function that sends them is called often, in s."""
ANSWER_S = 1.0
"""The time for which an answer is awaited, in s; nothing depends on it."""


def make_cancel_sender(
    file: RobotFile, transport: Transport, *, clock: Callable[[], float] = REAL_TIME
) -> Callable[[], None]:
    """Make a function that asks all actions of a robot file to cancel all their goals.

    It may be called often: requests are `AGAIN_S` apart. A goal id and a time of zero mean all goals.
    """
    actions = {file.topic(skill.action) for skill in file.skills.values() if skill.action is not None}
    if not actions:
        return lambda: None
    interfaces = Interfaces()
    service = interfaces.find_service(CANCEL)
    request = interfaces.encode(service.request, interfaces.make(service.request))
    last_s = -AGAIN_S
    for action in actions:  # over DDS, this connects to the service
        transport.find_service_problem(f"{action}/_action/cancel_goal", service.wire)

    def cancel() -> None:
        nonlocal last_s
        now = clock()
        if now - last_s < AGAIN_S:
            return
        last_s = now
        for action in actions:
            transport.call(
                f"{action}/_action/cancel_goal", service.wire, request, lambda _: None, timeout_s=ANSWER_S
            )

    return cancel
