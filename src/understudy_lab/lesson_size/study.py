"""The experiment: every lesson of the other experiments taught again, and its size counted."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec
import numpy as np

from understudy_lab.behavior_suite import task as repertoire
from understudy_lab.behavior_suite.study import FEATS
from understudy_lab.figures import Panels, dots
from understudy_lab.forage import teach as forage
from understudy_lab.hierarchy import teach as hierarchy
from understudy_lab.lesson_size.robocup import summary
from understudy_lab.lesson_stats import describe_lesson, lessons_of
from understudy_lab.novices.novice import Novice, draw_traits
from understudy_lab.rows import Rows
from understudy_lab.servoing import trials as servoing
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyPlan, Task
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.teachers.teacher import TeachingResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(57_100, 57_105)
ROBOCUP = "RoboCup team"
FOLDER = "UNDERSTUDY_ROBOCUP_LESSONS"
"""The environment variable that names the folder of the RoboCup team's lessons, set from --data."""

Lessons: TypeAlias = list[dict[str, Any]]


def _novice(seed: int) -> Lessons:
    novice = Novice(draw_traits(seed), seed)
    return [describe_lesson(novice.teach(), novice.seconds)]


def _piece(way: str, seed: int) -> Lessons:
    lessons: Lessons = hierarchy.measure_teaching(way, seed)["lessons"]
    return lessons


def _begun(teach: Callable[[int], TeachingResult], seed: int) -> Lessons:
    """Return the lessons of a teaching, each with the number of times it was started; all their seconds count."""
    teaching = teach(seed)
    return [{**lesson, "begun": teaching.accounts[lesson["name"]].lessons} for lesson in lessons_of(teaching)]


SOURCES: Mapping[str, Mapping[str, Callable[[int], Lessons]]] = {
    "forage": {way: partial(_begun, partial(forage.teach, method=way)) for way in ("watched", "plain")},
    "repertoire": {way: partial(_begun, partial(repertoire.teach, feat)) for way, feat in FEATS.items()},
    "servoing": {way: partial(_begun, partial(servoing.teach, method=way)) for way in topics("left")},
    "novices": {"as they are": _novice},
    "hierarchy": {way: partial(_piece, way) for way in (*hierarchy.SERVOING, *hierarchy.FORAGING)},
}
"""The experiments that teach lessons, and the ways in which they do, each from a seed. The others teach as `forage`,
`servoing` and `repertoire` do, or change for a purpose how lessons are taught."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per way and seed, and one for the RoboCup team's lessons if their folder is given."""
    if plan.data is not None:
        os.environ[FOLDER] = str(plan.data.resolve())  # the processes that work know no plan
    taught: list[Task] = [
        {"source": source, "way": way, "seed": seed}
        for source, ways in SOURCES.items()
        for way in ways
        for seed in plan.seeds
    ]
    return [*taught, {"source": ROBOCUP}] if plan.data is not None else taught


def work(task: Task) -> Row:
    """Teach the lessons of one way, or summarize the RoboCup team's lessons."""
    if task["source"] == ROBOCUP:
        return summary(Path(os.environ[FOLDER]))
    return {"lessons": SOURCES[task["source"]][task["way"]](task["seed"])}


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize the size of the lessons by source."""
    taught = {name: lessons(rows, name) for name in SOURCES}
    every = [lesson for of in taught.values() for lesson in of]
    team = next((row for row in rows if row["task"]["source"] == ROBOCUP), None)
    again = sum(lesson.get("begun", 1) > 1 for lesson in every)
    return StudyFindings(
        headline=_headline(every, team),
        tables=(
            ResultTable(
                "Size of the lessons: medians (smallest–largest)",
                ("", "#lessons", *(f"#{what}" for what in COUNTED)),
                [
                    *((name, *_told(of)) for name, of in taught.items()),
                    ("all of these", *_told(every)),
                    *([] if team is None else [(f"{ROBOCUP}'s", *_told_team(team))]),
                ],
            ),
            ResultTable(
                "Size of the lessons of each automaton",
                ("experiment", "variant", "automaton", *(f"#{what}" for what in COUNTED)),
                [(*kind, *_told(of)[1:]) for kind, of in kinds(rows).items()],
            ),
        ),
        notes=(
            "Examples are those made by presses, two per press. Nodes are those of one state's tree, for states that "
            "learned anything; a tree of one node belongs to a state that always leads to the same next state. Every "
            "automaton of every variant counts once per seed; one that two variants share counts once. "
            f"{again or 'None'} of the {len(every)} lessons {'was' if again in (0, 1) else 'were'} discarded and "
            "started again; that would count as teaching. " + _largest(kinds(rows)),
            "Not counted twice: the lessons of `learners` and of the reference variant of `ablation` are those of "
            "`forage`, `servoing` and `repertoire`. The other variants of `ablation` are left out.",
            "The lessons of the RoboCup team are stored elsewhere and read with --data; only counts of them are "
            "published. Their trees are learned here from their examples; the team's own learner made trees of "
            + ("the same median number of nodes." if team is None else _original(team)),
        ),
        numbers={"taught": {name: counts(of) for name, of in taught.items()}, "all": counts(every)},
    )


def lessons(rows: Sequence[Row], source: str) -> Lessons:
    """Return all lessons of a source (an experiment); a lesson that two of its variants share counts once."""
    of = [row for row in rows if row["task"]["source"] == source]
    distinct = {
        msgspec.json.encode((row["task"]["seed"], lesson)): lesson for row in of for lesson in row["lessons"]
    }
    return list(distinct.values())


def kinds(rows: Sequence[Row]) -> dict[tuple[str, str, str], Lessons]:
    """Group the lessons by source, way and automaton."""
    lessons_by_kind: dict[tuple[str, str, str], Lessons] = {}
    for row in rows:
        source = row["task"]["source"]
        for lesson in row["lessons"] if source != ROBOCUP else ():
            lessons_by_kind.setdefault((source, row["task"]["way"], lesson["name"]), []).append(lesson)
    return lessons_by_kind


COUNTED: Mapping[str, Callable[[Lessons], list[float]]] = {
    "features": lambda of: [lesson["features"] for lesson in of],
    "states": lambda of: [lesson["states"] for lesson in of],
    "examples": lambda of: [lesson["examples"] for lesson in of],
    "nodes": lambda of: [nodes for lesson in of for nodes in lesson["nodes"]],
    "teaching, s": lambda of: [lesson["seconds"] for lesson in of],
}
"""The counted quantities of lessons; nodes are counted for every tree."""


def counts(of: Lessons) -> dict[str, float]:
    """Return the medians of the counted quantities."""
    return {"lessons": len(of), **{what: float(np.median(count(of))) for what, count in COUNTED.items()}}


def _largest(lessons_by_kind: Mapping[tuple[str, str, str], Lessons]) -> str:
    """Return a sentence on the kind of lesson that takes most examples, compared with all others."""
    middle = {kind: float(np.median(COUNTED["examples"](of))) for kind, of in lessons_by_kind.items()}
    largest = max(middle, key=lambda kind: middle[kind])
    others = [n for kind, of in lessons_by_kind.items() if kind != largest for n in COUNTED["examples"](of)]
    return (
        f"Not every lesson is small: the lesson *{largest[2]}* of the experiment *{largest[0]}*, in its variant "
        f"*{largest[1]}*, takes {middle[largest]:.0f} examples in the median. None of the others takes more than "
        f"{max(others, default=0):.0f}, and nine in ten take at most {np.percentile(others or [0], 90):.0f}."
    )


def _told(of: Lessons) -> tuple[str, ...]:
    return (str(len(of)), *(format_median(count(of)) for count in COUNTED.values()))


def _told_team(team: Row) -> tuple[str, ...]:
    told_of = (
        f"{each['median']:.0f} ({each['min']:.0f}–{each['max']:.0f})"
        for each in (team["spread"][what] for what in ("features", "states", "examples", "nodes"))
    )
    return (str(team["lessons"]), *told_of, "not known")


def _original(team: Row) -> str:
    each = team["spread"]["original nodes"]
    return f"{each['median']:.0f} ({each['min']:.0f}–{each['max']:.0f}) nodes."


def _headline(every: Lessons, team: Row | None) -> str:
    medians = counts(every)
    beside = (
        ""
        if team is None
        else f" The {team['lessons']} lessons of a RoboCup team have medians of "
        f"{team['spread']['examples']['median']:.0f} examples, {team['spread']['features']['median']:.0f} features "
        f"and {team['spread']['nodes']['median']:.0f} nodes of a tree."
    )
    return (
        f"The medians over {len(every)} lessons are {medians['features']:.0f} features, "
        f"{medians['examples']:.0f} examples, trees of {medians['nodes']:.0f} nodes, and "
        f"{medians['teaching, s']:.0f} seconds of teaching. Nine in ten "
        f"lessons have at most {np.percentile(COUNTED['examples'](every), 90):.0f} examples.{beside}"
    )


def _draw(axes: Axes, rows: Rows, what: str) -> None:
    """Draw a counted quantity of every lesson by source."""
    groups = {name: COUNTED[what](lessons(rows, name)) for name in SOURCES}
    dots(axes, groups, {"nodes": "nodes of a tree"}.get(what, what))
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.tick_params(axis="x", labelsize=7.5)
    axes.set_title(what)


EXPERIMENT = Study(
    name="small",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=Panels([partial(_draw, what=what) for what in ("examples", "nodes", "teaching, s")]),
    worlds=("forage", "soccer"),
)
