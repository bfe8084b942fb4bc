"""The experiment: the same simulated novices alone, with the coach, and live, in two tasks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from understudy_lab.coaching_benefit.tasks import ALONE, COACHED, EXERCISES, STEPS, teach
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, Units
from understudy_lab.figures import COLORS, Panels
from understudy_lab.novices.novice import SUCCESS, draw_traits
from understudy_lab.rows import Count, Median, Rows
from understudy_lab.study import Row, Study, StudyGoal, Task
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(62_100, 62_140)
WAYS = (ALONE, COACHED, LIVE)
WANTED, FEWER, OVERALL = 0.9, 0.6, 0.95
FEWER_LIVE = 0.5


def work(task: Task) -> Row:
    """Let one novice teach for five minutes, and test the automaton after each number of examples and at the end."""
    exercise, seed = EXERCISES[task["exercise"]], task["seed"]
    novice = exercise.person(draw_traits(seed), seed)
    course = teach(novice, exercise, task["way"])
    judged = {id(taught): exercise.judge(taught, seed) for taught in course.by_step.values()}
    whole = exercise.judge(course.session.make_trained_automaton(), seed)
    steps = [judged[id(course.by_step[step])][0] if step in course.by_step else 0.0 for step in STEPS]
    return {
        "share": round(whole[0], 4),
        "everywhere": bool(whole[1]),
        "by_step": [round(share, 4) for share in steps],
        "examples": course.made,
        **({"presses": novice.presses} if task["way"] == LIVE else {}),
        "followed": dict(sorted(course.followed_kinds.items())),
    }


def means(rows: Sequence[Row]) -> list[float]:
    """Return the mean share of successful trials over all robots, by STEPS."""
    return [float(np.mean(shares)) for shares in zip(*(row["by_step"] for row in rows), strict=True)]


def count_examples_needed(rows: Sequence[Row]) -> int | None:
    """Return the number of examples from which on 90 % of all trials succeed, or None if there is none."""
    good = [mean >= WANTED for mean in means(rows)]
    return next((step for at, step in enumerate(STEPS) if all(good[at:])), None)


SUCCEED = Count(lambda row: row["share"] >= SUCCESS, interval=True)
SUCCEED_NEARLY_ALWAYS = Count(lambda row: row["share"] >= WANTED)
SUCCEED_EVERYWHERE = Count(lambda row: row["everywhere"])


def _group(rows: Rows) -> dict[tuple[str, str], Rows]:
    return {(name, way): rows.where(exercise=name, way=way) for name in EXERCISES for way in WAYS}


def _headline(rows: Rows) -> str:
    groups = _group(rows)
    return " ".join(_describe(name, *(groups[name, way] for way in WAYS)) for name in EXERCISES)


def _describe(name: str, alone: Rows, coached: Rows, live: Rows) -> str:
    return (
        f"At {name}, {SUCCEED.number(coached)} of {len(coached)} novices who follow the coach succeed, and "
        f"{SUCCEED.number(alone)} of {len(alone)} novices without it. 90 % of trials succeed: with the "
        f"coach, {_after(coached)}; without it, {_after(alone)}. Taught live, {SUCCEED.number(live)} of "
        f"{len(live)} succeed, and {SUCCEED_NEARLY_ALWAYS.number(live)} in 90 % of trials."
    )


def _after(rows: Rows) -> str:
    step = count_examples_needed(rows)
    return f"never within {STEPS[-1]} examples" if step is None else f"after {step} examples"


def _goals_of(name: str) -> tuple[Callable[[Rows], StudyGoal], ...]:
    """Return the goals of an exercise."""
    alone, coached, live = ({"exercise": name, "way": way} for way in WAYS)

    def compare_examples(rows: Rows) -> float:
        """Return the examples until 90 % of trials succeed, relative to novices alone."""
        needed, without = (count_examples_needed(rows.where(**each)) for each in (coached, alone))
        return inf if needed is None else 0.0 if without is None else needed / without

    return (
        Goal(
            f"{name}: examples until 90 % of trials succeed, of those who do not follow it",
            compare_examples,
            most=FEWER,
            measured=lambda rows: f"{_after(rows.where(**coached))}; alone {_after(rows.where(**alone))}",
        ),
        Goal(
            f"{name}: novices who succeed with it",
            lambda rows: SUCCEED.share(rows.where(**coached)),
            least=OVERALL,
        ),
        Goal(
            f"{name}, taught live: robots that succeed in 90 % of trials",
            lambda rows: SUCCEED_NEARLY_ALWAYS.share(rows.where(**live)),
            least=OVERALL,
        ),
        Goal(
            f"{name}, taught live: examples, relative to novices alone",
            lambda rows: rows.where(**live).median("examples") / rows.where(**alone).median("examples"),
            ".2f",
            most=FEWER_LIVE,
            wanted=f"at most {FEWER_LIVE}",
        ),
    )


def _notes(rows: Rows) -> list[str]:
    groups = _group(rows)
    counts = Counter[str]()
    for row in rows.where(way=COACHED):
        counts.update(row["followed"])
    listed = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items(), key=lambda each: -each[1]))
    return [
        *(_sooner(name, groups[name, ALONE], groups[name, COACHED]) for name in EXERCISES),
        "How often coached novices followed advice, by kind (asked: answered a question; corrected: corrected the "
        f"robot on their own): {listed}.",
        *(
            f"At {name}, novices who teach live press {Median('presses')(groups[name, LIVE])} times."
            for name in EXERCISES
        ),
        "Examples are those made by presses (two per press), including those deleted later.",
    ]


def _sooner(name: str, alone: Rows, coached: Rows) -> str:
    """Return a sentence on when coached novices reach the best result of the others."""
    best = max(means(alone))
    step = next((step for step, mean in zip(STEPS, means(coached), strict=True) if mean >= best), None)
    after = "never" if step is None else f"after {step} examples"
    return f"At {name}, novices alone never exceed {best:.0%} of trials; coached novices reach that {after}."


def _draw(axes: Axes, rows: Rows, name: str) -> None:
    """Draw success over the number of examples."""
    for way, color in zip(WAYS, COLORS, strict=False):
        axes.plot(
            STEPS, means(rows.where(exercise=name, way=way)), "o-", color=color, markersize=3, label=way
        )
    axes.axhline(WANTED, color="#6b7280", linewidth=1, linestyle=":")
    axes.set_ylim(0.0, 1.03)
    axes.set_xlabel("examples")
    axes.set_ylabel("trials that succeed")
    axes.set_title(name)
    axes.legend(fontsize=7.5)


EXPERIMENT = Study(
    name="coached",
    seeds=SEEDS,
    quick=1,
    tasks=Units({"exercise": EXERCISES, "way": WAYS}),
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            LinePerGroup(
                "Results after five minutes: medians (smallest–largest)",
                ["task", "novices"],
                _group,
                {
                    "succeed": SUCCEED,
                    "succeed in each kind of trial": lambda rows: str(SUCCEED_EVERYWHERE.number(rows)),
                    "succeed in 90 % of trials": lambda rows: str(SUCCEED_NEARLY_ALWAYS.number(rows)),
                    "trials that succeed": Median("share", percent=True),
                    "examples": Median("examples"),
                },
                tuple,
            ),
            LinePerGroup(
                "Share of successful trials by number of examples, all novices",
                ["task", "novices"],
                _group,
                {str(step): lambda rows, at=at: f"{means(rows)[at]:.0%}" for at, step in enumerate(STEPS)},
                tuple,
            ),
        ),
        goals=[goal for name in EXERCISES for goal in _goals_of(name)],
        notes=_notes,
        numbers=lambda rows: {
            f"{name}, {way}": {
                "novices": len(each),
                "succeed": SUCCEED.number(each),
                "everywhere": SUCCEED_EVERYWHERE.number(each),
                "nearly always": SUCCEED_NEARLY_ALWAYS.number(each),
                "enough": count_examples_needed(each),
            }
            for (name, way), each in _group(rows).items()
        },
    ),
    draw=Panels([partial(_draw, name=name) for name in EXERCISES], wide=4.0),
    worlds=("soccer", "forage"),
)
