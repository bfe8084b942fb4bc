"""Traces: place, states, readings and commands of each robot in each tick, and the states of coordinators.

A trace is written during a run as JSON lines or Parquet. JSON lines have one line per agent and tick, which jq, pandas,
DuckDB and people can read. Parquet has the same columns and takes a fraction of the space.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from understudy.errors import SettingError
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Column
from understudy.records.header import ReadingInfo
from understudy.records.record import BETWEEN, COMMAND, POSE, READING
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team
from understudy.storage.atomic_write import UNFINISHED, check_file_place, convert_os_errors, sync_folder
from understudy.storage.json_text import encode_json
from understudy.storage.parquet import LINES, PARQUET, convert_to_parquet, import_duckdb

VERSION = 2
COLUMNS = {
    "time_s": "DOUBLE",
    "robot": "INTEGER",
    "x": "DOUBLE",
    "y": "DOUBLE",
    "heading": "DOUBLE",
    "doing": "VARCHAR",
}
"""The columns that every trace has, with their types in DuckDB."""
COORDINATOR = "coordinator"
"""The column of a coordinator's name, in a trace of a team with coordinators."""
DIGITS = 6
WRITING = "writing the trace"


class TraceColumns(msgspec.Struct, frozen=True, kw_only=True):
    """The further columns of a trace: readings of robots by label, units of their commands, readings of coordinators.

    The readings of coordinators are by the name of their squad.
    """

    readings: dict[str, ReadingInfo] = {}
    commands: dict[str, str] = {}
    coordinators: dict[str, dict[str, ReadingInfo]] = {}

    def list_titles(self) -> dict[str, str]:
        """List the titles of these columns, with their types in DuckDB."""
        labels = dict.fromkeys(
            [*self.readings, *(label for each in self.coordinators.values() for label in each)]
        )
        return {
            **({COORDINATOR: "VARCHAR"} if self.coordinators else {}),
            **{READING + label: "DOUBLE" for label in labels},
            **{COMMAND + channel: "DOUBLE" for channel in self.commands},
        }


@dataclass(frozen=True, slots=True)
class AgentTick:
    """What agents of one sort sensed and did in a tick.

    `paths` has the states of each, outermost first, `readings` a column [N] per label and `commands` one per channel.
    """

    paths: Sequence[Sequence[str]]
    readings: Mapping[str, Column] = field(default_factory=dict)
    commands: Mapping[str, Column] = field(default_factory=dict)


class TraceWriter:
    """A writer of a trace that `write_trace` opened, to a file without a buffer."""

    def __init__(self, file: FileIO, header: dict[str, Any], path: Path | str) -> None:
        self._file, self._path, self._encoder = file, Path(path), msgspec.json.Encoder()
        self._whole = self.ticks = 0
        self._write([header])
        self.ticks = 0

    def add(
        self,
        time_s: float,
        pose: Mapping[str, Column],
        paths: Sequence[Sequence[str]],
        *,
        readings: Mapping[str, Column] | None = None,
        commands: Mapping[str, Column] | None = None,
        coordinators: Mapping[str, AgentTick] | None = None,
        robots: Sequence[int] | None = None,
    ) -> None:
        """Record the pose of each robot after a tick, as columns [N], and the states it is in, outermost first.

        `readings` and `commands` are those of the tick, as columns [N] by label and by channel; `coordinators` has the
        same of the coordinators of each squad. They are written in full precision, and null where NaN. `robots` are the
        numbers of the robots, by default from 0.
        """
        time_s = round(time_s, DIGITS)
        places = {name: np.round(pose[name], DIGITS).tolist() for name in POSE}
        numbers = range(len(places["x"])) if robots is None else robots
        tick = AgentTick(paths, readings or {}, commands or {})
        rows = _make_rows(time_s, {"robot": numbers, **places}, tick)
        for squad, squad_tick in (coordinators or {}).items():
            names = [f"{squad} {number}" for number in range(len(squad_tick.paths))]
            rows += _make_rows(time_s, {"robot": [None] * len(names), COORDINATOR: names}, squad_tick)
        self._write(rows)

    def _write(self, rows: Sequence[Mapping[str, Any]]) -> None:
        data = memoryview(self._encoder.encode_lines(rows))
        size = len(data)
        with convert_os_errors(self._path, WRITING):
            while data:  # a disk that gets full takes a part, and refuses the rest
                data = data[self._file.write(data) :]
        self._whole += size
        self.ticks += 1

    def close(self) -> None:
        """Put the trace on disk, and cut off a tick whose writing was interrupted."""
        self._file.truncate(self._whole)
        os.fsync(self._file.fileno())


def _make_rows(time_s: float, first: Mapping[str, Sequence[Any]], tick: AgentTick) -> list[dict[str, Any]]:
    """Make the rows of some agents in a tick, which begin with these columns."""
    titles = (
        *first,
        "doing",
        *(READING + label for label in tick.readings),
        *(COMMAND + channel for channel in tick.commands),
    )
    columns = zip(
        *first.values(),
        map(BETWEEN.join, tick.paths),
        *(column.tolist() for column in (*tick.readings.values(), *tick.commands.values())),
        strict=True,
    )
    return [{"time_s": time_s, **dict(zip(titles, row, strict=True))} for row in columns]


@contextmanager
def write_trace(
    path: Path | str,
    *,
    scenario: str,
    seed: int,
    tick_s: float,
    robots: int,
    run: Mapping[str, Any] | None = None,
    columns: TraceColumns | None = None,
) -> Iterator[TraceWriter]:
    """Write a trace to a file that ends in .jsonl or .parquet; an existing file is replaced when the run has ended.

    `run` has what is needed to repeat the run, if that is known, and `columns` describes the readings and commands that
    the ticks have. However the run ends, the trace has all ticks until then; if there are none, no file is written.
    """
    path = Path(path)
    parquet = check_trace_path(path)
    header = {
        "format": "understudy trace",
        "version": VERSION,
        "scenario": scenario,
        "seed": seed,
        "tick_s": tick_s,
        "robots": robots,
        **({} if columns is None else msgspec.to_builtins(columns)),
        **({} if run is None else {"run": run}),
    }
    titles = {**COLUMNS, **({} if columns is None else columns.list_titles())}
    lines = path.with_name(f".{path.name}.{os.getpid()}{LINES}{UNFINISHED}")
    with convert_os_errors(path, WRITING):
        file = lines.open("wb", buffering=0)
    try:
        with file:
            writer = TraceWriter(file, header, path)
            try:
                yield writer
            finally:
                with convert_os_errors(path, WRITING):
                    writer.close()
                    if writer.ticks:
                        _finish(lines, path, header, titles=titles if parquet else None)
    finally:
        lines.unlink(missing_ok=True)


def check_trace_path(path: Path | str) -> bool:
    """Check that a trace can be written to a file, before a run begins; return whether it is Parquet.

    SettingError is raised if it ends neither in .jsonl nor in .parquet, or if DuckDB is missing for the latter, and
    FileError if nothing can be written there.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (LINES, PARQUET):
        remedy = f"name a file that ends in {LINES} (to read) or {PARQUET} (for tables)"
        raise SettingError(where="trace", setting=repr(str(path)), problem="is not a trace", remedy=remedy)
    if suffix == PARQUET:
        import_duckdb(path, where="trace")
    check_file_place(path, WRITING)
    return suffix == PARQUET


def _finish(lines: Path, path: Path, header: dict[str, Any], *, titles: Mapping[str, str] | None) -> None:
    """Put the complete trace in its place, as Parquet if its columns are given."""
    if titles is None:
        lines.replace(path)
    else:
        unfinished = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
        try:
            about = encode_json(header).decode()
            convert_to_parquet(lines, unfinished, titles, key="understudy", metadata=about)
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)
    sync_folder(path.parent)


def describe_trace_columns(team: Team) -> TraceColumns:
    """Describe the readings that the automata of a team's robots and coordinators use, and the robots' commands."""
    robots, *above = team.layers
    return TraceColumns(
        readings=_describe_readings(robots),
        commands={channel.name: channel.unit for channel in robots.body.channels},
        coordinators={
            layer.body.squad.name: _describe_readings(layer)
            for layer in above
            if isinstance(layer.body, SquadBody)
        },
    )


def _describe_readings(layer: AgentLayer) -> dict[str, ReadingInfo]:
    reading_of = {reading.name: reading for reading in layer.body.readings}
    return {
        format_reading_label(key): ReadingInfo(str(reading_of[key[0]].kind), reading_of[key[0]].unit)
        for key in layer.runner.keys
    }


def add_team_tick(
    trace: TraceWriter, team: Team, time_s: float, pose: Mapping[str, Column], paths: list[tuple[str, ...]]
) -> None:
    """Add the last tick of a team to its trace.

    `time_s` and `pose` are those of the world after it, and `paths` has the states of each robot, outermost first.
    """
    robots, *above = team.layers
    trace.add(
        time_s,
        pose,
        paths,
        readings=_list_readings(robots),
        commands=robots.commands,
        coordinators={
            layer.body.squad.name: AgentTick(team.list_paths(layer), _list_readings(layer))
            for layer in above
            if isinstance(layer.body, SquadBody)
        },
    )


def _list_readings(layer: AgentLayer) -> dict[str, Column]:
    return {format_reading_label(key): layer.percept[key] for key in layer.runner.keys}
