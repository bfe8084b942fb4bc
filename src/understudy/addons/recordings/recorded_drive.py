"""Recorded drives: the readings of a robot and the commands that a person gave it, tick by tick.

A drive has episodes, one for each file, and for each piece between gaps of a file. Nothing is known about what
happened between two episodes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, join_names
from understudy.model.features import Percept, ReadingKey, format_reading_label
from understudy.model.value_kinds import Categorical, Column
from understudy.runtime.body import Channel, Reading

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class DriveEpisode:
    """A piece of a drive without a gap.

    Parameters
    ----------
    source
        Name of the file that it was read from.
    first
        Its first tick in the drive.
    end
        The tick after its last one.
    """

    source: str
    first: int
    end: int

    @property
    def ticks(self) -> slice:
        """The ticks of the episode, to index columns of the drive with."""
        return slice(self.first, self.end)

    def list_runs(self, values: NDArray[np.bool_ | np.int64]) -> list[tuple[int, int]]:
        """List the runs of ticks in a row with the same value of a column of the drive [T]: first tick, and end."""
        cuts = self.first + 1 + np.flatnonzero(np.diff(values[self.ticks]))
        return list(pairwise([self.first, *cuts.tolist(), self.end]))


@dataclass(frozen=True, slots=True)
class RecordedDrive:
    """A recording of a robot that a person drove, as columns of T ticks.

    Parameters
    ----------
    times
        Time of each tick in s, shape [T]; it rises within an episode.
    values
        Readings by name and target, shape [T] each; NaN where absent.
    commands
        Commands by channel, shape [T, C], in the order of `channels`.
    channels
        The command channels.
    readings
        The readings with their kinds and units.
    targets
        Names of the targets that readings are about.
    tick_s
        Nominal length of a tick, s.
    episodes
        The pieces without gaps, in order; together they have all ticks.
    omissions
        Sentences about what was left out when it was read.
    """

    times: Column
    values: Mapping[ReadingKey, Column]
    commands: Floats
    channels: tuple[Channel, ...]
    readings: tuple[Reading, ...]
    targets: tuple[str, ...]
    tick_s: float
    episodes: tuple[DriveEpisode, ...]
    omissions: tuple[str, ...] = field(default=())

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return len(self.times)

    @property
    def percept(self) -> Percept:
        """All readings as columns over ticks, for functions that take columns over agents."""
        return self.values

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

    def find_episode(self, tick: int) -> DriveEpisode:
        """Return the episode of a tick.

        Parameters
        ----------
        tick
            Number of the tick in the drive, from 0.

        Returns
        -------
        DriveEpisode
            The episode.
        """
        return next(each for each in self.episodes if each.first <= tick < each.end)


def find_places(drive: RecordedDrive) -> Floats | None:
    """Return where the robot was if the drive has readings x and y of the robot itself.

    Parameters
    ----------
    drive
        The drive.

    Returns
    -------
    array, shape [T, 2], or None
        The places in the unit of the readings. None: it has no such readings.
    """
    x, y = drive.values.get(("x", None)), drive.values.get(("y", None))
    return None if x is None or y is None else np.column_stack([x, y])


def select_ticks(
    drive: RecordedDrive, ticks: NDArray[np.intp], episodes: Sequence[DriveEpisode]
) -> RecordedDrive:
    """Return a drive of some ticks only, which form these episodes."""
    return replace(
        drive,
        times=drive.times[ticks],
        values={key: column[ticks] for key, column in drive.values.items()},
        commands=drive.commands[ticks],
        episodes=tuple(episodes),
    )


def sample_drive(drive: RecordedDrive, *, most: int, piece: int = 400) -> RecordedDrive:
    """Take pieces of a drive, spread evenly over it; a drive of at most `most` ticks stays whole.

    Parameters
    ----------
    drive
        The drive.
    most
        About how many ticks to take.
    piece
        Ticks of a piece; the last one of an episode may be shorter.

    Returns
    -------
    RecordedDrive
        A drive whose episodes are the pieces.
    """
    if drive.ticks <= most:
        return drive
    pieces = [
        DriveEpisode(each.source, first, min(first + piece, each.end))
        for each in drive.episodes
        for first in range(each.first, each.end, piece)
    ]
    count = max(1, most * len(pieces) // drive.ticks)
    taken = [pieces[index] for index in np.linspace(0, len(pieces) - 1, count).round().astype(int).tolist()]
    ticks = np.concatenate([np.arange(each.first, each.end) for each in taken])
    starts = np.cumsum([0, *(each.end - each.first for each in taken)]).tolist()
    pairs = zip(taken, pairwise(starts), strict=True)
    return select_ticks(drive, ticks, [DriveEpisode(each.source, first, end) for each, (first, end) in pairs])


def join_drives(drives: Sequence[RecordedDrive]) -> RecordedDrive:
    """Join drives of the same robot to one, whose episodes follow each other.

    Parameters
    ----------
    drives
        At least one drive. All have the same readings, targets and channels; labels may be others in each.

    Returns
    -------
    RecordedDrive
        One drive with the episodes of all.

    Raises
    ------
    DefinitionError
        If there is none, or two have different readings, channels or lengths of a tick, or a reading has numbers in
        one drive and labels in the other, or other units.
    """
    if not drives:
        raise DefinitionError(what="recordings", problem="there are none", remedy="give at least one")
    first = drives[0]
    for other in drives[1:]:
        refuse_other_robot(first, other)
        _refuse_differences(first, other, "ticks", [f"{first.tick_s:g} s"], [f"{other.tick_s:g} s"])
    starts = np.cumsum([0, *(each.ticks for each in drives)])
    drives = align_labels(drives)
    first = drives[0]
    return replace(
        first,
        times=np.concatenate([each.times for each in drives]),
        values={key: np.concatenate([each.values[key] for each in drives]) for key in first.values},
        commands=np.concatenate([each.commands for each in drives]),
        episodes=tuple(
            DriveEpisode(episode.source, episode.first + start, episode.end + start)
            for drive, start in zip(drives, starts.tolist(), strict=False)
            for episode in drive.episodes
        ),
        omissions=tuple(each for drive in drives for each in drive.omissions),
    )


def align_labels(drives: Sequence[RecordedDrive]) -> list[RecordedDrive]:
    """Return drives of the same robot with the same labels, where each of them had those that occur in it.

    Parameters
    ----------
    drives
        The drives. All have the same readings.

    Returns
    -------
    list
        The drives, in which a label has the same number.

    Raises
    ------
    DefinitionError
        If a reading has numbers in one drive and labels in another, or other units.
    """
    readings = {each.name: _join_reading(drives, each.name) for each in drives[0].readings}
    return [_convert_labels(each, readings) for each in drives]


def _join_reading(drives: Sequence[RecordedDrive], name: str) -> Reading:
    """Return a reading with the labels that it has in any drive; refuse one that is another in each."""
    readings = [next(each for each in drive.readings if each.name == name) for drive in drives]
    pairs = [
        (drive, each)
        for drive, each in zip(drives, readings, strict=True)
        if any(not np.isnan(column).all() for (other, _), column in drive.values.items() if other == name)
    ] or [(drives[0], readings[0])]
    (first, joined), *others = pairs
    for drive, other in others:
        kinds = joined.kind, other.kind
        if isinstance(kinds[0], Categorical) and isinstance(kinds[1], Categorical):
            if kinds[0] != kinds[1]:
                joined = replace(
                    joined, kind=Categorical(tuple(sorted({*kinds[0].labels, *kinds[1].labels})))
                )
        else:
            _refuse_differences(first, drive, f"values of {name}", *([str(each)] for each in kinds))
        _refuse_differences(first, drive, f"units of {name}", [joined.unit or "none"], [other.unit or "none"])
    return joined


def _convert_labels(drive: RecordedDrive, readings: Mapping[str, Reading]) -> RecordedDrive:
    """Return a drive whose labels have the numbers that they have in these readings."""
    values = dict(drive.values)
    for reading in drive.readings:
        kind, joined = reading.kind, readings[reading.name].kind
        if kind == joined or not isinstance(kind, Categorical) or not isinstance(joined, Categorical):
            continue
        numbers = np.array([joined.labels.index(label) for label in kind.labels], np.float64)
        for key in values:
            if key[0] == reading.name:
                column = values[key]
                present = ~np.isnan(column)
                values[key] = np.full(len(column), np.nan)
                values[key][present] = numbers[column[present].astype(np.int64)]
    return replace(drive, values=values, readings=tuple(readings.values()))


def refuse_other_robot(first: RecordedDrive, other: RecordedDrive) -> None:
    """Refuse a drive whose robot has other readings or channels than that of the first.

    Parameters
    ----------
    first
        The first drive.
    other
        The drive that is compared with it.

    Raises
    ------
    DefinitionError
        If they have different readings or channels.
    """
    _refuse_differences(
        first, other, "readings", *(list(map(format_reading_label, each.values)) for each in (first, other))
    )
    names = [[channel.name for channel in each.channels] for each in (first, other)]
    _refuse_differences(first, other, "channels", *names)


def _refuse_differences(
    first: RecordedDrive, other: RecordedDrive, what: str, ours: Sequence[str], theirs: Sequence[str]
) -> None:
    if list(ours) != list(theirs):
        raise DefinitionError(
            what=f"recording {other.episodes[0].source}",
            problem=f"its {what} are {join_names(theirs)}, but those of {first.episodes[0].source} are "
            f"{join_names(ours)}",
            remedy="learn from recordings of different robots one by one",
        )
