"""Whether robots that all head for one point for 3 000 ticks slow the full task down: what ruins a neighbor grid."""

from __future__ import annotations

from understudy_lab.bench import programs, standard_task
from understudy_lab.bench.harness import Goal, Row, result, seconds
from understudy_lab.bench.understudy_case import Ours

CROWDING_ROBOTS, CROWDING_THREADS = 10_000, 2
PIECE = 100
MOST = 2.0


def run_crowding(robots: int = CROWDING_ROBOTS, ticks: int = standard_task.CROWDING_TICKS) -> Row:
    """The full task, and its crowd piece by piece: the two take turns, so that noise meets both.

    `slowed` compares the last ten pieces of the crowd, when all are there, with as many runs of the full task at
    the same time; `slowed_in_all` compares everything.
    """
    spread = Ours(
        standard_task.make_full_scenario(robots),
        programs.make_full_library(),
        programs.FULL,
        threads=CROWDING_THREADS,
    )
    crowd = Ours(
        standard_task.crowding(robots),
        programs.make_full_library(programs.CROWD),
        programs.FULL,
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
        Goal(
            "times slower, at the end",
            lambda rows: rows[1]["s_at_the_end"] / rows[0]["s_at_the_end"],
            most=MOST,
        ),
        Goal("times slower, in all", lambda rows: rows[1]["s"] / rows[0]["s"], most=MOST),
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
