"""The experiment: independent teachings of robots and three levels of coordinators, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from understudy_lab.declaration import Conclusion, Goal, LinePerGroup
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.lesson_stats import LIVE_TEACHINGS, LessonTable, LiveComparison, examples_in, lessons_of
from understudy_lab.rows import Groups, Median, Rows
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.swarm.evaluate import (
    ALONE,
    ANSWERING,
    LOADS,
    ONE,
    PLATOONS,
    THREE,
    TWO,
    WAYS,
    WORLDS,
    measure_swarm,
    worlds_of,
)
from understudy_lab.swarm.practice import teach
from understudy_lab.tasks.swarm_world import EACH
from understudy_lab.teachers.live_teacher import LIVE
from understudy_lab.teams import FAILING

TEACHINGS = range(60_100, 60_110)
"""The teaching seeds of the published result; none was used during development."""
AS_GOOD, WITHOUT = 0.8, 0.7
WEIGHTS = (1, 4, 10)
"""The numbers of crates that a container may count as: one box, the squads it needs, the crates it holds."""
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
BY_HAND = "by hand"
NAMES = {
    THREE: "all, platoons, squads",
    TWO: "platoons, squads",
    ONE: "squads",
    ANSWERING: "none; calls answered",
    ALONE: "none",
    BY_HAND: "all three, hand-written",
}
SHORT = ("three\nlevels", "platoons,\nsquads", "squads", "alone,\nanswering", "alone")
LARGE = f"{EACH * PLATOONS:,}".replace(",", " ")


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per seed, and unless quick, a few that are taught live."""
    live = [] if plan.quick else plan.seeds[:LIVE_TEACHINGS]
    return [*({"seed": seed} for seed in plan.seeds), *({"method": LIVE, "seed": seed} for seed in live)]


def work(task: Task) -> Row:
    """Teach a swarm with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"], method=task.get("method", "watched"))
    lessons = {sort: lessons_of(teaching) for sort, teaching in taught.by_sort.items()}
    return {**measure_swarm(taught.libraries, worlds_of(task["seed"])), "lessons": lessons}


def _yield(row: Row, way: str) -> Mapping[str, float]:
    return cast("Mapping[str, float]", row["by_hand"] if way == BY_HAND else row["taught"][way])


def _compare(way: str, to: str = BY_HAND) -> Callable[[Row], float]:
    """Return a function that compares the loads that are gathered in two ways."""
    return lambda row: _divide(_yield(row, way)["loads"], _yield(row, to)["loads"])


def _weigh(row: Row, way: str, weight: int) -> float:
    """Return the yield per hour in crates, with a container counted as `weight` crates."""
    return _yield(row, way)["crates"] + weight * _yield(row, way)["containers"]


def _divide(one: float, other: float) -> float:
    return round(one / max(1e-9, other), 3)


def _large(row: Row) -> float:
    """Return the yield per robot among ten thousand, relative to that among two hundred in the same time."""
    return _divide(row["large"], row["small"])


def _examples(row: Row) -> int:
    return examples_in([row])[0]


def _by_way(*ways: str) -> Groups:
    return lambda rows: {way: Rows({**row, **_yield(row, way), "way": way} for row in rows) for way in ways}


def _share(rows: Rows) -> str:
    way = rows[0]["way"]
    return "1" if way == BY_HAND else Median(_compare(way), 2)(rows)


def _headline(rows: Rows) -> str:
    three, alone, answering = (rows.median(_compare(way)) for way in (THREE, ALONE, ANSWERING))
    return (
        "Two hundred taught robots under three levels of taught coordinators gather "
        f"{three:.2f} times as much as hand-written automata, in unseen worlds. The same robots gather {alone:.2f} "
        f"times as much without coordinators, and {answering:.2f} times as much if they answer each other's calls. Ten "
        f"thousand robots with the same libraries gather {rows.median(_large):.2f} times as much per robot. All "
        f"lessons together take {rows.median(_examples):.0f} examples."
    )


def _notes(rows: Rows) -> tuple[str, ...]:
    squads, platoons = (rows.median(_compare(way, THREE)) for way in (ONE, TWO))
    crates, alone = (
        min((compare(row), row["task"]["seed"]) for row in rows)
        for compare in (
            lambda row: row["taught"][THREE]["crates"] / row["by_hand"]["crates"],
            _compare(ALONE),
        )
    )
    least = max(
        np.median(
            [_divide(_weigh(row, way, n), max(_weigh(row, ONE, n), _weigh(row, THREE, n))) for row in rows]
        )
        for way in (ANSWERING, ALONE)
        for n in WEIGHTS
    )
    return (
        f"Contribution of each level: with coordinators of squads only, robots gather {squads:.2f} of what all three "
        f"levels gather; with coordinators of platoons, too, {platoons:.2f}. The top coordinator costs some yield, "
        "because it first has all robots spread out. Its only benefit here is that one order moves two hundred robots.",
        f"That a container holds {LOADS['container']} crates is a property of this world, and it decides whether "
        "platoons pay. If a container counts as one crate, or as four (it takes four squads), coordinators of squads "
        "alone gather more, because gathering sixteen robots costs the crates that they leave. With any of these "
        f"weights, robots without coordinators gather at most {least:.2f} of the better of these two (median).",
        f"Worst teachings: under three levels, {crates[0]:.2f} of the crates of the hand-written automata (seed "
        f"{crates[1]}); robots alone, {alone[0]:.2f} of their loads (seed {alone[1]}). In these teachings, a lesson "
        "never succeeded.",
        f"Each of {LARGE} robots, in 400 platoons, gathers {Median(_large, 2)(rows)} times as much in five minutes as "
        "each of the two hundred robots for which the lessons were made. In both worlds, robots pass through each "
        "other.",
    )


EXPERIMENT = Study(
    name="swarm",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            LinePerGroup(
                f"Yield per hour, in runs of ten minutes, teachings {{seeds}}, {WORLDS} unseen worlds each: "
                f"median (worst–best). A container holds {LOADS['container']} loads, a crate one",
                ["coordinators of"],
                _by_way(*NAMES),
                {
                    **{f"{what}/h": Median(what) for what in ("crates", "containers", "loads")},
                    "loads / hand-written": _share,
                },
                lambda way: [NAMES[way]],
            ),
            LinePerGroup(
                "Yield relative to all three taught levels, if a container counts as that number of crates",
                ["coordinators of"],
                _by_way(ONE, ANSWERING, ALONE),
                {
                    str(n): Median(
                        lambda row, n=n: _divide(_weigh(row, row["way"], n), _weigh(row, THREE, n)), 2
                    )
                    for n in WEIGHTS
                },
                lambda way: [NAMES[way]],
            ),
            LessonTable("agent"),
        ),
        goals=(
            Goal(
                "yield of the taught hierarchy, relative to a hand-written one",
                Median(_compare(THREE), 2),
                "",
                AS_GOOD,
            ),
            *(
                Goal(
                    f"yield without coordinators ({way}), relative to the taught hierarchy",
                    Median(_compare(way, THREE), 2),
                    "",
                    most=WITHOUT,
                )
                for way in (ALONE, ANSWERING)
            ),
            Goal(
                "share of the yield kept after a third of the robots was killed",
                Median("kept", percent=True),
                least=KEPT,
                wanted=f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            ),
        ),
        notes=_notes,
        numbers=lambda rows: {
            "teachings": len(rows),
            "shares": {way: rows.values(_compare(way)) for way in WAYS},
            "large": rows.values(_large),
            "examples": examples_in(rows),
        },
        live=LiveComparison(
            _examples,
            {
                "loads, relative to hand-written automata": _compare(THREE),
                "share of the yield kept after a third of the robots was killed": "kept",
            },
        ),
    ),
    draw=Panels(
        (
            Dots(
                "with fewer levels of coordinators",
                "loads / hand-coded",
                by_value(dict(zip(map(_compare, WAYS), SHORT, strict=True))),
                limits=(0, None),
                dotted=1.0,
            ),
            Dots(
                "with fewer and more robots",
                "of what 200 gather, each",
                by_value({"kept": "a third\nkilled", _large: f"{LARGE}\nrobots"}),
                limits=(0, None),
                dotted=1.0,
            ),
        ),
        wide=4.2,
        prepare=lambda rows: rows.where(method=None),
    ),
    worlds=("swarm",),
)
