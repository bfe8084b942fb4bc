"""The experiment: independent teachings of the whole patrol, each tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from understudy_lab.declaration import ColumnPerGroup, Conclusion, CountGoal, Goal, goals_among
from understudy_lab.figures import Dots, Panels
from understudy_lab.lesson_stats import LIVE_TEACHINGS, LessonTable, LiveComparison, examples_in, lessons_of
from understudy_lab.patrol import four_patrols
from understudy_lab.patrol.evaluate import (
    SECONDS,
    WORLDS,
    make_lone_robot_team,
    measure_patrol,
    teach_undivided,
    worlds_of,
)
from understudy_lab.patrol.practice import PAPERS_TOPICS, ROBOT, teach
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.tasks import patrol_teacher
from understudy_lab.teachers.live_teacher import LIVE

TEACHINGS = range(58_000, 58_010)
"""The teaching seeds of the published result; none was used during development."""
OWN, PAPERS, UNDIVIDED, TOGETHER = (
    "own features",
    "the paper's features",
    "one piece",
    "four patrols together",
)
GOOD = 0.95


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per variant and seed, and a few taught live; the quick version has only the first variant."""
    if plan.quick:
        return [{"features": OWN, "seed": seed} for seed in plan.seeds]
    ways = (OWN, PAPERS, UNDIVIDED, TOGETHER)
    teachings: list[Task] = [{"features": way, "seed": seed} for way in ways for seed in plan.seeds]
    return teachings + [
        {"features": OWN, "method": LIVE, "seed": seed} for seed in plan.seeds[:LIVE_TEACHINGS]
    ]


def work(task: Task) -> Row:
    """Teach one patrol and test it in its own unseen worlds."""
    if task["features"] == UNDIVIDED:
        return _in_one_piece(task["seed"])
    if task["features"] == TOGETHER:
        return four_patrols.measure_four_patrols(task["seed"])
    topics = PAPERS_TOPICS if task["features"] == PAPERS else None
    taught = teach(task["seed"], topics, method=task.get("method", "watched"))
    return {
        **measure_patrol(taught.libraries, worlds_of(task["seed"])),
        "lessons": [lesson for teaching in taught.by_sort.values() for lesson in lessons_of(teaching)],
    }


def _in_one_piece(seed: int) -> dict[str, Any]:
    """Test one robot's Patrol, taught as one automaton and in layers, in the same worlds."""
    whole, robots = teach_undivided(seed), teach(seed, {ROBOT: ALONE}).by_sort[ROBOT]
    return {
        "whole": make_lone_robot_team(whole.library, worlds_of(seed)),
        "layers": make_lone_robot_team(robots.library, worlds_of(seed)),
        "lessons": lessons_of(whole),
        "lessons_in_layers": lessons_of(robots),
    }


ALONE = tuple(
    topic for topic in patrol_teacher.TOPICS if topic not in (patrol_teacher.SCATTER, patrol_teacher.RUN_AWAY)
)


GROUPS = group_by("features", (OWN, PAPERS, UNDIVIDED, TOGETHER))
ARMS = {
    "alone (A)": (OWN, "alone"),
    "coordinated (B)": (OWN, "coordinated"),
    "B, messages 0.2 s late, 10 % lost": (OWN, "bad_radio"),
    f"B, {PAPERS}": (PAPERS, "coordinated"),
}
LAYERS = {"one automaton": ("whole", "lessons"), "layers": ("layers", "lessons_in_layers")}
"""The results and the lessons of one robot, taught as one automaton and in layers."""


def _by_arm(rows_by_way: Mapping[str, Rows]) -> dict[str, Rows]:
    return {
        arm: Rows(row[key] | row for row in rows_by_way[way])
        for arm, (way, key) in ARMS.items()
        if rows_by_way[way]
    }


def _by_features(rows_by_way: Mapping[str, Rows]) -> dict[str, Rows]:
    return {way: rows for way in (OWN, PAPERS) if (rows := rows_by_way[way])}


def _count_rounds(row: Row) -> float:
    """Return the captures per hour of one robot after which it came home."""
    return float(row["cycles"] * (row["complete"] or 0.0) / (WORLDS / 6.0))


UNDIVIDED_TABLE = ColumnPerGroup(
    f"One robot without a boss: Patrol taught as one automaton of eleven states for {SECONDS:.0f} s, and in layers,"
    f" tested in the same {WORLDS} worlds",
    lambda rows: {
        name: Rows({**row[way], "lessons": row[lessons]} for row in rows)
        for name, (way, lessons) in LAYERS.items()
    },
    {
        "captures followed by a return home, an hour": Median(_count_rounds),
        "captures an hour": Median("captures_per_hour"),
        "examples": Median(lambda row: examples_in([row])[0]),
        "teaching time, s": Median(lambda row: sum(lesson["seconds"] for lesson in row["lessons"])),
    },
)


def _headline(rows_by_way: Mapping[str, Rows]) -> str:
    own = rows_by_way[OWN]
    longer = own.median(lambda row: row["alone"]["residual_s"] / max(1.0, row["coordinated"]["residual_s"]))
    return (
        f"{COMPLETES.number(own)} of {len(own)} taught teams complete at least {GOOD:.0%} of their cycles (capture an "
        f"intruder, gather at home, disperse) in unseen worlds; the median is "
        f"{Median('coordinated.complete', 1, percent=True)(own)}. All automata of robots and coordinator together take "
        f"{np.median(examples_in(own)):.0f} examples. Without the coordinator, robots spend {longer:.0f} times as long "
        "on attacking intruders that are gone."
    )


def _notes(rows_by_way: Mapping[str, Rows]) -> tuple[str, ...]:
    first, worst = rows_by_way[OWN][0], min(rows_by_way[OWN], key=lambda row: row["coordinated"]["complete"])
    return (
        f"As one automaton, CollectivePatrolAndDefer would have {first['states_of_one']} states for one robot, and "
        f"{first['states_of_all']:,} for four robots that act side by side.",
        "Without a coordinator, a robot goes home with its intruder and disperses again. Its cycles count as completed "
        "if the other robots happen to be at home, too.",
        f"The worst teaching (seed {worst['task']['seed']}) completes {worst['coordinated']['complete']:.1%} of its "
        "cycles.",
    )


COMPLETES = Count(lambda row: row["coordinated"]["complete"] >= GOOD)
GOALS = (
    CountGoal("teachings that complete 95 % of the cycles", 0.9, COMPLETES.condition),
    Goal(
        "all ordered to attack in the tick of a sighting",
        lambda rows: min(rows.values("coordinated.joined_at_once")),
        "{:.1%}, worst",
        least=1,
        wanted="always",
    ),
    Goal(
        "time attacking intruders that are gone, as a share of (A)",
        lambda rows: rows.median(lambda row: row["coordinated"]["residual_s"] / row["alone"]["residual_s"]),
        ".2%",
        most=0.02,
        wanted="at most 2 %",
    ),
    Goal("encounters in which all face the boss in time", "deferring.deferred", ".1%", GOOD, wanted="95 %"),
    Goal(
        "patrols that resume 10 ± 0.3 s after the boss was last seen",
        "deferring.on_time",
        ".1%",
        1,
        wanted="all",
    ),
    Goal("examples for all automata", lambda rows: float(np.median(examples_in(rows))), ".0f", most=200),
    Goal("cycles completed on a bad radio", "bad_radio.complete", ".1%", GOOD, wanted="95 %"),
    Goal(
        "returns home without a capture, on a bad radio",
        "bad_radio.false_captures",
        ".1%",
        most=0.01,
        wanted="at most 1 %",
    ),
    Goal(
        "captures after one of four robots has failed", "one_failed", "×{:.2f}", 0.6, wanted="at least ×0.60"
    ),
)

EXPERIMENT = Study(
    name="patrol",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=GROUPS,
        headline=_headline,
        tables=(
            ColumnPerGroup(
                f"Patrol, teachings {{seeds}}, {WORLDS} unseen worlds of ten minutes each: median (worst–best)",
                _by_arm,
                {
                    "cycles completed": Median("complete", 1, percent=True),
                    "cycles": Median("cycles"),
                    "captures an hour": Median("captures_per_hour"),
                    "robots attacking when an intruder is caught": Median("attackers", 1),
                    "sightings after which all attack in the same tick": Median(
                        "joined_at_once", 1, percent=True
                    ),
                    "robot-seconds of attacking an intruder that is gone": Median("residual_s"),
                    "returns home without a capture": Median("false_captures", 1, percent=True),
                    "from sighting to capture, s": Median(
                        lambda row: (row["sighting_to_capture_s"] or [None])[0], 1
                    ),
                },
            ),
            ColumnPerGroup(
                "Encounters with the boss, of all robots that could see him",
                _by_features,
                {
                    "encounters": Median("deferring.encounters"),
                    "all robots face the boss in time": Median("deferring.deferred", 1, percent=True),
                    "patrol resumes 10 ± 0.3 s after the boss was last seen": Median(
                        "deferring.on_time", 1, percent=True
                    ),
                },
            ),
            lambda rows_by_way: LessonTable()(rows_by_way[OWN]),
            lambda rows_by_way: UNDIVIDED_TABLE(rows_by_way[UNDIVIDED]) if rows_by_way[UNDIVIDED] else None,
            lambda rows_by_way: four_patrols.table(rows_by_way[TOGETHER]) if rows_by_way[TOGETHER] else None,
        ),
        goals=(
            *goals_among(lambda rows_by_way: rows_by_way[OWN], GOALS),
            lambda rows_by_way: four_patrols.goal(rows_by_way[TOGETHER]) if rows_by_way[TOGETHER] else None,
        ),
        notes=_notes,
        numbers=lambda rows_by_way: {
            "teachings": {way: len(rows) for way, rows in _by_features(rows_by_way).items()},
            "examples": examples_in(rows_by_way[OWN]),
        },
        live=LiveComparison(
            lambda row: examples_in([row])[0],
            {
                "cycles completed": "coordinated.complete",
                "cycles completed on a bad radio": "bad_radio.complete",
            },
        ),
    ),
    draw=Panels(
        (
            Dots(
                "capture, home, disperse",
                "cycles completed, %",
                lambda rows_by_way: {
                    label: [100 * each for each in rows_by_way[way].values(of)]
                    for label, way, of in (
                        ("B", OWN, "coordinated.complete"),
                        ("B, bad\nradio", OWN, "bad_radio.complete"),
                        ("B, paper's\nfeatures", PAPERS, "coordinated.complete"),
                        ("C", TOGETHER, "together.complete"),
                    )
                },
            ),
            Dots(
                "attacking absent intruders",
                "robot-seconds a minute",
                lambda rows_by_way: {
                    label: [each / (WORLDS * 10.0) for each in rows_by_way[OWN].values(of)]
                    for label, of in (("A", "alone.residual_s"), ("B", "coordinated.residual_s"))
                },
            ),
            Dots(
                "one robot, no coordinator",
                "rounds an hour",
                lambda rows_by_way: {
                    label: [_count_rounds(row[way]) for row in rows_by_way[UNDIVIDED]]
                    for label, way in (("one\nautomaton", "whole"), ("layers", "layers"))
                },
            ),
        ),
        prepare=lambda rows: GROUPS(rows.where(method=None)),
    ),
    worlds=("patrol", "regions"),
)
