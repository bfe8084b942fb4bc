"""Episodes of recordings and traces: one of each run and agent, coordinators of teams included."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode, EpisodePress
from understudy.judging.run_header import TraceHeader, read_trace
from understudy.judging.run_trace import BETWEEN, COMMAND, COORDINATOR, READING, ReadingInfo
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Column, Kind, parse_kind
from understudy.records.reader import (
    PRESS,
    TEACH,
    TEST,
    TRAIN,
    RecordedPress,
    Recording,
    read_recording,
)
from understudy.records.team_reader import read_team_recording

PLACE = ("x", "y", "heading")


def read_recording_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a recording.

    Recordings have all readings of the body, the states of all levels and, but for those of early versions, the
    commands. They do not say which kind of example a press recorded.
    """
    path = Path(path)
    if not path.is_file():
        remedy = "name a file that `understudy run --record FILE.mcap` wrote"
        raise FileError(path=path, place="", problem="there is no such file", remedy=remedy)
    team = read_team_recording(path)
    if team is not None:
        return [episode for part in team.parts for episode in _list_episodes(team.read_part(part), part)]
    last = read_recording(path)
    runs = [read_recording(path, run=number) for number in range(1, last.runs)]
    return [episode for recording in (*runs, last) for episode in _list_episodes(recording, "")]


def _list_episodes(recording: Recording, part: str) -> Iterator[Episode]:
    head = recording.head
    kinds, units = _find_kinds(recording), {each.name: each.unit for each in head.readings}
    for number, name in enumerate(head.names):
        yield Episode(
            agent=part or name.strip("/") or f"robot {number}",
            tick_s=head.tick_s,
            times=recording.times,
            states=tuple(recording.paths[number]),
            readings={
                format_reading_label(key): recording.values[:, row, number]
                for row, key in enumerate(recording.keys)
            },
            kinds=kinds,
            units={format_reading_label(key): units[key[0]] for key in recording.keys},
            commands={name: column[:, number] for name, column in recording.commands.items()},
            channel_units={each.name: each.unit for each in head.channels if each.name in recording.commands},
            presses=tuple(_list_presses(recording.presses[number], recording.ticks)),
            source=str(recording.path),
            seed=head.ran.seed if head.ran.scenario is not None else None,
            behavior=head.ran.behavior or "",
        )


def _find_kinds(recording: Recording) -> dict[str, Kind]:
    kind_of = {reading.name: reading.kind for reading in recording.head.readings}
    return {format_reading_label(key): kind_of[key[0]] for key in recording.keys}


def _list_presses(steps: Sequence[RecordedPress], ticks: int) -> list[EpisodePress]:
    """List the presses among the steps of a session; of several before one tick the last counts.

    Those while the automaton is tested are corrections.
    """
    is_tested, presses = False, dict[int, EpisodePress]()
    for step in steps:
        if step.does in (TEST, TRAIN, TEACH):
            is_tested = step.does == TEST
        elif step.does == PRESS and step.tick < ticks:
            presses[step.tick] = EpisodePress(step.tick, step.state, is_tested)
            is_tested = False  # a press ends testing
    return list(presses.values())


def read_trace_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a trace in JSON lines or Parquet; those of version 1 have no readings."""
    header, rows = read_trace(path)
    if not rows:
        remedy = "name a trace of a run that had ended or was interrupted"
        raise FileError(path=path, place="", problem="the trace has no tick", remedy=remedy)
    of_agents: dict[str, list[Mapping[str, Any]]] = {}
    try:
        for row in rows:
            of_agents.setdefault(row.get(COORDINATOR) or f"robot {row['robot']}", []).append(row)
        return [_make_episode(path, header, agent, rows) for agent, rows in of_agents.items()]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"a line of it is not as traces have them ({type(error).__name__}: {error})"
        raise FileError(path=path, place="", problem=problem, remedy="restore it") from None


def _make_episode(
    path: Path | str, header: TraceHeader, agent: str, rows: Sequence[Mapping[str, Any]]
) -> Episode:
    squad = agent.rpartition(" ")[0] if rows[0].get(COORDINATOR) else None
    readings = header.readings if squad is None else header.coordinators[squad]
    return Episode(
        agent=agent,
        tick_s=header.tick_s,
        times=_make_column(rows, "time_s"),
        states=tuple(_split_states(row["doing"]) for row in rows),
        readings={label: _make_column(rows, READING + label) for label in readings},
        kinds=_parse_kinds(readings),
        units={label: each.unit for label, each in readings.items()},
        channel_units=dict(header.commands) if squad is None else {},
        commands={channel: _make_column(rows, COMMAND + channel) for channel in header.commands}
        if squad is None
        else {},
        pose={name: _make_column(rows, name) for name in PLACE} if squad is None else {},
        source=str(path),
        seed=header.seed,
        behavior="" if header.run is None else header.run.behavior or "",
    )


def _make_column(rows: Sequence[Mapping[str, Any]], title: str) -> Column:
    return np.array([nan if row[title] is None else row[title] for row in rows], np.float64)


def _split_states(doing: str) -> tuple[str, ...]:
    return tuple(doing.split(BETWEEN)) if doing else ()


def _parse_kinds(readings: Mapping[str, ReadingInfo]) -> dict[str, Any]:
    return {label: parse_kind(each.kind, where=label) for label, each in readings.items()}
