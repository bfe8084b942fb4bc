"""Swarms on the standard task compared with Mesa 3, VMAS and hand-written kernels; crowding, memory, squads."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from understudy_lab.bench import standard_task
from understudy_lab.bench.handwritten_baseline import HandwrittenBaseline
from understudy_lab.bench.harness import (
    BenchCase,
    BenchGoal,
    Row,
    TeamCase,
    UnderstudyCase,
    measure,
    result,
    seconds,
    speed,
)
from understudy_lab.bench.mesa_case import MesaBase
from understudy_lab.bench.vmas_case import VmasBase
from understudy_lab.tasks.swarm_world import EACH, SWARM, make_expert_libraries, of_platoons

ROUNDS = 7
ROBOTS_PER_WORLD = 10
"""The number of robots in each of many parallel worlds."""

FULL, BASE, BASE_EACH = "full", "base", "base, 10 robots a world"
BY_HAND, BASE_BY_HAND = "full, by hand", "base, by hand"
MESA, MESA_TREE = "base, Mesa", "base, Mesa with a k-d tree"
VMAS, VMAS_EACH = "base, VMAS", "base, VMAS, 10 robots a world"


def groups() -> list[list[BenchCase]]:
    """Return the groups of cases that take turns: first the compared ones, then the large sizes alone."""
    return [
        [
            *_full(1_000, ticks=standard_task.TICKS),
            _base(1_000, threads=1),
            _base(1_000, threads=2),
            _base_by_hand(1_000),
            BenchCase(MESA, partial(MesaBase, 1_000), 1, 5),
            BenchCase(MESA_TREE, partial(MesaBase, 1_000, kd_tree=True), 1, 10),
        ],
        [
            *_full(10_000, ticks=standard_task.TICKS),
            _base(10_000, threads=1),
            _base(10_000, threads=2),
            _base_by_hand(10_000),
            BenchCase(MESA, partial(MesaBase, 10_000), 1, 1),
            BenchCase(MESA_TREE, partial(MesaBase, 10_000, kd_tree=True), 1, 2),
        ],
        [
            _base(ROBOTS_PER_WORLD, threads=2, worlds=1_000),
            BenchCase(VMAS_EACH, partial(VmasBase, ROBOTS_PER_WORLD, worlds=1_000, threads=2), 2, 10),
        ],
        [
            _base(100, threads=1),
            BenchCase(VMAS, partial(VmasBase, 100, worlds=1, threads=1), 1, 20),
            BenchCase(VMAS, partial(VmasBase, 100, worlds=1, threads=2), 2, 20),
        ],
        _full(100_000, ticks=30),
    ]


def make_full_case(robots: int, *, threads: int) -> UnderstudyCase:
    """Make robots that run the full task."""
    scenario, library = standard_task.make_full_scenario(robots), standard_task.make_full_library()
    return UnderstudyCase(scenario, library, standard_task.FULL, threads=threads)


def _full(robots: int, *, ticks: int) -> list[BenchCase]:
    library = standard_task.make_full_library()
    cases = []
    for threads in (1, 2):
        ours = partial(make_full_case, robots, threads=threads)
        by_hand = partial(
            HandwrittenBaseline, robots, library, standard_task.FULL, sonar=True, threads=threads
        )
        cases += [BenchCase(FULL, ours, threads, ticks), BenchCase(BY_HAND, by_hand, threads, ticks)]
    return cases


def _base(robots: int, *, threads: int, worlds: int = 1) -> BenchCase:
    scenario, library = standard_task.make_base_scenario(robots), standard_task.make_base_library()
    ours = partial(UnderstudyCase, scenario, library, standard_task.BASE, worlds=worlds, threads=threads)
    return BenchCase(BASE if worlds == 1 else BASE_EACH, ours, threads, standard_task.TICKS)


def _base_by_hand(robots: int) -> BenchCase:
    made = partial(
        HandwrittenBaseline,
        robots,
        standard_task.make_base_library(),
        standard_task.BASE,
        sonar=False,
        threads=2,
    )
    return BenchCase(BASE_BY_HAND, made, 2, standard_task.TICKS)


def _at_least(robots: int, threads: int, least: float) -> BenchGoal:
    what = f"full, {robots} robots, {threads} {'thread' if threads == 1 else 'threads'}: robot-ticks/s"
    return BenchGoal(what, lambda rows: speed(rows, FULL, robots, threads=threads), least)


def _times(what: str, ours: str, theirs: str, robots: int, least: float) -> BenchGoal:
    def ratio(rows: Sequence[Row]) -> float:
        return speed(rows, ours, robots) / speed(rows, theirs, robots)

    return BenchGoal(f"base, {robots} robots: times {what}", ratio, least)


GOALS = (
    _at_least(1_000, 2, 4e6),
    _at_least(10_000, 2, 6e6),
    _at_least(100_000, 2, 6e6),
    _at_least(10_000, 1, 4e6),
    _times("Mesa", BASE, MESA, 1_000, 50),
    _times("Mesa", BASE, MESA, 10_000, 200),
    _times("VMAS, 10 robots a world", BASE_EACH, VMAS_EACH, 10_000, 3),
    _times("VMAS, one world", BASE, VMAS, 100, 50),
)


def run(cases: Callable[[], list[list[BenchCase]]] = groups, *, rounds: int = ROUNDS) -> Row:
    """Return the rows of all groups, the goals, and our speed relative to the hand-written kernels."""
    rows = [row for group in cases() for row in measure(group, rounds=rounds)]
    return {**result(rows, GOALS), "fractions": fractions(rows), "missing": list_missing_peers(rows)}


def list_missing_peers(rows: list[Row]) -> list[str]:
    """Return the names of the programs without a row because they are not installed."""
    told = {row["task"] for row in rows}
    return [peer for peer, task in (("Mesa 3", MESA), ("VMAS with PyTorch", VMAS)) if task not in told]


def fractions(rows: list[Row]) -> list[Row]:
    """Return our speed relative to the hand-written kernels, which have no collisions and nothing general."""
    pairs = {BY_HAND: FULL, BASE_BY_HAND: BASE}
    return [
        {
            "task": pairs[row["task"]],
            "robots": row["robots"],
            "threads": row["threads"],
            "of_by_hand": speed(rows, pairs[row["task"]], row["robots"], threads=row["threads"])
            / row["robot_ticks_per_s"],
        }
        for row in rows
        if row["task"] in pairs
    ]


CROWDING_ROBOTS, CROWDING_THREADS = 10_000, 2
PIECE = 100
MOST = 2.0


def run_crowding(robots: int = CROWDING_ROBOTS, ticks: int = standard_task.CROWDING_TICKS) -> Row:
    """Compare the full task with its crowded version, in alternating pieces, so that noise affects both.

    `slowed` compares the last ten pieces of the crowd, when all robots have arrived, with as many pieces of the full
    task at the same time; `slowed_in_all` compares everything.
    """
    spread = make_full_case(robots, threads=CROWDING_THREADS)
    crowd = UnderstudyCase(
        standard_task.make_crowded_scenario(robots),
        standard_task.make_full_library(standard_task.CROWD),
        standard_task.FULL,
        threads=CROWDING_THREADS,
    )
    for subject in (spread, crowd):
        subject.run(PIECE)
        subject.reset()
    times: dict[str, list[float]] = {"full": [], "crowding": []}
    for _ in range(ticks // PIECE):
        spread.reset()
        times["full"].append(seconds(spread, PIECE))
        times["crowding"].append(seconds(crowd, PIECE))
    rows = [_row(task, robots, measured) for task, measured in times.items()]
    goals = [
        BenchGoal(
            "times slower, at the end",
            lambda rows: rows[1]["s_at_the_end"] / rows[0]["s_at_the_end"],
            most=MOST,
        ),
        BenchGoal("times slower, in all", lambda rows: rows[1]["s"] / rows[0]["s"], most=MOST),
    ]
    return result(rows, goals)


def _row(task: str, robots: int, measured: list[float]) -> Row:
    return {
        "task": task,
        "robots": robots,
        "threads": CROWDING_THREADS,
        "robot_ticks_per_s": robots * PIECE * len(measured) / sum(measured),
        "ticks": PIECE * len(measured),
        "s": sum(measured),
        "s_at_the_end": sum(measured[-10:]),
        "slowest": robots * PIECE / max(measured),
        "fastest": robots * PIECE / min(measured),
    }


MILLION_ROBOTS, MILLION_THREADS, TICKS = 1_000_000, 2, 10
MOST_BYTES = 1000.0


def run_million(robots: int = MILLION_ROBOTS, ticks: int = TICKS) -> Row:
    """Run the full task with a million robots; memory is the process's peak less its use before the world was made."""
    make_full_case(1_000, threads=MILLION_THREADS).run(5)  # compiles
    before = measure_memory()
    subject = make_full_case(robots, threads=MILLION_THREADS)
    subject.run(1)
    speed = robots * ticks / seconds(subject, ticks)
    row = {
        "task": "full",
        "robots": robots,
        "threads": MILLION_THREADS,
        "robot_ticks_per_s": speed,
        "ticks": ticks,
        "bytes_per_robot": (measure_peak_memory() - before) / robots,
    }
    return result(
        [row], [BenchGoal("bytes per robot", lambda rows: rows[0]["bytes_per_robot"], most=MOST_BYTES)]
    )


def measure_memory() -> int:
    """Return the memory that the process uses now, in bytes, or its peak where the system has no such figure."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()
    except (ImportError, OSError):
        return measure_peak_memory()


def measure_peak_memory() -> int:
    """Return the peak memory of the process in bytes; 0 where the system has no such figure (Windows)."""
    try:
        import resource
    except ImportError:
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024


TASK, PLATOONS, LARGE, SQUAD_ROUNDS = "three levels of squads", 8, 400, 5
AT_WORK = 150
"""The tick of a round's begin, at which all robots work, after the ten seconds in which they spread out."""
HERTZ, TIMES = 10, 10
"""The ticks per simulated second, and the goal for the speed relative to real time."""


def make_squad_cases() -> list[BenchCase]:
    """Return the cases: the built-in swarm, and ten thousand robots."""
    threads, ticks = {PLATOONS: 1, LARGE: os.cpu_count() or 1}, {PLATOONS: 1_000, LARGE: 200}
    makers = {
        platoons: partial(
            TeamCase, of_platoons(platoons), make_expert_libraries(), {SWARM: "swarm_work"}, begins=AT_WORK
        )
        for platoons in threads
    }
    return [BenchCase(TASK, make, threads[each], ticks[each]) for each, make in makers.items()]


SQUAD_GOALS = (
    BenchGoal(
        f"{EACH * LARGE} robots: times real time, at {HERTZ} Hz",
        lambda rows: speed(rows, TASK, EACH * LARGE) / (EACH * LARGE) / HERTZ,
        least=TIMES,
    ),
)


def run_squads(*, rounds: int = SQUAD_ROUNDS) -> Row:
    """Measure both cases, and compare them with the goals."""
    return result(measure(make_squad_cases(), rounds=rounds), SQUAD_GOALS)
