"""The robots of a stage where they are real: armed by a person, at rest while time stands still, watched over."""

from __future__ import annotations

from understudy.desk.pace import Wall
from understudy.errors import SessionError
from understudy.robots.twin import Ground, Twin
from understudy.studio.scene import Plain

SILENT_S = 0.6
"""A page that directs armed robots says that it is there, several times a second; after so long it counts as gone."""
HELD_S = 0.4
"""How long a held key counts as held after the page said so."""
BY = "the studio"


class Robots:
    """What a stage does with real robots; with simulated ones nothing."""

    def __init__(self, ground: Ground, wall: Wall) -> None:
        self._twin = ground if isinstance(ground, Twin) else None
        self._wall = wall
        self._heard_s = wall()

    @property
    def armed(self) -> bool:
        """Whether any of them may move."""
        return self._twin is not None and self._twin.fleet.armed

    def plain(self) -> list[Plain]:
        """Each, whether it may move, and why it does not."""
        if self._twin is None:
            return []
        return [
            {"name": robot.file.name, "armed": robot.armed, "stopped": robot.stopped}
            for robot in self._twin.fleet
        ]

    def arm(self) -> None:
        """A person lets them move from now on; what stands against it is raised."""
        if self._twin is None:
            raise SessionError("these robots are simulated: nothing has to be armed")
        self._heard_s = self._wall()
        self._twin.fleet.arm(BY)

    def stop(self, cause: str) -> None:
        """Stop them at once; they have to be armed again."""
        if self._twin is not None:
            self._twin.fleet.emergency(cause)

    def leave(self, cause: str) -> None:
        """Nobody watches over them any more."""
        if self._twin is not None and self.armed:
            self._twin.fleet.disarm(cause)

    def hear(self, *, holding: bool) -> None:
        """The page that directs is there, and the person holds the key, or does not."""
        self._heard_s = self._wall()
        if self._twin is not None:
            self._twin.fleet.hold(HELD_S if holding else 0.0)

    def idle(self) -> bool:
        """Let them rest where nobody commands them; whether there is something new to see."""
        if self._twin is None:
            return False
        if self.armed and self._wall() - self._heard_s > SILENT_S:
            self._twin.fleet.disarm("the studio's page was silent")
        return self._twin.idle()

    def close(self) -> None:
        """Stop and leave them."""
        if self._twin is not None:
            self._twin.close()
