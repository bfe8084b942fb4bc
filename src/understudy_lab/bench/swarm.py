"""How fast swarms run the standard task, beside Mesa 3, VMAS and a prototype written by hand, in the same run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from understudy_lab.bench import programs, standard_task
from understudy_lab.bench.handwritten_baseline import Prototype
from understudy_lab.bench.harness import Case, Goal, Row, measure, result, speed
from understudy_lab.bench.mesa_case import MesaBase
from understudy_lab.bench.understudy_case import Ours
from understudy_lab.bench.vmas_case import VmasBase

ROUNDS = 7
ROBOTS_PER_WORLD = 10
"""Robots in each world, where worlds lie side by side."""

FULL, BASE, BASE_EACH = "full", "base", "base, 10 robots a world"
BY_HAND, BASE_BY_HAND = "full, by hand", "base, by hand"
MESA, MESA_TREE = "base, Mesa", "base, Mesa with a k-d tree"
VMAS, VMAS_EACH = "base, VMAS", "base, VMAS, 10 robots a world"


def groups() -> list[list[Case]]:
    """What takes turns: what is compared, and then the large sizes by themselves."""
    return [
        [
            *_full(1_000, ticks=standard_task.TICKS),
            _base(1_000, threads=1),
            _base(1_000, threads=2),
            _base_by_hand(1_000),
            Case(MESA, partial(MesaBase, 1_000), 1, 5),
            Case(MESA_TREE, partial(MesaBase, 1_000, kd_tree=True), 1, 10),
        ],
        [
            *_full(10_000, ticks=standard_task.TICKS),
            _base(10_000, threads=1),
            _base(10_000, threads=2),
            _base_by_hand(10_000),
            Case(MESA, partial(MesaBase, 10_000), 1, 1),
            Case(MESA_TREE, partial(MesaBase, 10_000, kd_tree=True), 1, 2),
        ],
        [
            _base_each(1_000, threads=2),
            Case(VMAS_EACH, partial(VmasBase, ROBOTS_PER_WORLD, worlds=1_000, threads=2), 2, 10),
        ],
        [
            _base(100, threads=1),
            Case(VMAS, partial(VmasBase, 100, worlds=1, threads=1), 1, 20),
            Case(VMAS, partial(VmasBase, 100, worlds=1, threads=2), 2, 20),
        ],
        _full(100_000, ticks=30),
    ]


def _full(robots: int, *, ticks: int) -> list[Case]:
    library = programs.make_full_library()
    cases = []
    for threads in (1, 2):
        ours = partial(
            Ours, standard_task.make_full_scenario(robots), library, programs.FULL, threads=threads
        )
        by_hand = partial(Prototype, robots, library, programs.FULL, sonar=True, threads=threads)
        cases += [Case(FULL, ours, threads, ticks), Case(BY_HAND, by_hand, threads, ticks)]
    return cases


def _base(robots: int, *, threads: int) -> Case:
    ours = partial(
        Ours,
        standard_task.make_base_scenario(robots),
        programs.make_base_library(),
        programs.BASE,
        threads=threads,
    )
    return Case(BASE, ours, threads, standard_task.TICKS)


def _base_each(worlds: int, *, threads: int) -> Case:
    scenario, library = standard_task.make_base_scenario(ROBOTS_PER_WORLD), programs.make_base_library()
    ours = partial(Ours, scenario, library, programs.BASE, worlds=worlds, threads=threads)
    return Case(BASE_EACH, ours, threads, standard_task.TICKS)


def _base_by_hand(robots: int) -> Case:
    made = partial(Prototype, robots, programs.make_base_library(), programs.BASE, sonar=False, threads=2)
    return Case(BASE_BY_HAND, made, 2, standard_task.TICKS)


def _at_least(robots: int, threads: int, least: float) -> Goal:
    what = f"full, {robots} robots, {threads} {'thread' if threads == 1 else 'threads'}: robot-ticks/s"
    return Goal(what, lambda rows: speed(rows, FULL, robots, threads=threads), least)


def _times(what: str, ours: str, theirs: str, robots: int, least: float) -> Goal:
    def ratio(rows: Sequence[Row]) -> float:
        return speed(rows, ours, robots) / speed(rows, theirs, robots)

    return Goal(f"base, {robots} robots: times {what}", ratio, least)


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


def run(cases: Callable[[], list[list[Case]]] = groups, *, rounds: int = ROUNDS) -> Row:
    """Rows of all groups, the goals, and our fraction of the prototype's speed."""
    rows = [row for group in cases() for row in measure(group, rounds=rounds)]
    return {**result(rows, GOALS), "fractions": fractions(rows), "missing": missing(rows)}


def missing(rows: list[Row]) -> list[str]:
    """The peers without a row, since they are not installed."""
    told = {row["task"] for row in rows}
    return [peer for peer, task in (("Mesa 3", MESA), ("VMAS with PyTorch", VMAS)) if task not in told]


def fractions(rows: list[Row]) -> list[Row]:
    """Our speed as a share of the prototype's, which leaves out collisions and everything general."""
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
