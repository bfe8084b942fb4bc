"""The robots at a desk where they are real: armed by a person, at rest while time stands still, watched over."""

from __future__ import annotations

from msgspec import Struct

from understudy.errors import SessionError
from understudy.robots.twin import DigitalTwin, Ground
from understudy.ui.controller.clock import WallClock

SILENT_S = 0.6
"""Who directs armed robots says that they are there, several times a second; after so long they count as gone."""
HELD_S = 0.4
"""How long a held key counts as held after that was said."""


class RobotStatus(Struct, frozen=True, kw_only=True):
    """A real robot: whether it may move, and why it does not."""

    name: str
    armed: bool
    stopped: str


class RobotArming:
    """What a person does with real robots from a place such as "the studio"; with simulated ones nothing."""

    def __init__(self, ground: Ground, wall: WallClock, *, place: str) -> None:
        self._place = place
        self._twin = ground if isinstance(ground, DigitalTwin) else None
        self._wall = wall
        self._heard_s = wall()

    @property
    def has_robots(self) -> bool:
        """Whether there are any."""
        return self._twin is not None

    @property
    def armed(self) -> bool:
        """Whether any of them may move."""
        return self._twin is not None and self._twin.fleet.armed

    def statuses(self) -> list[RobotStatus]:
        """Each, whether it may move, and why it does not."""
        if self._twin is None:
            return []
        return [
            RobotStatus(name=robot.file.name, armed=robot.armed, stopped=robot.stop_cause)
            for robot in self._twin.fleet
        ]

    def arm(self) -> None:
        """A person lets them move from now on; what stands against it is raised."""
        if self._twin is None:
            raise SessionError("these robots are simulated: nothing has to be armed")
        self._twin.fleet.arm(self._place)
        self._heard_s = self._wall()  # what was said meanwhile, which may take seconds, was not heard yet

    def stop(self, cause: str) -> None:
        """Stop them at once; they have to be armed again."""
        if self._twin is not None:
            self._twin.fleet.emergency_stop(cause)

    def stop_supervising(self, cause: str) -> None:
        """Nobody watches over them any more."""
        if self._twin is not None and self.armed:
            self._twin.fleet.disarm(cause)

    def refresh_heartbeat(self, *, holding: bool) -> None:
        """Who directs is there, and holds the key, or does not."""
        self._heard_s = self._wall()
        if self._twin is not None:
            self._twin.fleet.hold(HELD_S if holding else 0.0)

    def idle(self) -> bool:
        """Let them rest where nobody commands them; whether there is something new to see."""
        if self._twin is None:
            return False
        if self.armed and self._wall() - self._heard_s > SILENT_S:
            self._twin.fleet.disarm(f"{self._place} was silent")
        return self._twin.idle()

    def close(self) -> None:
        """Stop and leave them."""
        if self._twin is not None:
            self._twin.close()
