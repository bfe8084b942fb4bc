"""Speed measurement: all compared subjects, ours among them, take turns round by round, and medians are reported."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from math import nan
from statistics import median
from time import perf_counter
from typing import Any, Protocol

from understudy.errors import UnderstudyError
from understudy.extras import format_install_command
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_team
from understudy.sim.world import World

Row = dict[str, Any]


class PeerMissing(UnderstudyError, json_type="PeerMissing"):
    """The error that a compared program is not installed."""

    def __init__(self, *, peer: str, extra: str = "bench") -> None:
        self.peer = peer
        super().__init__(
            f"the comparison needs {peer}, not installed here; install it with: {format_install_command(extra)}"
        )


def import_peer(module: str, peer: str) -> Any:
    """Import the module of a compared program without which nothing is measured."""
    try:
        return import_module(module)
    except ImportError:
        install = format_install_command("bench")
        problem = f"the comparison needs {peer}, which is not installed; install it with: {install}"
        raise UnderstudyError(problem) from None


class Benchmarked(Protocol):
    """A subject of a measurement: robots that can be reset to the start, and run."""

    robots: int

    def reset(self) -> None:
        """Restore the start; this is not timed."""
        ...

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        ...


@dataclass(frozen=True)
class BenchCase:
    """One row of a measurement: `make` returns the subject, which runs `ticks` ticks from the start in every round."""

    task: str
    make: Callable[[], Benchmarked]
    threads: int
    ticks: int


@dataclass(frozen=True)
class BenchGoal:
    """A goal of a measurement: the `value` of the rows is at least `least` or at most `most`."""

    what: str
    value: Callable[[Sequence[Row]], float]
    least: float | None = None
    most: float | None = None

    def of(self, rows: Sequence[Row]) -> Row:
        """Return the goal with the measured value; `passed` is None if it could not be measured."""
        value = self.value(rows)
        passed = (self.least or value) <= value <= (self.most or value) if value == value else None
        limits = {"least": self.least, "most": self.most}
        given = {key: limit for key, limit in limits.items() if limit is not None}
        return {"what": self.what, "value": value, **given, "passed": passed}


class UnderstudyCase:
    """Parallel worlds, with recording off."""

    def __init__(
        self, scenario: Scenario, library: Library, behavior: str, *, worlds: int = 1, threads: int = 1
    ) -> None:
        self.seeds, self.threads = range(worlds), threads
        self.world = World(scenario, self.seeds)
        self.robots = self.world.agents
        self.engine = Engine.from_program(self.world, link(library, behavior))

    def reset(self) -> None:
        """Restore the start of robots and automata."""
        self.world.reset(self.seeds)
        self.engine.restart()

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        self.engine.run(ticks, threads=self.threads)


class TeamCase:
    """One world of a scenario whose robots work under coordinators; a round begins after some ticks."""

    def __init__(
        self, scenario: Scenario, libraries: Libraries, runs: Mapping[str, str], *, begins: int = 0
    ) -> None:
        self._make = partial(
            make_team, scenario, [0], libraries, {sort: (each, {}) for sort, each in runs.items()}
        )
        self._begins = begins
        self.reset()
        self.robots = self.team.ground.agents

    def reset(self) -> None:
        """Restore the state in which a round begins."""
        self.team = self._make()
        self.team.run(self._begins)

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        self.team.run(ticks)


def measure(cases: Sequence[BenchCase], *, rounds: int) -> list[Row]:
    """Return a row per case with its robot-ticks per second: the median over rounds in which the cases take turns.

    An uncounted round comes first, because it compiles and fills caches. `spread` is the interquartile range relative
    to the median; `slowest` and `fastest` are the extreme rounds. A program that is not installed has no row, and a
    goal that needs it is not measured.
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
    """Return the time in s that a subject takes for the given number of ticks."""
    began = perf_counter()
    subject.run(ticks)
    return perf_counter() - began


def medians(repeats: int, **measured: Callable[[], object]) -> dict[str, float]:
    """Return the median time of each function in ms; they take turns, after one uncounted turn."""
    times: dict[str, list[float]] = {name: [] for name in measured}
    for _ in range(repeats + 1):
        for name, call in measured.items():
            began = perf_counter()
            call()
            times[name].append((perf_counter() - began) * 1e3)
    return {f"{name}_ms": median(taken[1:]) for name, taken in times.items()}


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
    """Return the robot-ticks per second of a row, by default the fastest over all threads; NaN without such a row."""
    speeds = [
        float(row["robot_ticks_per_s"])
        for row in rows
        if row["task"] == task and row["robots"] == robots and threads in (None, row["threads"])
    ]
    return max(speeds, default=nan)


def result(rows: Sequence[Row], goals: Sequence[BenchGoal]) -> Row:
    """Return the rows, the goals, and whether all measured goals were reached."""
    judged = [goal.of(rows) for goal in goals]
    return {
        "results": list(rows),
        "goals": judged,
        "passed": all(goal["passed"] is not False for goal in judged),
    }
