"""The experiment: every lesson of the other experiments taught afresh, and what there is to count in it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from understudy.experiments.experiment import Experiment, Findings, Plan, Row, Table, Task
from understudy.experiments.figures import dots, panels
from understudy.experiments.forage.teaching import teach as teach_foraging
from understudy.experiments.lessons import lessons_of
from understudy.experiments.repertoire.run import FEATS
from understudy.experiments.repertoire.teaching import teach as teach_feat
from understudy.experiments.servoing.trials import teach as teach_servoing
from understudy.experiments.small.robocup import summary
from understudy.experiments.statistics import told
from understudy.training.demonstrators.servo import topics

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(57_000, 57_005)
ROBOCUP = "RoboCup team"
FOLDER = "UNDERSTUDY_ROBOCUP_LESSONS"
"""The variable that names the folder of the RoboCup team's lessons; set from the command line's --data."""

Lessons: TypeAlias = list[dict[str, Any]]


def foraging(seed: int) -> Lessons:
    """GoTo, Harvest, Deposit, Forage."""
    return lessons_of(teach_foraging(seed))


def servoing(seed: int) -> Lessons:
    """Approaching the ball, in each of the ways it is taught."""
    return [lesson for way in topics("left") for lesson in lessons_of(teach_servoing(seed, way))]


def repertoire(seed: int) -> Lessons:
    """The automata of every behavior of the repertoire."""
    return [lesson for feat in FEATS.values() for lesson in lessons_of(teach_feat(feat, seed))]


SOURCES: Mapping[str, Callable[[int], Lessons]] = {
    "foraging": foraging,
    "servoing": servoing,
    "repertoire": repertoire,
}
"""Where lessons come from: experiments that teach some, from a seed."""


def tasks(plan: Plan) -> list[Task]:
    """Each source with each seed; and the RoboCup team's lessons where there are any at hand."""
    if plan.data is not None:
        os.environ[FOLDER] = str(plan.data.resolve())  # the processes that work know no plan
    taught: list[Task] = [{"source": source, "seed": seed} for source in SOURCES for seed in plan.seeds]
    return [*taught, {"source": ROBOCUP}] if plan.data is not None else taught


def work(task: Task) -> Row:
    """The lessons of a source; of the RoboCup team's in summary only."""
    if task["source"] == ROBOCUP:
        return summary(Path(os.environ[FOLDER]))
    return {"lessons": SOURCES[task["source"]](task["seed"])}


def conclude(rows: Sequence[Row]) -> Findings:
    """How small the lessons are, by source."""
    taught = {name: lessons(rows, name) for name in SOURCES}
    every = [lesson for of in taught.values() for lesson in of]
    team = next((row for row in rows if row["task"]["source"] == ROBOCUP), None)
    kinds = dict.fromkeys(lesson["name"] for lesson in every)
    return Findings(
        headline=_headline(every, team),
        tables=(
            Table(
                "Lessons: medians with smallest and largest",
                ("", "#lessons", *(f"#{what}" for what in COUNTED)),
                [
                    *((name, *_told(of)) for name, of in taught.items()),
                    ("all of these", *_told(every)),
                    *([] if team is None else [(f"{ROBOCUP}'s", *_told_team(team))]),
                ],
            ),
            Table(
                "By automaton",
                ("", "#lessons", *(f"#{what}" for what in COUNTED)),
                [(name, *_told([each for each in every if each["name"] == name])) for name in kinds],
            ),
        ),
        notes=(
            "Examples are press-made: two a press. Nodes are those of the tree of one state, of the states that "
            "learned anything; a tree of one node is a state that is always left for the same one.",
            "The RoboCup team's lessons are kept elsewhere and given with --data; what is published of them is counts. "
            "Their trees are learned here from their examples; their own learner had "
            + ("as many nodes in the median." if team is None else _original(team)),
        ),
        numbers={"taught": {name: counts(of) for name, of in taught.items()}},
    )


def lessons(rows: Sequence[Row], source: str) -> Lessons:
    """All lessons of a source."""
    return [lesson for row in rows if row["task"]["source"] == source for lesson in row["lessons"]]


COUNTED: Mapping[str, Callable[[Lessons], list[float]]] = {
    "features": lambda of: [lesson["features"] for lesson in of],
    "states": lambda of: [lesson["states"] for lesson in of],
    "examples": lambda of: [lesson["examples"] for lesson in of],
    "nodes": lambda of: [nodes for lesson in of for nodes in lesson["nodes"]],
    "teaching, s": lambda of: [lesson["seconds"] for lesson in of],
}
"""What is counted of lessons; nodes of every tree in them."""


def counts(of: Lessons) -> dict[str, float]:
    """Medians of what is counted."""
    return {"lessons": len(of), **{what: float(np.median(count(of))) for what, count in COUNTED.items()}}


def _told(of: Lessons) -> tuple[str, ...]:
    return (str(len(of)), *(told(count(of)) for count in COUNTED.values()))


def _told_team(team: Row) -> tuple[str, ...]:
    told_of = (
        f"{each['median']:.0f} ({each['min']:.0f}–{each['max']:.0f})"
        for each in (team["spread"][what] for what in ("features", "states", "examples", "nodes"))
    )
    return (str(team["lessons"]), *told_of, "not known")


def _original(team: Row) -> str:
    each = team["spread"]["original nodes"]
    return f"{each['median']:.0f} ({each['min']:.0f}–{each['max']:.0f})."


def _headline(every: Lessons, team: Row | None) -> str:
    found = counts(every)
    beside = (
        ""
        if team is None
        else f" The {team['lessons']} lessons of a RoboCup team had {team['spread']['examples']['median']:.0f} "
        f"examples and {team['spread']['features']['median']:.0f} features in the median, trees of "
        f"{team['spread']['nodes']['median']:.0f}."
    )
    return (
        f"A lesson is small: {found['features']:.0f} features, {found['examples']:.0f} examples, trees of "
        f"{found['nodes']:.0f} nodes, {found['teaching, s']:.0f} seconds in the median of {len(every)}.{beside}"
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Every lesson a dot: examples, nodes and seconds by source."""
    figure, axes = panels(3, wide=2.7)
    for panel, what in zip(axes, ("examples", "nodes", "teaching, s"), strict=True):
        groups = {name: COUNTED[what](lessons(rows, name)) for name in SOURCES}
        dots(panel, groups, {"nodes": "nodes of a tree"}.get(what, what))
        panel.set_ylim(bottom=0)
        panel.set_title(what)
    return figure


EXPERIMENT = Experiment(
    name="small",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage", "soccer"),
)
