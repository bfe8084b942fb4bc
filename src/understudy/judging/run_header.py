"""Headers of traces: everything needed to repeat a recorded run, and how it is written and read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from understudy.errors import FileError, SettingError
from understudy.extras import format_install_command
from understudy.judging.run_trace import COLUMNS, COORDINATOR, VERSION, ReadingInfo, TraceRow
from understudy.model.library import Library
from understudy.records.header import RunInfo
from understudy.runtime.link import Child, Instance, Program
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.document import fingerprint_automaton, hash_content
from understudy.storage.json_text import convert_decode_errors
from understudy.storage.parquet import PARQUET

REMEDY = "name a file that `understudy run --trace` wrote"
Row = TypeVar("Row")
SOON_S = 1e-6
"""The largest difference of two times, in s, that count as equal; times in traces are rounded."""


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


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """One robot of a recorded run at a moment: `row` is its line in the trace, after `ticks` ticks."""

    header: TraceHeader
    ran: RunInfo
    scenario: str
    behavior: str
    row: TraceRow
    ticks: int


def trace_entry(ran: RunInfo, scenario: Scenario) -> dict[str, Any]:
    """Make the `run` entry of a trace's header, without the seed, which the header has already.

    The scenario is represented by its fingerprint.
    """
    entry: dict[str, Any] = msgspec.to_builtins(
        msgspec.structs.replace(ran, world=fingerprint_scenario(scenario))
    )
    del entry["seed"]
    return entry


def fingerprint_scenario(scenario: Scenario) -> str:
    """Compute the fingerprint of a scenario."""
    return hash_content(format_scenario(scenario).encode())


def fingerprint_libraries(
    programs: Mapping[str, Sequence[Program]], libraries: Libraries
) -> dict[str, dict[str, str]]:
    """Compute the fingerprints of all automata that the agents of a team may run (`programs`), by sort and name."""
    fingerprints = {sort: fingerprint_programs(each, libraries[sort]) for sort, each in programs.items()}
    return {sort: automata for sort, automata in fingerprints.items() if automata}


def fingerprint_programs(programs: Iterable[Program], library: Library) -> dict[str, str]:
    """Compute the fingerprints of all automata that some programs may run, by name."""
    used = {name for program in programs for name in _automata(program.root)}
    taught = library.taught
    return {name: fingerprint_automaton(taught[name]) for name in sorted(used) if name in taught}


def _automata(child: Child) -> Iterator[str]:
    if isinstance(child, Instance):
        yield child.automaton.name
        for below in child.children:
            yield from _automata(below)


def read_recorded_tick(path: Path | str, *, robot: int, time_s: float) -> RecordedTick:
    """Read the last tick of a robot at or before a time (s) from a trace.

    FileError is raised if the file is no trace or lacks what is needed to repeat the run, and SettingError if it has
    no such robot or ends before that time.
    """
    path = Path(path)
    with convert_os_errors(path, "reading the trace", remedy=REMEDY):
        header, rows = _parquet(path, robot) if path.suffix.lower() == PARQUET else _lines(path, robot)
    ran = header.run
    if ran is None:
        problem = "it does not say how the run was produced"
        raise _no_trace(path, problem, "run it again with `understudy run --trace`, of this version")
    if ran.scenario is None or ran.behavior is None:
        raise _other_file(path)
    if not 0 <= robot < header.robots:
        remedy = f"count from 0 to {header.robots - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {robot}", remedy=remedy)
    if not rows:
        raise _no_trace(
            path, f"it has no data of robot {robot}", "run it again with `understudy run --trace`"
        )
    if time_s > rows[-1].time_s + header.tick_s / 2:
        problem, remedy = f"is {time_s:g}, after the run had ended", f"give at most {rows[-1].time_s:g}"
        raise SettingError(where=str(path), setting="--time", problem=problem, remedy=remedy)
    ticks = max(1, sum(row.time_s <= time_s + SOON_S for row in rows))
    return RecordedTick(header, ran, ran.scenario, ran.behavior, rows[ticks - 1], ticks)


def read_trace(path: Path | str) -> tuple[TraceHeader, list[dict[str, Any]]]:
    """Read the header of a trace, and all its rows by the titles of their columns; FileError if it is no trace.

    Rows in JSON lines lack the columns that their agents do not have; in Parquet these are None.
    """
    path = Path(path)
    with convert_os_errors(path, "reading the trace", remedy=REMEDY):
        if path.suffix.lower() != PARQUET:
            header, lines = _decode_lines(path, dict[str, Any])
            return header, lines
        about, rows, titles = _query(path, "SELECT *", "ORDER BY time_s")
        return _header(about, path), [dict(zip(titles, row, strict=True)) for row in rows]


def is_trace(path: Path | str) -> bool:
    """Return whether a file begins as a trace does; one that cannot be read does not."""
    path = Path(path)
    try:
        with path.open("rb") as lines:
            first = next(lines, b"")
        about = _query(path, "SELECT 1", "LIMIT 0")[0] if path.suffix.lower() == PARQUET else first
        _header(about, path)
    except (OSError, FileError):
        return False
    return True


def _lines(path: Path, robot: int) -> tuple[TraceHeader, list[TraceRow]]:
    header, rows = _decode_lines(path, TraceRow, leave_out=f'"{COORDINATOR}":'.encode())
    return header, [row for row in rows if row.robot == robot]


def _decode_lines(path: Path, kind: type[Row], *, leave_out: bytes = b"") -> tuple[TraceHeader, list[Row]]:
    """Decode the rows of a trace in JSON lines, but those that contain `leave_out`."""
    decode = msgspec.json.Decoder(kind).decode
    with path.open("rb") as lines:
        header = _header(next(lines, b""), path)
        try:
            whole = (
                line for line in lines if line.endswith(b"\n")
            )  # a run that was killed ends within a line
            with convert_decode_errors():
                rows = [
                    decode(line) for line in whole if line.strip() and not (leave_out and leave_out in line)
                ]
        except msgspec.MsgspecError as error:
            raise _no_trace(path, f"a line of it cannot be read ({error})", "restore it") from None
    return header, rows


def _parquet(path: Path, robot: int) -> tuple[TraceHeader, list[TraceRow]]:
    select = f"SELECT {', '.join(COLUMNS)}"
    about, rows, _ = _query(path, select, "WHERE robot = ? ORDER BY time_s", robot)
    return _header(about, path), [TraceRow(*row) for row in rows]


def _query(
    path: Path, select: str, where: str, *values: object
) -> tuple[bytes, list[tuple[Any, ...]], list[str]]:
    """Query a trace in Parquet; return its header, the rows, and the titles of their columns."""
    try:
        duckdb = import_module("duckdb")
    except ImportError:
        problem = "it is Parquet, which needs DuckDB"
        raise _no_trace(path, problem, format_install_command("parquet")) from None
    with duckdb.connect() as database, path.open("rb"):
        try:
            about = database.execute(
                "SELECT value FROM parquet_kv_metadata(?) WHERE decode(key) = 'understudy'", [str(path)]
            ).fetchone()
            result = database.execute(f"{select} FROM read_parquet(?) {where}", [str(path), *values])
            titles = [column[0] for column in result.description]
            return (about[0] if about else b""), result.fetchall(), titles
        except duckdb.Error as error:
            raise _no_trace(path, f"it cannot be read ({error})", "restore it") from None


def _header(line: bytes, path: Path) -> TraceHeader:
    try:
        with convert_decode_errors():
            header: dict[str, Any] = msgspec.json.decode(line)
        if header.get("format") != "understudy trace":
            raise ValueError
        if header.get("version", 1) not in range(1, VERSION + 1):
            remedy = "read it with the version of Understudy that wrote it"
            raise _no_trace(path, f"its version is {header['version']!r:.20}", remedy)
        if header.get("run") and not header["run"].keys() >= set(RunInfo.__struct_fields__) - {
            "seed",
            "agent",
            "squad",
        }:
            raise ValueError
        return msgspec.convert(header, TraceHeader)
    except (ValueError, AttributeError):  # msgspec's own errors are ValueErrors, too
        raise _other_file(path) from None


def _other_file(path: Path) -> FileError:
    return _no_trace(path, "it is not a trace of a run", REMEDY)


def _no_trace(path: Path, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place="", problem=problem, remedy=remedy)
