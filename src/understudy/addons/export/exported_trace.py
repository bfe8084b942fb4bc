"""The traces that exported code writes: their first line, their reading, and what their indices stand for.

The first line names the automaton, its binding and the fingerprint of its library, with %XX for the characters that
separate them. Every other line is a tick: the time, and for each level AUTOMATON.BEFORE.LEAF.AFTER, where AUTOMATON and
the states are indices, and LEAF is the index of the leaf's node, -1 if the values were never shown, or -2 if the state
has no tree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from understudy.addons.export.hierarchy import Hierarchy
from understudy.addons.export.target_files import ExportJob
from understudy.errors import FileError
from understudy.storage.atomic_write import convert_os_errors

TRACE = "# understudy exported trace 1"
"""How the first line of a trace begins."""
SEPARATORS = "%;,=\r\n"
"""Characters of names that the first line spells as %XX."""
NO_TREE = -2


def format_trace_header(job: ExportJob) -> str:
    """Format the first line of the traces of an export."""
    binding = ",".join(
        f"{_quote(parameter)}={_quote(target)}" for parameter, target in job.hierarchy.binding.items()
    )
    return ";".join((TRACE, _quote(job.hierarchy.name), binding, job.fingerprint))


def _quote(name: str) -> str:
    return "".join(f"%{ord(each):02X}" if each in SEPARATORS else each for each in name)


@dataclass(frozen=True, slots=True)
class ExportedDecision:
    """A decision of one level, by indices: the automaton, its states before and after, and the leaf of the tree.

    The leaf is -1 if the values were never shown, and -2 if the state has no tree.
    """

    automaton: int
    before: int
    leaf: int
    after: int


@dataclass(frozen=True, slots=True)
class ExportedTick:
    """The decisions of all levels in a tick, the root first, at a time in the unit of the export."""

    time: float
    decisions: tuple[ExportedDecision, ...]


@dataclass(frozen=True, slots=True)
class ExportedTrace:
    """A trace of exported code: the automaton, the targets of its parameters, the library's fingerprint, the ticks."""

    path: Path
    name: str
    binding: Mapping[str, str]
    fingerprint: str
    ticks: tuple[ExportedTick, ...]

    def make_error(self, problem: str, remedy: str) -> FileError:
        """Make an error about the trace."""
        return FileError(path=self.path, place="", problem=problem, remedy=remedy)


def read_exported_trace(path: Path | str) -> ExportedTrace:
    """Read a trace of exported code; FileError names the line that is none of a trace.

    A last line without an end is left out, since the program may have been stopped within it.
    """
    path = Path(path)
    with convert_os_errors(path, "reading the trace", remedy="name a file that exported code wrote"):
        text = path.read_bytes().decode("utf-8", errors="replace")
    header, *lines = text.split("\n")
    fields = header.strip().split(";")
    if fields[0] != TRACE or len(fields) != 4:
        problem, remedy = "it is not a trace of exported code", "name a file that exported code wrote"
        raise FileError(path=path, place="line 1", problem=problem, remedy=remedy)
    binding = {}
    for pair in filter(None, fields[2].split(",")):
        parameter, _, target = pair.partition("=")
        binding[unquote(parameter)] = unquote(target)
    ticks = []
    for number, line in enumerate(lines[:-1], start=2):
        try:
            time, *levels = line.strip().split(",")
            decisions = tuple(ExportedDecision(*map(int, level.split("."))) for level in levels)
            ticks.append(ExportedTick(float(time), decisions))
        except (TypeError, ValueError):
            problem = f"{line.strip()[:60]!r} is no tick"
            remedy = "write a time, and AUTOMATON.BEFORE.LEAF.AFTER for each level"
            raise FileError(path=path, place=f"line {number}", problem=problem, remedy=remedy) from None
    return ExportedTrace(path, unquote(fields[1]), binding, fields[3], tuple(ticks))


def check_trace(trace: ExportedTrace, hierarchy: Hierarchy, fingerprint: str) -> None:
    """Refuse a trace of another version of the library, or with indices that its hierarchy has not."""
    if trace.fingerprint != fingerprint:
        problem = f"{trace.name} has changed since it was exported"
        raise trace.make_error(problem, "export it again, or name the library as it was")
    for number, tick in enumerate(trace.ticks, start=2):
        if not all(_exists(each, hierarchy) for each in tick.decisions):
            problem, remedy = f"line {number} has an index that {trace.name} does not have", "restore it"
            raise trace.make_error(problem, remedy)


def _exists(decision: ExportedDecision, hierarchy: Hierarchy) -> bool:
    if not 0 <= decision.automaton < len(hierarchy.automata):
        return False
    states = hierarchy.automata[decision.automaton].states
    if not (0 <= decision.before < len(states) and 0 <= decision.after < len(states)):
        return False
    tree = states[decision.before].tree
    return NO_TREE <= decision.leaf < (0 if tree is None else len(tree.nodes))


def find_tick(ticks: Sequence[ExportedTick], time: float) -> ExportedTick | None:
    """Find the last tick at or before a time, in the unit of the export; None if there is none."""
    last = None
    for tick in ticks:
        if tick.time <= time:
            last = tick
    return last
