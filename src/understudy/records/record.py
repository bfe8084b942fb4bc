"""Records: what an agent sensed, decided and did in a run, tick by tick, as columns.

A record has episodes: one for each piece without a gap. Nothing is known about what happened between two episodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import Percept, ReadingKey, format_reading_label, parse_reading_label
from understudy.model.lesson import ExampleKind
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.body import Channel, Reading

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
PRESS, TEST, TRAIN, TEACH, RESTART, GO_ON = "press", "test", "train", "teach", "restart", "resume"
"""The steps of a session that a record can have."""
POSE = ("x", "y", "heading")
"""The columns of the place of a robot: m, m and rad."""
READING, COMMAND = "reading.", "command."
"""The beginnings of the titles of columns with readings and commands, in traces and tables."""
BETWEEN = " > "
"""The text between the states of all levels, outermost first."""


@dataclass(frozen=True, slots=True)
class RecordedPress:
    """A press of the demonstrator, or another step of a session, before the decision of a tick.

    Attributes
    ----------
    tick
        The tick at which it took effect, counted from 0.
    state
        The state that it directed to; None for a confirmation of the current state.
    correction
        Whether it corrected a decision of the learned automaton.
    kind
        The kind of example that it recorded; None if it recorded none, or the file does not say.
    does
        The step: "press", or "test", "train", "teach", "restart" or "resume".
    at_s
        The body's time at the press, s; None if unknown.
    """

    tick: int
    state: str | None
    correction: bool = False
    kind: ExampleKind | None = None
    does: str = PRESS
    at_s: float | None = None


@dataclass(frozen=True, slots=True)
class Episode:
    """A piece of a record without a gap.

    Parameters
    ----------
    source
        Name of the file that it was read from.
    first
        Its first tick in the record.
    end
        The tick after its last one.
    """

    source: str
    first: int
    end: int

    @property
    def ticks(self) -> slice:
        """The ticks of the episode, to index columns of the record with."""
        return slice(self.first, self.end)

    def list_runs(self, values: NDArray[np.bool_ | np.int64]) -> list[tuple[int, int]]:
        """List the runs of ticks in a row in which a column of the record has the same value.

        Parameters
        ----------
        values
            The column, shape [T].

        Returns
        -------
        list
            The first tick of each run, and the tick after its last one.
        """
        cuts = self.first + 1 + np.flatnonzero(np.diff(values[self.ticks]))
        return list(pairwise([self.first, *cuts.tolist(), self.end]))


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """What one agent sensed, decided and did in a run, as columns of T ticks. A run of a team has one of each agent.

    Parameters
    ----------
    times
        Time of each tick in s, shape [T]; it rises within an episode. In recordings it is the body's time at which the
        tick sensed, in journals the demonstrator's, and in traces the simulated time after the tick.
    values
        Readings that the decisions of each tick were made on, by name and target, in their units. Each has shape [T],
        NaN where it was absent. Empty if they were not recorded.
    commands
        Commands of each tick, shape [T, C], in the order and the units of `channels`; NaN where there was none.
    channels
        The command channels that were recorded; empty if commands were not.
    readings
        The readings with their kinds and units.
    targets
        Names of the targets that readings are about.
    tick_s
        Nominal length of a tick, s.
    episodes
        The pieces without gaps, in order; together they have all ticks.
    omissions
        Sentences about what the file does not hold, and what was left out when it was read.
    states
        States of all levels after each tick, outermost first; T tuples of any length, empty if they were not recorded.
    presses
        Presses of the demonstrator, and other steps of a session, in order of time.
    pose
        Place of the robot after each tick, as "x" and "y", m, and "heading", rad, shape [T] each; empty if it was not
        recorded.
    agent
        Name of the agent: "robot 0", a robot's name, or a coordinator's name.
    source
        The file or folder that it was read from, or the name of the world.
    seed
        Seed of the simulated world; None if unknown.
    behavior
        Name of the automaton that ran or was taught; empty if unknown.
    kinds_known
        Whether the kinds and units of readings are those of the robot. False: the file does not say them, numbers were
        taken as distances, and what is written of the record does not say them either.
    """

    times: Column
    values: Mapping[ReadingKey, Column]
    commands: Floats
    channels: tuple[Channel, ...]
    readings: tuple[Reading, ...]
    targets: tuple[str, ...]
    tick_s: float
    episodes: tuple[Episode, ...]
    omissions: tuple[str, ...] = ()
    states: tuple[tuple[str, ...], ...] = ()
    presses: tuple[RecordedPress, ...] = ()
    pose: Mapping[str, Column] = field(default_factory=dict)
    agent: str = "robot 0"
    source: str = ""
    seed: int | None = None
    behavior: str = ""
    kinds_known: bool = True

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return len(self.times)

    @property
    def percept(self) -> Percept:
        """All readings as columns over ticks, for functions that take columns over agents."""
        return self.values

    @property
    def columns(self) -> dict[str, Column]:
        """The readings [T] by label, such as "distance(station)"."""
        return {format_reading_label(key): column for key, column in self.values.items()}

    def find_kind(self, key: ReadingKey) -> Kind:
        """Return the kind of a reading.

        Parameters
        ----------
        key
            Its name and target.

        Returns
        -------
        Kind
            The kind.
        """
        return self._find_reading(key).kind

    def find_unit(self, key: ReadingKey) -> str:
        """Return the unit of a reading.

        Parameters
        ----------
        key
            Its name and target.

        Returns
        -------
        str
            The unit, such as "m"; empty if it has none, or it is not known.
        """
        return self._find_reading(key).unit

    def _find_reading(self, key: ReadingKey) -> Reading:
        return next(each for each in self.readings if each.name == key[0])

    def find_commands(self, channel: str) -> Column | None:
        """Return the commands of a channel.

        Parameters
        ----------
        channel
            Its name.

        Returns
        -------
        array, shape [T], or None
            The commands in the unit of the channel. None: they were not recorded.
        """
        names = [each.name for each in self.channels]
        return self.commands[:, names.index(channel)] if channel in names else None

    def list_presses(self) -> list[RecordedPress]:
        """List the presses that took effect, without other steps of a session.

        Returns
        -------
        list of RecordedPress
            The presses in order of time; of several before one tick, the last.
        """
        last = {each.tick: each for each in self.presses if each.does == PRESS and each.tick < self.ticks}
        return list(last.values())

    def list_last_commands(self) -> Floats:
        """Return the command of the tick before each tick.

        Returns
        -------
        array, shape [T, C]
            The commands; at rest before an episode.
        """
        last = np.roll(self.commands, 1, axis=0)
        last[[each.first for each in self.episodes]] = [channel.rest for channel in self.channels]
        return last

    def find_episode(self, tick: int) -> Episode:
        """Return the episode of a tick.

        Parameters
        ----------
        tick
            Number of the tick in the record, from 0.

        Returns
        -------
        Episode
            The episode.
        """
        return next(each for each in self.episodes if each.first <= tick < each.end)


class LabelledReadings(NamedTuple):
    """Readings that a file names by labels: the key of each, the readings by name, and the targets."""

    keys: tuple[ReadingKey, ...]
    readings: tuple[Reading, ...]
    targets: tuple[str, ...]


def describe_labels(labels: Sequence[str], kinds: Sequence[Kind], units: Sequence[str]) -> LabelledReadings:
    """Describe the readings of columns with these labels, such as "range(ball)", kinds and units."""
    keys = tuple(map(parse_reading_label, labels))
    twice = [label for number, label in enumerate(labels) if label in labels[:number]]
    if twice:
        raise ValueError(f"two columns are called {twice[0]!r}")
    readings = {
        name: Reading(name, kind, unit, target is not None)
        for (name, target), kind, unit in zip(keys, kinds, units, strict=True)
    }
    targets = dict.fromkeys(target for _, target in keys if target is not None)
    return LabelledReadings(keys, tuple(readings.values()), tuple(targets))


def find_places(record: Record) -> Floats | None:
    """Return where the robot was at each tick, if the record has its place, or readings x and y of the robot itself.

    Parameters
    ----------
    record
        The record.

    Returns
    -------
    array, shape [T, 2], or None
        The places, in m or in the unit of the readings. None: it has neither.
    """
    if record.pose and not np.isnan(record.pose["x"]).all():
        return np.column_stack([record.pose["x"], record.pose["y"]])
    x, y = record.values.get(("x", None)), record.values.get(("y", None))
    return None if x is None or y is None else np.column_stack([x, y])


def select_ticks(record: Record, ticks: NDArray[np.intp], episodes: Sequence[Episode]) -> Record:
    """Return a record of some ticks only, in their order, which form these episodes."""
    place = {tick: number for number, tick in enumerate(ticks.tolist())}
    return replace(
        record,
        times=record.times[ticks],
        values={key: column[ticks] for key, column in record.values.items()},
        commands=record.commands[ticks],
        episodes=tuple(episodes),
        states=tuple(record.states[tick] for tick in place) if record.states else (),
        presses=tuple(replace(each, tick=place[each.tick]) for each in record.presses if each.tick in place),
        pose={name: column[ticks] for name, column in record.pose.items()},
    )


def select_episode(record: Record, episode: Episode) -> Record:
    """Return a record of one episode only, or of a part of one, whose ticks count from 0."""
    ticks = np.arange(episode.first, episode.end)
    return select_ticks(record, ticks, [replace(episode, first=0, end=len(ticks))])


def split_episodes(records: Iterable[Record]) -> list[Record]:
    """Return a record of each episode of records, in order; one of a single episode stays as it is."""
    return [
        part
        for record in records
        for part in (
            [record]
            if len(record.episodes) == 1
            else (select_episode(record, each) for each in record.episodes)
        )
    ]


def fill_readings(record: Record) -> Record:
    """Return a record that has a column of each reading of each target; those that it lacked are absent throughout."""
    absent = np.full(record.ticks, np.nan)
    keys = [
        (each.name, target)
        for each in record.readings
        for target in (record.targets if each.of_targets else (None,))
    ]
    return replace(record, values={key: record.values.get(key, absent) for key in keys})


def sample_record(record: Record, *, most: int, piece: int = 400) -> Record:
    """Take pieces of a record, spread evenly over it; one of at most `most` ticks stays whole.

    Parameters
    ----------
    record
        The record.
    most
        About how many ticks to take.
    piece
        Ticks of a piece; the last one of an episode may be shorter.

    Returns
    -------
    Record
        A record whose episodes are the pieces.
    """
    if record.ticks <= most:
        return record
    pieces = [
        Episode(each.source, first, min(first + piece, each.end))
        for each in record.episodes
        for first in range(each.first, each.end, piece)
    ]
    count = max(1, most * len(pieces) // record.ticks)
    taken = [pieces[index] for index in np.linspace(0, len(pieces) - 1, count).round().astype(int).tolist()]
    ticks = np.concatenate([np.arange(each.first, each.end) for each in taken])
    starts = np.cumsum([0, *(each.end - each.first for each in taken)]).tolist()
    pairs = zip(taken, pairwise(starts), strict=True)
    return select_ticks(record, ticks, [Episode(each.source, first, end) for each, (first, end) in pairs])
