"""Episodes of a trace: one of each robot and coordinator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode
from understudy.judging.run_header import TraceHeader, read_trace
from understudy.judging.run_trace import BETWEEN, COMMAND, COORDINATOR, READING, ReadingInfo
from understudy.model.kinds import Column, parse_kind

PLACE = ("x", "y", "heading")


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
