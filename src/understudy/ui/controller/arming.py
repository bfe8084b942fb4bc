"""Arm, stop and supervise real robots from a user interface: the studio's page or the terminal.

`RobotArming` has no thread: the interface calls `refresh_heartbeat` whenever the person's side reports, and `idle` many
times a second. A person's side that is silent for `SILENT_S` disarms the robots. Where the interface itself hangs,
nothing here runs: then the guard stops the robots, since no command comes (`robots.safety.guard`). `wall` is monotonic.
"""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct

from understudy.addons.robots.arming_order import ArmingOrder
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.twin import DigitalTwin, Ground
from understudy.errors import SessionError, UnknownName

SILENT_S = 0.6
"""How long the page in control may be silent, s, before robots are disarmed; it reports every 0.15 s."""
HELD_S = 0.4
"""How long the hold-to-run key counts as held after a report that it is, s."""


class RobotStatus(Struct, frozen=True, kw_only=True):
    """A real robot's name, whether it is armed, and why it is stopped or disarmed (empty while it may move)."""

    name: str
    armed: bool
    stopped: str


class RobotArming:
    """Arm and stop the real robots of a session; with simulated ones, do nothing, and refuse to arm.

    `place` ("the studio") names the interface in the log of stops, and as the one that armed.
    """

    def __init__(self, ground: Ground, wall: Callable[[], float], *, place: str) -> None:
        self._place = place
        self._twin = ground if isinstance(ground, DigitalTwin) else None
        self._wall = wall
        self._heard_s = wall()

    @property
    def has_robots(self) -> bool:
        """Whether the session has real robots."""
        return self._twin is not None

    @property
    def armed(self) -> bool:
        """Whether any of them is armed."""
        return self._twin is not None and self._twin.fleet.armed

    def list_statuses(self) -> list[RobotStatus]:
        """List the state of each real robot; none where they are simulated."""
        if self._twin is None:
            return []
        return [
            RobotStatus(name=robot.file.name, armed=robot.armed, stopped=robot.stop_cause)
            for robot in self._twin.fleet
        ]

    def order_arming(self, name: str | None = None) -> ArmingOrder:
        """Return a person's order to arm the robot of this name, or all or none; carry it out in another thread.

        Raises SessionError with simulated robots.
        """
        if self._twin is None:
            raise SessionError("these robots are simulated and need not be armed")
        self._heard_s = self._wall()
        robots = self._twin.fleet.robots if name is None else [self._find_robot(name)]
        return ArmingOrder(robots, self._place)

    def stop_one(self, name: str, cause: str) -> None:
        """Send the robot of this name a stop at once and disarm it, armed or not."""
        self._find_robot(name).emergency_stop(cause)

    def _find_robot(self, name: str) -> Robot:
        robots = {} if self._twin is None else {robot.file.name: robot for robot in self._twin.fleet}
        if name not in robots:
            raise UnknownName(what="real robot", name=name, where="this session", known=list(robots))
        return robots[name]

    def stop(self, cause: str) -> None:
        """Send all robots a stop at once and disarm them, armed or not."""
        if self._twin is not None:
            self._twin.fleet.emergency_stop(cause)

    def disarm(self, cause: str) -> None:
        """Stop and disarm the robots, because no page supervises them any more; cancel arming under way."""
        if self._twin is not None:
            self._twin.fleet.disarm(cause)

    def refresh_heartbeat(self, *, holding: bool) -> None:
        """Note that the person in control is there, and whether they hold the hold-to-run key."""
        self._heard_s = self._wall()
        if self._twin is not None:
            self._twin.fleet.hold_key(HELD_S if holding else 0.0)

    def idle(self) -> bool:
        """Command rest if no tick came for its length; `disarm` after SILENT_S without a sign of the person.

        Return whether there is something new to draw.
        """
        if self._twin is None:
            return False
        if self._wall() - self._heard_s > SILENT_S:
            self.disarm(f"{self._place} stopped responding")
            self._heard_s = self._wall()  # not again at once, while agents elsewhere have not answered
        return self._twin.idle()

    def close(self) -> None:
        """Stop and disconnect the robots."""
        if self._twin is not None:
            self._twin.close()
