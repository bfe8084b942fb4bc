"""Reader of traces: their header, and the record of each robot and coordinator."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import nan
from operator import itemgetter
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from understudy.errors import FileError
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Categorical, Column, parse_kind
from understudy.records.header import ReadingInfo, RunInfo
from understudy.records.record import BETWEEN, COMMAND, POSE, READING, Episode, Record, describe_labels
from understudy.records.trace_writer import COORDINATOR, VERSION
from understudy.runtime.body import Channel
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.json_text import convert_decode_errors
from understudy.storage.parquet import PARQUET, read_parquet_rows

REMEDY = "name a file that `understudy run --trace` wrote"
NO_TRACE = "it is not a trace of a run"


class TraceHeader(msgspec.Struct, frozen=True):
    """The first line of a trace; `run` has what is needed to repeat the run, None in traces without it.

    The others are those of `TraceColumns`, which traces of version 1 lack.
    """

    scenario: str
    seed: int
    tick_s: float
    robots: int
    run: RunInfo | None = None
    readings: dict[str, ReadingInfo] = {}
    commands: dict[str, str] = {}
    coordinators: dict[str, dict[str, ReadingInfo]] = {}


def read_trace_records(path: Path | str, *, robot: int | None = None) -> tuple[TraceHeader, list[Record]]:
    """Read the header of a trace in JSON lines or Parquet, and a record of each robot and coordinator.

    `robot` is the number of the only robot to read. Traces of version 1 have no readings and commands, which the
    records then lack, and a trace of a run that was killed ends with its last whole line. FileError is raised if the
    file is no trace.
    """
    path = Path(path)
    with convert_os_errors(path, "reading the trace", remedy=REMEDY):
        header, rows = _read_parquet(path) if path.suffix.lower() == PARQUET else _read_lines(path)
        cut = path.suffix.lower() != PARQUET and _ends_within_line(path)
    of_agents: dict[str, list[Mapping[str, Any]]] = {}
    try:
        for row in rows:
            if robot is None or row["robot"] == robot:
                of_agents.setdefault(row.get(COORDINATOR) or f"robot {row['robot']}", []).append(row)
        records = [_make_record(path, header, agent, rows) for agent, rows in of_agents.items()]
        omissions = (
            (f"{path}: its last line has no end, as of a run that was killed; left out",) if cut else ()
        )
        return header, [replace(each, omissions=omissions) for each in records]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"a line of it is not as traces have them ({type(error).__name__}: {error})"
        raise refuse_trace(path, problem, "restore it") from None


def is_trace(path: Path | str) -> bool:
    """Return whether a file begins as a trace does; one that cannot be read does not."""
    path = Path(path)
    try:
        with path.open("rb") as lines:
            first = next(lines, b"")
        about = read_parquet_rows(path, limit=0)[2] if path.suffix.lower() == PARQUET else first
        _decode_header(about, path)
    except (OSError, FileError):
        return False
    return True


def refuse_trace(path: Path | str, problem: str, remedy: str) -> FileError:
    """Make the error that a file is no trace, or one that lacks something."""
    return FileError(path=path, place="", problem=problem, remedy=remedy)


def _read_lines(path: Path) -> tuple[TraceHeader, list[dict[str, Any]]]:
    decode = msgspec.json.Decoder(dict[str, Any]).decode
    with path.open("rb") as lines:
        header = _decode_header(next(lines, b""), path)
        whole = (line for line in lines if line.endswith(b"\n"))  # a run that was killed ends within a line
        try:
            with convert_decode_errors():
                return header, [decode(line) for line in whole if line.strip()]
        except msgspec.MsgspecError as error:
            raise refuse_trace(path, f"a line of it cannot be read ({error})", "restore it") from None


def _ends_within_line(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read() != b"\n"


def _read_parquet(path: Path) -> tuple[TraceHeader, list[dict[str, Any]]]:
    rows, titles, about = read_parquet_rows(path)
    header = _decode_header(about, path)
    named = (dict(zip(titles, row, strict=True)) for row in rows)
    return header, sorted(named, key=itemgetter("time_s"))


def _decode_header(line: bytes, path: Path) -> TraceHeader:
    try:
        with convert_decode_errors():
            header: dict[str, Any] = msgspec.json.decode(line)
        if header.get("format") != "understudy trace":
            raise ValueError
        if header.get("version", 1) not in range(1, VERSION + 1):
            remedy = "read it with the version of Understudy that wrote it"
            raise refuse_trace(path, f"its version is {header['version']!r:.20}", remedy)
        if header.get("run") and not header["run"].keys() >= set(RunInfo.__struct_fields__) - {
            "seed",
            "agent",
            "squad",
        }:
            raise ValueError
        return msgspec.convert(header, TraceHeader)
    except (ValueError, AttributeError):  # msgspec's own errors are ValueErrors, too
        raise refuse_trace(path, NO_TRACE, REMEDY) from None


def _make_record(path: Path, header: TraceHeader, agent: str, rows: Sequence[Mapping[str, Any]]) -> Record:
    squad = agent.rpartition(" ")[0] if rows[0].get(COORDINATOR) else None
    described = header.readings if squad is None else header.coordinators[squad]
    channels = header.commands if squad is None else {}
    kinds = [parse_kind(each.kind, where=label) for label, each in described.items()]
    keys, sensed, targets = describe_labels([*described], kinds, [each.unit for each in described.values()])
    commands = [_make_column(rows, COMMAND + channel) for channel in channels]
    values = {key: _make_column(rows, READING + label) for label, key in zip(described, keys, strict=True)}
    for (key, column), kind in zip(values.items(), kinds, strict=True):
        numbers = column[np.isfinite(column)]
        if isinstance(kind, Categorical) and not np.isin(numbers, np.arange(len(kind.labels))).all():
            raise ValueError(f"{format_reading_label(key)} has a number that is none of its labels")
    return Record(
        times=_make_column(rows, "time_s"),
        values=values,
        commands=np.column_stack(commands) if commands else np.zeros((len(rows), 0)),
        channels=tuple(Channel(name, unit=unit) for name, unit in channels.items()),
        readings=sensed,
        targets=targets,
        tick_s=header.tick_s,
        episodes=(Episode(path.name, 0, len(rows)),),
        states=tuple(_split_states(row["doing"]) for row in rows),
        pose={name: _make_column(rows, name) for name in POSE} if squad is None else {},
        agent=agent,
        source=str(path),
        seed=header.seed,
        behavior="" if header.run is None else header.run.behavior or "",
    )


def _make_column(rows: Sequence[Mapping[str, Any]], title: str) -> Column:
    return np.array([nan if row[title] is None else row[title] for row in rows], np.float64)


def _split_states(doing: str) -> tuple[str, ...]:
    return tuple(doing.split(BETWEEN)) if doing else ()
