"""The base class of bodies that wrap another body and change some of its behavior."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, TypeVar

from understudy.model.features import Percept, ReadingKey
from understudy.runtime.body import Body, Channel, Commands, Reading

GroundT = TypeVar("GroundT", bound=Body)


class BodyWrapper(Generic[GroundT]):
    """A body that stands on another one, its ground, and passes on what every body has; subclasses write what differs.

    What only some bodies have is not passed on, such as `reset`, `snapshot` and `index_skill`: a body that has such a
    method is asked to do it, so a subclass has it only if it can do it.

    Parameters
    ----------
    ground
        The body below.
    """

    def __init__(self, ground: GroundT) -> None:
        self._stand_on(ground)

    def _stand_on(self, ground: GroundT) -> None:
        """Wrap another body from now on, instead of the present one."""
        self.ground = ground
        self.agents = ground.agents
        self.readings: Sequence[Reading] = ground.readings
        self.targets: Sequence[str] = ground.targets
        self.channels: Sequence[Channel] = ground.channels
        self.tick_s = ground.tick_s

    @property
    def time_s(self) -> float:
        """The clock of the body below, s."""
        return self.ground.time_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Take one snapshot of readings of the body below.

        Parameters
        ----------
        keys
            Pairs (reading, target); the target is None for a reading of the robot itself.

        Returns
        -------
        Percept
            A column [N] for each key; NaN where the reading is absent.
        """
        return self.ground.sense(keys)

    def act(self, commands: Commands) -> None:
        """Let the body below act for one tick.

        Parameters
        ----------
        commands
            A column [N] for each channel. A channel that is left out rests.
        """
        self.ground.act(commands)
