"""Recorders of drives: the ticks of a robot that is being driven, which become a drive at any moment."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.records.record import POSE, Episode, Floats, Record
from understudy.runtime.body import Body, list_reading_keys

FIRST_ROWS = 256


class DriveRecorder:
    """A recorder of the ticks of one robot of a body.

    Parameters
    ----------
    body
        The body, whose readings and channels the drive has.
    source
        What the first episode is called.
    """

    def __init__(self, body: Body, source: str = "") -> None:
        self.keys = list_reading_keys(body)
        """The readings to pass to `add`, in this order."""
        self._channels, self._tick_s = tuple(body.channels), body.tick_s
        self._readings, self._targets = tuple(body.readings), tuple(body.targets)
        self._rows = np.empty((FIRST_ROWS, 1 + len(self.keys) + len(self._channels) + len(POSE)))
        self._starts = [(source, 0)]
        self.ticks = 0
        """The number of ticks so far."""

    def begin_episode(self, source: str) -> None:
        """Begin an episode, such as in another world; one without ticks is forgotten.

        Parameters
        ----------
        source
            What the episode is called, such as the name of its file.
        """
        if self._starts[-1][1] == self.ticks:
            self._starts.pop()
        self._starts.append((source, self.ticks))

    def add(
        self,
        time_s: float,
        readings: Sequence[float],
        commands: Sequence[float],
        pose: Sequence[float],
    ) -> None:
        """Add a tick to the present episode.

        Parameters
        ----------
        time_s
            The body's time after the tick.
        readings
            The value of each of the `keys` when the command was given; NaN where absent.
        commands
            The command of each channel.
        pose
            The x and y (m) and the heading (rad) of the robot after the tick; NaN if they are not known.
        """
        if self.ticks == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self.ticks] = (time_s, *readings, *commands, *pose)
        self.ticks += 1

    def make_drive(self) -> Record:
        """Make a drive of all ticks so far, which later ones do not change.

        Returns
        -------
        Record
            The drive; an episode without ticks is left out.
        """
        rows = self._rows[: self.ticks].copy()
        first = 1 + len(self.keys)
        ends = [start for _, start in self._starts[1:]] + [self.ticks]
        return Record(
            times=rows[:, 0],
            values={key: rows[:, 1 + index] for index, key in enumerate(self.keys)},
            commands=np.ascontiguousarray(rows[:, first : first + len(self._channels)]),
            channels=self._channels,
            readings=self._readings,
            targets=self._targets,
            tick_s=self._tick_s,
            episodes=tuple(
                Episode(source, start, end)
                for (source, start), end in zip(self._starts, ends, strict=True)
                if end > start
            ),
            pose={name: rows[:, index - len(POSE)] for index, name in enumerate(POSE)},
        )

    def list_places(self) -> Floats:
        """List the x and y (m) of the robot after each tick so far, shape [T, 2]; NaN if they are not known."""
        return self._rows[: self.ticks, -len(POSE) : -1].copy()
