"""The clock of a simulation, as ROS 2 has it: time on /clock, by which programs with `use_sim_time` run."""

from __future__ import annotations

from typing import Any

from understudy.addons.robots.ros.transport import Transport
from understudy.records.messages import MessageRefused, decode_message

CLOCK, TIME = "/clock", "rosgraph_msgs/msg/Clock"


class SimulationClock:
    """The time of a simulation since its clock was first heard; it stands still while nothing new comes.

    A simulation that is reset begins at 0 again; the time here goes on.

    Parameters
    ----------
    transport
        The transport to the robot.
    """

    def __init__(self, transport: Transport) -> None:
        self.stamp_s = 0.0
        """The simulation's own time, for stamps of messages, s."""
        self.heard = 0
        """The number of messages that have come."""
        self._elapsed_s = 0.0
        transport.subscribe(CLOCK, TIME, self._receive)

    def __call__(self) -> float:
        """Return the time since the clock was first heard, s; 0 before."""
        return self._elapsed_s

    def _receive(self, data: bytes, at_s: float) -> None:
        """Take a message; it raises no errors."""
        try:
            message: Any = decode_message(TIME, data)
        except MessageRefused:
            return
        now = message.clock.sec + message.clock.nanosec * 1e-9
        if self.heard:
            self._elapsed_s += max(0.0, now - self.stamp_s)
        self.stamp_s = now
        self.heard += 1
