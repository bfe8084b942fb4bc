"""The base class of bodies on top of simulated worlds, whose robots move or sense in another way."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.model.library import Kit
from understudy.model.value_kinds import Column
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.sim.state import decode_snapshot, encode_snapshot
from understudy.sim.view import WorldView
from understudy.sim.world import World

HEAD = 8
"""The number of bytes that give the length of the body's own part of a snapshot."""


class WorldWrapper(BodyWrapper[World], ABC):
    """A body of the robots of worlds of a scenario, whose snapshots are those of the worlds behind a part of its own.

    Parameters
    ----------
    world
        The worlds below.
    """

    snapshot_name: ClassVar[str]
    """The name of the body's own part of a snapshot."""

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.world, self.scenario = world, world.scenario
        self.worlds, self.robots = world.worlds, world.robots

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that automata for this scenario can use."""
        return self.world.kit

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the worlds, in order."""
        return self.world.seeds

    @property
    def finished_s(self) -> Column:
        """The time at which each world first reached the scenario's goal [B], s; NaN if it has not."""
        return self.world.finished_s

    def view(self, world: int = 0) -> WorldView:
        """Copy one world's current state into a plain value, for drawing.

        Parameters
        ----------
        world
            The index of the world, from 0.

        Returns
        -------
        WorldView
            Places and properties of robots, objects and obstacles, in m and rad.
        """
        return self.world.view(world)

    @abstractmethod
    def _settings(self) -> Mapping[str, Any]:
        """Return the settings that a body must have for a snapshot to fit it."""

    @abstractmethod
    def _arrays(self) -> Mapping[str, NDArray[Any]]:
        """Return the body's own state."""

    def snapshot(self) -> bytes:
        """Save the complete state of all worlds, and of this body.

        Returns
        -------
        bytes
            Data for `restore`, of this body or one of the same scenario and number of worlds.
        """
        own = encode_snapshot(self.snapshot_name, self._settings(), self._arrays())
        return len(own).to_bytes(HEAD, "little") + own + self.world.snapshot()

    def _restore_worlds(self, snapshot: bytes) -> dict[str, NDArray[Any]]:
        """Restore the worlds, and return the body's own state; FileError if the snapshot is of another body."""
        end = HEAD + int.from_bytes(snapshot[:HEAD], "little")
        if not HEAD < end < len(snapshot):
            problem = f"is not one of a body called {self.snapshot_name}"
            raise FileError(path="snapshot", place="", problem=problem, remedy="take it again")
        own = decode_snapshot(snapshot[HEAD:end], self.snapshot_name, self._settings(), self._arrays())
        self.world.restore(snapshot[end:])
        return own
