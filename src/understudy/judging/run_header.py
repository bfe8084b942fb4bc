"""What ran, as traces and recordings have it, to repeat a run: fingerprints of worlds and automata, and a moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from understudy.errors import SettingError
from understudy.model.library import Library
from understudy.records.header import RunInfo
from understudy.records.record import BETWEEN, POSE, Record
from understudy.records.trace_reader import NO_TRACE, REMEDY, TraceHeader, read_trace_records, refuse_trace
from understudy.runtime.link import Child, Instance, Program
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
from understudy.storage.document import fingerprint_automaton, hash_content

SOON_S = 1e-6
"""The largest difference of two times, in s, that count as equal; times in traces are rounded."""


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """One robot of a recorded run, whose number and record these are, after `ticks` ticks."""

    header: TraceHeader
    ran: RunInfo
    scenario: str
    behavior: str
    robot: int
    record: Record
    ticks: int

    @property
    def time_s(self) -> float:
        """The time in the run, s."""
        return float(self.record.times[self.ticks - 1])

    @property
    def pose(self) -> list[float]:
        """Its x and y (m) and heading (rad)."""
        return [float(self.record.pose[name][self.ticks - 1]) for name in POSE]

    def format_states(self) -> str:
        """Format the states of all levels that it is in, outermost first."""
        return BETWEEN.join(self.record.states[self.ticks - 1])


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
    header, records = read_trace_records(path, robot=robot)
    ran = header.run
    if ran is None:
        problem = "it does not say how the run was produced"
        raise refuse_trace(path, problem, "run it again with `understudy run --trace`, of this version")
    if ran.scenario is None or ran.behavior is None:
        raise refuse_trace(path, NO_TRACE, REMEDY)
    if not 0 <= robot < header.robots:
        remedy = f"count from 0 to {header.robots - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {robot}", remedy=remedy)
    if not records:
        problem, remedy = f"it has no data of robot {robot}", "run it again with `understudy run --trace`"
        raise refuse_trace(path, problem, remedy)
    (record,) = records
    end_s = float(record.times[-1])
    if time_s > end_s + header.tick_s / 2:
        problem, remedy = f"is {time_s:g}, after the run had ended", f"give at most {end_s:g}"
        raise SettingError(where=str(path), setting="--time", problem=problem, remedy=remedy)
    ticks = max(1, int((record.times <= time_s + SOON_S).sum()))
    return RecordedTick(header, ran, ran.scenario, ran.behavior, robot, record, ticks)
