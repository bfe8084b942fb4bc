"""The experiment: independent teachings of robots and three levels of coordinators, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy_lab.figures import dots, panels
from understudy_lab.lesson_stats import examples_in, lessons_in, lessons_of
from understudy_lab.live_comparison import (
    LIVE_TEACHINGS,
    Measure,
    is_live,
    make_live_goals,
    make_live_table,
    pair_by_seed,
)
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.swarm.evaluate import (
    ALONE,
    ANSWERING,
    FAILING,
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
from understudy_lab.tasks.swarm_world import EACH, ROBOT
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHINGS = range(60_100, 60_110)
"""The teaching seeds of the published result; none was used during development."""
AS_GOOD, WITHOUT = 0.8, 0.7
WEIGHTS = (1, 4, 10)
"""The numbers of crates that a container may count as: one box, the squads it needs, the crates it holds."""
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
SAID = {
    THREE: "all, platoons, squads",
    TWO: "platoons, squads",
    ONE: "squads",
    ANSWERING: "none; calls answered",
    ALONE: "none",
}
LARGE = f"{EACH * PLATOONS:,}".replace(",", " ")


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per seed, and unless quick, a few that are taught live."""
    made: list[Task] = [{"seed": seed} for seed in plan.seeds]
    return (
        made
        if plan.quick
        else made + [{"method": LIVE, "seed": seed} for seed in plan.seeds[:LIVE_TEACHINGS]]
    )


def work(task: Task) -> Row:
    """Teach a swarm with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"], method=task.get("method", "watched"))
    lessons = {ROBOT: lessons_of(taught.robots)}
    lessons |= {sort: lessons_of(teaching) for sort, teaching in taught.squads.items()}
    return {**measure_swarm(taught.libraries, worlds_of(task["seed"])), "lessons": lessons}


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize all teachings as a headline, tables, goals and notes."""
    live, rows = [row for row in rows if is_live(row)], [row for row in rows if not is_live(row)]
    pairs = pair_by_seed(live, rows)
    first, last = rows[0]["task"]["seed"], rows[-1]["task"]["seed"]
    shares = {way: _of_by_hand(rows, way) for way in WAYS}
    large = _large(rows)
    return StudyFindings(
        headline="Two hundred taught robots under three levels of taught coordinators gather "
        f"{np.median(shares[THREE]):.2f} times as much as hand-written automata, in unseen worlds. The same robots "
        f"gather {np.median(shares[ALONE]):.2f} times as much without coordinators, and "
        f"{np.median(shares[ANSWERING]):.2f} times as much if they answer each other's calls. Ten thousand robots with "
        f"the same libraries gather {np.median(large):.2f} times as much per robot. All lessons together take "
        f"{np.median(examples_in(rows)):.0f} examples.",
        tables=(
            ResultTable(
                f"Yield per hour, in runs of ten minutes, teachings {first} to {last}, {WORLDS} unseen worlds each: "
                f"median (worst–best). A container holds {LOADS['container']} loads, a crate one",
                ("coordinators of", "#crates/h", "#containers/h", "#loads/h", "#loads / hand-written"),
                [
                    *((SAID[way], *_told(rows, way), format_median(shares[way], 2)) for way in WAYS),
                    ("all three, hand-written", *_told(rows, None), "1"),
                ],
            ),
            ResultTable(
                "Yield relative to all three taught levels, if a container counts as that number of crates",
                ("coordinators of", *(f"#{weight}" for weight in WEIGHTS)),
                [
                    (SAID[way], *(format_median(_weighted(rows, way, weight), 2) for weight in WEIGHTS))
                    for way in (ONE, ANSWERING, ALONE)
                ],
            ),
            ResultTable(
                "Teaching effort per automaton: median (smallest–largest)",
                ("agent", "automaton", "#examples", "#seconds", "#states", "#features"),
                lessons_in(rows),
            ),
            *([make_live_table(pairs, _count_examples, LIVE_RESULTS)] if pairs else []),
        ),
        goals=(*_goals(rows), *(make_live_goals(pairs, _count_examples, LIVE_RESULTS) if pairs else [])),
        notes=_notes(rows),
        numbers={"teachings": len(rows), "shares": shares, "large": large, "examples": examples_in(rows)},
    )


def _count_examples(row: Row) -> int:
    return examples_in([row])[0]


LIVE_RESULTS: Mapping[str, Measure] = {
    "loads, relative to hand-written automata": lambda row: _of_by_hand([row], THREE)[0],
    "share of the yield kept after a third of the robots was killed": lambda row: float(row["kept"]),
}


def _rates(rows: Sequence[Row], way: str | None, what: str = "loads") -> list[float]:
    """Return each teaching's hourly yield with one degree of coordination; None means the hand-written automata."""
    return [(row["by_hand"] if way is None else row["taught"][way])[what] for row in rows]


def _told(rows: Sequence[Row], way: str | None) -> list[str]:
    return [format_median(_rates(rows, way, what)) for what in ("crates", "containers", "loads")]


def _of_by_hand(rows: Sequence[Row], way: str) -> list[float]:
    return _ratio(_rates(rows, way), _rates(rows, None))


def _of_taught(rows: Sequence[Row], way: str) -> list[float]:
    return _ratio(_rates(rows, way), _rates(rows, THREE))


def _counted(row: Row, way: str, weight: int) -> float:
    """Return the yield per hour in crates, with a container counted as `weight` crates."""
    return float(row["taught"][way]["crates"] + weight * row["taught"][way]["containers"])


def _weighted(rows: Sequence[Row], way: str, weight: int) -> list[float]:
    return _ratio(
        [_counted(row, way, weight) for row in rows], [_counted(row, THREE, weight) for row in rows]
    )


def _of_the_better(rows: Sequence[Row], way: str, weight: int) -> float:
    """Return the median yield relative to the better of squads only and all three levels."""
    better = [max(_counted(row, ONE, weight), _counted(row, THREE, weight)) for row in rows]
    return float(np.median(_ratio([_counted(row, way, weight) for row in rows], better)))


def _large(rows: Sequence[Row]) -> list[float]:
    """Return the yield per robot among ten thousand, relative to that among two hundred in the same time."""
    return _ratio([row["large"] for row in rows], [row["small"] for row in rows])


def _ratio(some: Sequence[float], others: Sequence[float]) -> list[float]:
    return [round(one / max(1e-9, other), 3) for one, other in zip(some, others, strict=True)]


def _goals(rows: Sequence[Row]) -> tuple[StudyGoal, ...]:
    share, kept = _of_by_hand(rows, THREE), [row["kept"] for row in rows]
    without = {way: _of_taught(rows, way) for way in (ALONE, ANSWERING)}
    return (
        StudyGoal(
            "yield of the taught hierarchy, relative to a hand-written one",
            f"{AS_GOOD}",
            format_median(share, 2),
            float(np.median(share)) >= AS_GOOD,
        ),
        *(
            StudyGoal(
                f"yield without coordinators ({way}), relative to the taught hierarchy",
                f"at most {WITHOUT}",
                format_median(found, 2),
                float(np.median(found)) <= WITHOUT,
            )
            for way, found in without.items()
        ),
        StudyGoal(
            "share of the yield kept after a third of the robots was killed",
            f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            format_median(kept, percent=True),
            float(np.median(kept)) >= KEPT,
        ),
    )


def _notes(rows: Sequence[Row]) -> tuple[str, ...]:
    squads, platoons = (float(np.median(_of_taught(rows, way))) for way in (ONE, TWO))
    least = max(_of_the_better(rows, way, weight) for way in (ANSWERING, ALONE) for weight in WEIGHTS)
    crates = [
        (row["taught"][THREE]["crates"] / row["by_hand"]["crates"], row["task"]["seed"]) for row in rows
    ]
    alone = [(share, row["task"]["seed"]) for share, row in zip(_of_by_hand(rows, ALONE), rows, strict=True)]
    return (
        f"Contribution of each level: with coordinators of squads only, robots gather {squads:.2f} of what all three "
        f"levels gather; with coordinators of platoons, too, {platoons:.2f}. The top coordinator costs some yield, "
        "because it first has all robots spread out. Its only benefit here is that one order moves two hundred robots.",
        f"That a container holds {LOADS['container']} crates is a property of this world, and it decides whether "
        "platoons pay. If a container counts as one crate, or as four (it takes four squads), coordinators of squads "
        "alone gather more, because gathering sixteen robots costs the crates that they leave. With any of these "
        f"weights, robots without coordinators gather at most {least:.2f} of the better of these two (median).",
        f"Worst teachings: under three levels, {min(crates)[0]:.2f} of the crates of the hand-written automata (seed "
        f"{min(crates)[1]}); robots alone, {min(alone)[0]:.2f} of their loads (seed {min(alone)[1]}). In these "
        "teachings, a lesson never succeeded.",
        f"Each of {LARGE} robots, in 400 platoons, gathers {format_median(_large(rows), 2)} times as much in five "
        "minutes as each of the two hundred robots for which the lessons were made. In both worlds, robots pass "
        "through each other.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw how much was brought home with fewer levels of coordinators, and with fewer and more robots."""
    rows = [row for row in rows if not is_live(row)]
    figure, (left, right) = panels(2, wide=4.2)
    short = ("three\nlevels", "platoons,\nsquads", "squads", "alone,\nanswering", "alone")
    shares = {said: _of_by_hand(rows, way) for said, way in zip(short, WAYS, strict=True)}
    dots(left, shares, "loads / hand-coded")
    left.axhline(1.0, color="#6b7280", linewidth=0.8, linestyle=":")
    left.set_title("with fewer levels of coordinators")
    left.set_ylim(bottom=0)
    other = {"a third\nkilled": [row["kept"] for row in rows], f"{LARGE}\nrobots": _large(rows)}
    dots(right, other, "of what 200 gather, each")
    right.axhline(1.0, color="#6b7280", linewidth=0.8, linestyle=":")
    right.set_title("with fewer and more robots")
    right.set_ylim(bottom=0)
    return figure


EXPERIMENT = Study(
    name="swarm",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("swarm",),
)
