"""Records of the same robot joined to one, with the same labels in each; those of another robot are refused."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from understudy.errors import DefinitionError, join_names
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Categorical
from understudy.records.record import Episode, Record
from understudy.runtime.body import Reading


def join_records(records: Sequence[Record]) -> Record:
    """Join records of the same robot to one, whose episodes follow each other.

    Parameters
    ----------
    records
        At least one record. All have the same readings, targets and channels; labels may be others in each.

    Returns
    -------
    Record
        One record with the episodes of all.

    Raises
    ------
    DefinitionError
        If there is none, or two have different readings, channels or lengths of a tick, or a reading has numbers in
        one record and labels in the other, or other units.
    """
    if not records:
        raise DefinitionError(what="recordings", problem="there are none", remedy="give at least one")
    first = records[0]
    for other in records[1:]:
        refuse_other_robot(first, other)
        _refuse_differences(first, other, "ticks", [f"{first.tick_s:g} s"], [f"{other.tick_s:g} s"])
    starts = np.cumsum([0, *(each.ticks for each in records)])
    records = _tell_sources_apart(align_labels(records))
    first = records[0]
    return replace(
        first,
        times=np.concatenate([each.times for each in records]),
        values={key: np.concatenate([each.values[key] for each in records]) for key in first.values},
        commands=np.concatenate([each.commands for each in records]),
        episodes=tuple(
            Episode(episode.source, episode.first + start, episode.end + start)
            for record, start in zip(records, starts.tolist(), strict=False)
            for episode in record.episodes
        ),
        omissions=tuple(each for record in records for each in record.omissions),
        kinds_known=all(each.kinds_known for each in records),
        states=sum((each.states for each in records), ()) if all(each.states for each in records) else (),
        presses=tuple(
            replace(press, tick=press.tick + start)
            for record, start in zip(records, starts.tolist(), strict=False)
            for press in record.presses
            if press.tick < record.ticks
        ),
        pose={
            name: np.concatenate([each.pose[name] for each in records])
            for name in first.pose
            if all(name in each.pose for each in records)
        },
    )


def _tell_sources_apart(records: Sequence[Record]) -> list[Record]:
    """Return records whose sources have different names, by which, and their time, examples are known."""
    counts: Counter[str] = Counter()
    apart = []
    for record in records:
        names = {each.source for each in record.episodes}
        counts.update(names)
        numbered = {name: name if counts[name] == 1 else f"{name} ({counts[name]})" for name in names}
        episodes = tuple(replace(each, source=numbered[each.source]) for each in record.episodes)
        apart.append(replace(record, episodes=episodes))
    return apart


def align_labels(records: Sequence[Record]) -> list[Record]:
    """Return records of the same robot with the same labels, where each of them had those that occur in it.

    Parameters
    ----------
    records
        The records. All have the same readings.

    Returns
    -------
    list
        The records, in which a label has the same number.

    Raises
    ------
    DefinitionError
        If a reading has numbers in one record and labels in another, or other units.
    """
    readings = {each.name: _join_reading(records, each.name) for each in records[0].readings}
    return [_convert_labels(each, readings) for each in records]


def _join_reading(records: Sequence[Record], name: str) -> Reading:
    """Return a reading with the labels that it has in any record; refuse one that is another in each."""
    readings = [next(each for each in record.readings if each.name == name) for record in records]
    pairs = [
        (record, each)
        for record, each in zip(records, readings, strict=True)
        if any(not np.isnan(column).all() for (other, _), column in record.values.items() if other == name)
    ] or [(records[0], readings[0])]
    (first, joined), *others = pairs
    for record, other in others:
        kinds = joined.kind, other.kind
        if isinstance(kinds[0], Categorical) and isinstance(kinds[1], Categorical):
            if kinds[0] != kinds[1]:
                joined = replace(
                    joined, kind=Categorical(tuple(sorted({*kinds[0].labels, *kinds[1].labels})))
                )
        else:
            _refuse_differences(first, record, f"values of {name}", *([str(each)] for each in kinds))
        _refuse_differences(
            first, record, f"units of {name}", [joined.unit or "none"], [other.unit or "none"]
        )
    return joined


def _convert_labels(record: Record, readings: Mapping[str, Reading]) -> Record:
    """Return a record whose labels have the numbers that they have in these readings."""
    values = dict(record.values)
    for reading in record.readings:
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
    return replace(record, values=values, readings=tuple(readings.values()))


def refuse_other_robot(first: Record, other: Record) -> None:
    """Refuse a record whose robot has other readings or channels than that of the first.

    Parameters
    ----------
    first
        The first record.
    other
        The record that is compared with it.

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
    first: Record, other: Record, what: str, ours: Sequence[str], theirs: Sequence[str]
) -> None:
    if list(ours) != list(theirs):
        raise DefinitionError(
            what=f"recording {other.episodes[0].source}",
            problem=f"its {what} are {join_names(theirs)}, but those of {first.episodes[0].source} are "
            f"{join_names(ours)}",
            remedy="learn from recordings of different robots one by one",
        )
