"""Headers of traces: everything needed to repeat a recorded run, and how it is written and read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import msgspec

from understudy.analysis.run_trace import PARQUET, TraceRow
from understudy.errors import FileError, SettingError
from understudy.extras import format_install_command
from understudy.robots.recording.header import RunInfo
from understudy.runtime.program import Child, Instance
from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.document import fingerprint_automaton, hash_content
from understudy.storage.json_text import convert_decode_errors

SOON_S = 1e-6
"""The largest difference of two times, in s, that count as equal; times in traces are rounded."""


class TraceHeader(msgspec.Struct, frozen=True):
    """The first line of a trace; `run` has what is needed to repeat the run, None in traces without it."""

    scenario: str
    seed: int
    tick_s: float
    robots: int
    run: RunInfo | None = None


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


def fingerprint_libraries(team: Team, libraries: Libraries) -> dict[str, dict[str, str]]:
    """Compute the fingerprints of all automata that the agents of a team may run, by sort and name."""
    found: dict[str, dict[str, str]] = {}
    for sort, programs in team.programs.items():
        taught = libraries[sort].taught
        used = {name: None for program in programs for name in _automata(program.root)}
        if used:
            found[sort] = {
                name: fingerprint_automaton(taught[name]) for name in sorted(used) if name in taught
            }
    return found


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
    with convert_os_errors(
        path, "reading the trace", remedy="name a file that `understudy run --trace` wrote"
    ):
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


def _lines(path: Path, robot: int) -> tuple[TraceHeader, list[TraceRow]]:
    decode = msgspec.json.Decoder(TraceRow).decode
    with path.open("rb") as lines:
        header = _header(next(lines, b""), path)
        try:
            whole = (
                line for line in lines if line.endswith(b"\n")
            )  # a run that was killed ends within a line
            with convert_decode_errors():
                rows = [decode(line) for line in whole if line.strip()]
        except msgspec.MsgspecError as error:
            raise _no_trace(path, f"a line of it cannot be read ({error})", "restore it") from None
    return header, [row for row in rows if row.robot == robot]


def _parquet(path: Path, robot: int) -> tuple[TraceHeader, list[TraceRow]]:
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
            found = database.execute(
                "SELECT * FROM read_parquet(?) WHERE robot = ? ORDER BY time_s", [str(path), robot]
            ).fetchall()
        except duckdb.Error as error:
            raise _no_trace(path, f"it cannot be read ({error})", "restore it") from None
    return _header(about[0] if about else b"", path), [TraceRow(*row) for row in found]


def _header(line: bytes, path: Path) -> TraceHeader:
    try:
        with convert_decode_errors():
            found: dict[str, Any] = msgspec.json.decode(line)
        if found.get("format") != "understudy trace":
            raise ValueError
        if found.get("run") and not found["run"].keys() >= set(RunInfo.__struct_fields__) - {
            "seed",
            "agent",
            "squad",
        }:
            raise ValueError
        return msgspec.convert(found, TraceHeader)
    except (ValueError, AttributeError):  # msgspec's own errors are ValueErrors, too
        raise _other_file(path) from None


def _other_file(path: Path) -> FileError:
    return _no_trace(path, "it is not a trace of a run", "name a file that `understudy run --trace` wrote")


def _no_trace(path: Path, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place="", problem=problem, remedy=remedy)
