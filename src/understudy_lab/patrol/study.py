"""The experiment: independent teachings of the whole patrol, each tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.figures import dots, panels
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.live_comparison import (
    LIVE_TEACHINGS,
    Measure,
    is_live,
    make_live_goals,
    make_live_table,
    pair_by_seed,
)
from understudy_lab.patrol import four_patrols
from understudy_lab.patrol import teach as paper
from understudy_lab.patrol.evaluate import WORLDS, measure_patrol, worlds_of
from understudy_lab.patrol.flat_automaton import SECONDS, make_lone_robot_team, teach_undivided
from understudy_lab.patrol.teach import teach
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.tasks import patrol_teacher
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    made: list[Task] = [{"features": way, "seed": seed} for way in ways for seed in plan.seeds]
    return made + [{"features": OWN, "method": LIVE, "seed": seed} for seed in plan.seeds[:LIVE_TEACHINGS]]


def work(task: Task) -> Row:
    """Teach one patrol and test it in its own unseen worlds."""
    if task["features"] == UNDIVIDED:
        return _in_one_piece(task["seed"])
    if task["features"] == TOGETHER:
        return four_patrols.measure_four_patrols(task["seed"])
    topics = (paper.ROBOTS, paper.SQUADS) if task["features"] == PAPERS else ()
    taught = teach(task["seed"], *topics, method=task.get("method", "watched"))
    return {
        **measure_patrol(taught, worlds_of(task["seed"])),
        "lessons": [*lessons_of(taught.robots), *lessons_of(taught.coordinators)],
    }


def _in_one_piece(seed: int) -> dict[str, Any]:
    """Test one robot's Patrol, taught as one automaton and in layers, in the same worlds."""
    whole, robots = teach_undivided(seed), teach(seed, ALONE, ()).robots
    return {
        "whole": make_lone_robot_team(whole.library, worlds_of(seed)),
        "layers": make_lone_robot_team(robots.library, worlds_of(seed)),
        "lessons": lessons_of(whole),
        "lessons_in_layers": lessons_of(robots),
    }


ALONE = tuple(
    topic for topic in patrol_teacher.TOPICS if topic not in (patrol_teacher.SCATTER, patrol_teacher.RUN_AWAY)
)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize all teachings as a headline, tables, goals and notes."""
    whole = [row for row in rows if row["task"]["features"] == UNDIVIDED]
    live = [row for row in rows if is_live(row)]
    rows = [row for row in rows if row["task"]["features"] != UNDIVIDED and not is_live(row)]
    ways = {
        way: [row for row in rows if row["task"]["features"] == way]
        for way in dict.fromkeys(row["task"]["features"] for row in rows)
    }
    own, four = ways[OWN], ways.pop(TOGETHER, [])
    pairs = pair_by_seed(live, own)
    first, last = own[0]["task"]["seed"], own[-1]["task"]["seed"]
    well = sum(row["coordinated"]["complete"] >= GOOD for row in own)
    return StudyFindings(
        headline=f"{well} of {len(own)} taught teams complete at least {GOOD:.0%} of their cycles (capture an intruder,"
        f" gather at home, disperse) in unseen worlds; the median is {_told(own, 'coordinated', 'complete')}. All "
        f"automata of robots and coordinator together take {np.median(_examples(own)):.0f} examples. Without the "
        f"coordinator, robots spend {_ratio(own):.0f} times as long on attacking intruders that are gone.",
        tables=(
            ResultTable(
                f"Patrol, teachings {first} to {last}, {WORLDS} unseen worlds of ten minutes each: median (worst–best)",
                (
                    "",
                    "#alone (A)",
                    "#coordinated (B)",
                    "#B, messages 0.2 s late, 10 % lost",
                    *_paper_columns(ways),
                ),
                [
                    (said, *(_told(own, arm, key) for arm in ARMS), *_paper_cells(ways, key))
                    for said, key in ROUNDS.items()
                ],
            ),
            ResultTable(
                "Encounters with the boss, of all robots that could see him",
                ("", *(f"#{way}" for way in ways)),
                [
                    (said, *(_told(of, "deferring", key) for of in ways.values()))
                    for said, key in DEFERRALS.items()
                ],
            ),
            ResultTable(
                "Teaching effort per automaton: median (smallest–largest)",
                ("automaton", "#examples", "#seconds", "#states", "#features"),
                _lessons(own),
            ),
            *([_undivided(whole)] if whole else []),
            *([four_patrols.table(four)] if four else []),
            *([make_live_table(pairs, _count_examples, LIVE_RESULTS)] if pairs else []),
        ),
        goals=(
            *_goals(own),
            *([four_patrols.goal(four)] if four else []),
            *(make_live_goals(pairs, _count_examples, LIVE_RESULTS) if pairs else []),
        ),
        notes=_notes(own),
        numbers={"teachings": {way: len(of) for way, of in ways.items()}, "examples": _examples(own)},
    )


ARMS = ("alone", "coordinated", "bad_radio")
ROUNDS: Mapping[str, str] = {
    "cycles completed": "complete",
    "cycles": "cycles",
    "captures an hour": "captures_per_hour",
    "robots attacking when an intruder is caught": "attackers",
    "sightings after which all attack in the same tick": "joined_at_once",
    "robot-seconds of attacking an intruder that is gone": "residual_s",
    "returns home without a capture": "false_captures",
    "from sighting to capture, s": "sighting_to_capture_s",
}
DEFERRALS: Mapping[str, str] = {
    "encounters": "encounters",
    "all robots face the boss in time": "deferred",
    "patrol resumes 10 ± 0.3 s after the boss was last seen": "on_time",
}
SHARES = ("complete", "joined_at_once", "false_captures", "deferred", "on_time")


def _values(rows: Sequence[Row], arm: str, key: str) -> list[float]:
    found = [row[arm][key] for row in rows]
    return [each[0] if isinstance(each, list) else each for each in found if each is not None]


def _told(rows: Sequence[Row], arm: str, key: str) -> str:
    values = _values(rows, arm, key)
    digits = 1 if key in (*SHARES, "attackers", "sighting_to_capture_s") else 0
    return format_median(values, digits, percent=key in SHARES)


def _paper_columns(ways: Mapping[str, Sequence[Row]]) -> list[str]:
    return [f"#B, {PAPERS}"] if PAPERS in ways else []


def _paper_cells(ways: Mapping[str, Sequence[Row]], key: str) -> list[str]:
    return [_told(ways[PAPERS], "coordinated", key)] if PAPERS in ways else []


def _examples(rows: Sequence[Row]) -> list[int]:
    return [_count_examples(row) for row in rows]


def _count_examples(row: Row) -> int:
    return sum(lesson["examples"] for lesson in row["lessons"])


LIVE_RESULTS: Mapping[str, Measure] = {
    "cycles completed": lambda row: float(row["coordinated"]["complete"]),
    "cycles completed on a bad radio": lambda row: float(row["bad_radio"]["complete"]),
}


def _ratio(rows: Sequence[Row]) -> float:
    return float(
        np.median([row["alone"]["residual_s"] / max(1.0, row["coordinated"]["residual_s"]) for row in rows])
    )


def _lessons(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    names = [lesson["name"] for lesson in rows[0]["lessons"]]
    made = []
    for name in names:
        of = [lesson for row in rows for lesson in row["lessons"] if lesson["name"] == name]
        cells = (format_median([lesson[key] for lesson in of]) for key in ("examples", "seconds"))
        made.append((name, *cells, str(of[0]["states"]), str(of[0]["features"])))
    whole = [
        format_median([sum(lesson[key] for lesson in row["lessons"]) for row in rows])
        for key in ("examples", "seconds")
    ]
    return [*made, ("all", *whole, "", "")]


def _undivided(rows: Sequence[Row]) -> ResultTable:
    cells: list[tuple[str, list[list[float]]]] = [
        ("captures followed by a return home, an hour", [_rounds(rows, way) for way in ("whole", "layers")]),
        (
            "captures an hour",
            [[row[way]["captures_per_hour"] for row in rows] for way in ("whole", "layers")],
        ),
        ("examples", [[sum(each["examples"] for each in row[of]) for row in rows] for of in LESSONS]),
        ("teaching time, s", [[sum(each["seconds"] for each in row[of]) for row in rows] for of in LESSONS]),
    ]
    return ResultTable(
        f"One robot without a boss: Patrol taught as one automaton of eleven states for {SECONDS:.0f} s, and in layers,"
        f" tested in the same {WORLDS} worlds",
        ("", "#one automaton", "#layers"),
        [(said, *(format_median(values, 0) for values in both)) for said, both in cells],
    )


def _rounds(rows: Sequence[Row], way: str) -> list[float]:
    """Return the captures per hour of one robot after which it came home."""
    hours = WORLDS / 6.0
    return [row[way]["cycles"] * (row[way]["complete"] or 0.0) / hours for row in rows]


LESSONS = ("lessons", "lessons_in_layers")


def _goals(rows: Sequence[Row]) -> tuple[StudyGoal, ...]:
    well = sum(row["coordinated"]["complete"] >= GOOD for row in rows)
    radio = _median(rows, "bad_radio", "complete")
    false = _median(rows, "bad_radio", "false_captures")
    joined = min(_values(rows, "coordinated", "joined_at_once"))
    residual = float(
        np.median([row["coordinated"]["residual_s"] / row["alone"]["residual_s"] for row in rows])
    )
    deferred, on_time = _median(rows, "deferring", "deferred"), _median(rows, "deferring", "on_time")
    examples = float(np.median(_examples(rows)))
    failed = float(np.median([row["one_failed"] for row in rows]))
    need = int(np.ceil(0.9 * len(rows)))
    return (
        StudyGoal(
            "teachings that complete 95 % of the cycles",
            f"{need} of {len(rows)}",
            f"{well} of {len(rows)}",
            well >= need,
        ),
        StudyGoal(
            "all ordered to attack in the tick of a sighting", "always", f"{joined:.1%}, worst", joined >= 1
        ),
        StudyGoal(
            "time attacking intruders that are gone, as a share of (A)",
            "at most 2 %",
            f"{residual:.2%}",
            residual <= 0.02,
        ),
        StudyGoal(
            "encounters in which all face the boss in time", "95 %", f"{deferred:.1%}", deferred >= GOOD
        ),
        StudyGoal(
            "patrols that resume 10 ± 0.3 s after the boss was last seen",
            "all",
            f"{on_time:.1%}",
            on_time >= 1,
        ),
        StudyGoal("examples for all automata", "at most 200", f"{examples:.0f}", examples <= 200),
        StudyGoal("cycles completed on a bad radio", "95 %", f"{radio:.1%}", radio >= GOOD),
        StudyGoal(
            "returns home without a capture, on a bad radio", "at most 1 %", f"{false:.1%}", false <= 0.01
        ),
        StudyGoal(
            "captures after one of four robots has failed", "at least ×0.60", f"×{failed:.2f}", failed >= 0.6
        ),
    )


def _median(rows: Sequence[Row], arm: str, key: str) -> float:
    return float(np.median(_values(rows, arm, key)))


def _notes(rows: Sequence[Row]) -> tuple[str, ...]:
    worst = min(rows, key=lambda row: row["coordinated"]["complete"])
    one, of_all = rows[0]["states_of_one"], rows[0]["states_of_all"]
    return (
        f"As one automaton, CollectivePatrolAndDefer would have {one} states for one robot, and {of_all:,} for four "
        "robots that act side by side.",
        "Without a coordinator, a robot goes home with its intruder and disperses again. Its cycles count as completed "
        "if the other robots happen to be at home, too.",
        f"The worst teaching (seed {worst['task']['seed']}) completes {worst['coordinated']['complete']:.1%} of its "
        "cycles.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw cycles, attacks on absent intruders, and one robot's results as one automaton and in layers."""
    own, theirs, whole, four = (
        [row for row in rows if row["task"]["features"] == way and not is_live(row)]
        for way in (OWN, PAPERS, UNDIVIDED, TOGETHER)
    )
    figure, (left, middle, right) = panels(3)
    cycles: dict[str, Sequence[float]] = {
        "B": [100 * each for each in _values(own, "coordinated", "complete")],
        "B, bad\nradio": [100 * each for each in _values(own, "bad_radio", "complete")],
        "B, paper's\nfeatures": [100 * each for each in _values(theirs, "coordinated", "complete")],
        "C": [100 * each for each in _values(four, "together", "complete")],
    }
    dots(left, cycles, "cycles completed, %")
    left.set_title("capture, home, disperse")
    minutes = WORLDS * 10.0
    residual = {
        name: [each / minutes for each in _values(own, arm, "residual_s")]
        for name, arm in (("A", "alone"), ("B", "coordinated"))
    }
    dots(middle, residual, "robot-seconds a minute")
    middle.set_title("attacking absent intruders")
    pieces = {"one\nautomaton": _rounds(whole, "whole"), "layers": _rounds(whole, "layers")}
    dots(right, pieces, "rounds an hour")
    right.set_title("one robot, no coordinator")
    return figure


EXPERIMENT = Study(
    name="patrol",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("patrol", "regions"),
)
