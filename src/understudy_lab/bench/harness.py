"""How speeds are measured: everything that is compared takes turns, round by round, and medians are told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from math import nan
from statistics import median
from time import perf_counter
from typing import Any, Protocol

from understudy.errors import UnderstudyError
from understudy.extras import format_install_command

Row = dict[str, Any]


class PeerMissing(UnderstudyError, json_type="PeerMissing"):
    """A peer to be measured beside is not installed."""

    def __init__(self, *, peer: str, extra: str = "bench") -> None:
        self.peer = peer
        super().__init__(
            f"the comparison needs {peer}, not installed here; install it with: {format_install_command(extra)}"
        )


class Benchmarked(Protocol):
    """What is measured: robots that can be set back to the start, and run."""

    robots: int

    def reset(self) -> None:
        """Back to the start; not measured."""
        ...

    def run(self, ticks: int) -> None:
        """Run for so many ticks."""
        ...


@dataclass(frozen=True)
class BenchCase:
    """One row to measure: `make` gives the subject, which runs `ticks` from the start in every round."""

    task: str
    make: Callable[[], Benchmarked]
    threads: int
    ticks: int


@dataclass(frozen=True)
class BenchGoal:
    """What a measurement must reach: `value` of the rows at least `least` (or at most `most`)."""

    what: str
    value: Callable[[Sequence[Row]], float]
    least: float | None = None
    most: float | None = None

    def of(self, rows: Sequence[Row]) -> Row:
        """The goal beside what was reached; where that could not be measured, `passed` is None."""
        value = self.value(rows)
        passed = (self.least or value) <= value <= (self.most or value) if value == value else None
        limits = {"least": self.least, "most": self.most}
        given = {key: limit for key, limit in limits.items() if limit is not None}
        return {"what": self.what, "value": value, **given, "passed": passed}


def measure(cases: Sequence[BenchCase], *, rounds: int) -> list[Row]:
    """A row per case, of robot-ticks per second: the median over rounds in which the cases take turns.

    A round before them does not count: it compiles, and fills caches. `spread` is the range between the quartiles
    as a share of the median; `slowest` and `fastest` are the rounds at the ends. A peer that is not installed has no
    row, and a goal that needs one is not measured.
    """
    runs = [_CaseRun(case, subject) for case in cases if (subject := _made(case)) is not None]
    for _ in range(rounds + 1):
        for run in runs:
            run.subject.reset()
            taken = seconds(run.subject, run.case.ticks)
            run.speeds.append(run.subject.robots * run.case.ticks / taken)
    return [run.row() for run in runs]


def _made(case: BenchCase) -> Benchmarked | None:
    try:
        return case.make()
    except PeerMissing:
        return None


def seconds(subject: Benchmarked, ticks: int) -> float:
    """How long so many ticks take."""
    began = perf_counter()
    subject.run(ticks)
    return perf_counter() - began


@dataclass
class _CaseRun:
    case: BenchCase
    subject: Benchmarked
    speeds: list[float] = field(default_factory=list)

    def row(self) -> Row:
        speeds = sorted(self.speeds[1:])
        middle, quarter = median(speeds), len(speeds) // 4
        return {
            "task": self.case.task,
            "robots": self.subject.robots,
            "threads": self.case.threads,
            "robot_ticks_per_s": middle,
            "spread": (speeds[-1 - quarter] - speeds[quarter]) / middle,
            "slowest": speeds[0],
            "fastest": speeds[-1],
            "ticks": self.case.ticks,
            "rounds": len(speeds),
        }


def speed(rows: Iterable[Row], task: str, robots: int, *, threads: int | None = None) -> float:
    """Robot-ticks per second of a row; without threads, of the fastest. NaN where there is no such row."""
    found = [
        float(row["robot_ticks_per_s"])
        for row in rows
        if row["task"] == task and row["robots"] == robots and threads in (None, row["threads"])
    ]
    return max(found, default=nan)


def result(rows: Sequence[Row], goals: Sequence[BenchGoal]) -> Row:
    """What a measurement tells: rows, goals, and whether all that were measured were reached."""
    told = [goal.of(rows) for goal in goals]
    return {"results": list(rows), "goals": told, "passed": all(goal["passed"] is not False for goal in told)}
