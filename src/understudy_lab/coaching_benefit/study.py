"""The experiment: the same simulated novices alone, with the coach, and live, in two tasks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.analysis.intervals import interval_of_share
from understudy_lab.coaching_benefit.coached_teaching import ALONE, COACHED, STEPS, teach
from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.figures import COLORS, panels
from understudy_lab.novices.traits import SUCCESS, draw_traits
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(62_100, 62_140)
WAYS = (ALONE, COACHED, LIVE)
WANTED, FEWER, OVERALL = 0.9, 0.6, 0.95
FEWER_LIVE = 0.5


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per novice, exercise, and way (alone, coached or live)."""
    return [
        {"exercise": name, "way": way, "seed": seed}
        for name in EXERCISES
        for way in WAYS
        for seed in plan.seeds
    ]


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


def select_rows(rows: Sequence[Row], exercise: str, way: str) -> list[Row]:
    """Return the rows of one exercise taught in one way."""
    return [row for row in rows if (row["task"]["exercise"], row["task"]["way"]) == (exercise, way)]


def means(rows: Sequence[Row]) -> list[float]:
    """Return the mean share of successful trials over all robots, by STEPS."""
    return [float(np.mean(shares)) for shares in zip(*(row["by_step"] for row in rows), strict=True)]


def count_examples_needed(rows: Sequence[Row]) -> int | None:
    """Return the number of examples from which on 90 % of all trials succeed, or None if there is none."""
    good = [mean >= WANTED for mean in means(rows)]
    return next((step for at, step in enumerate(STEPS) if all(good[at:])), None)


def succeeds(row: Row) -> bool:
    """Return whether the final robot succeeds in at least half of its trials."""
    return bool(row["share"] >= SUCCESS)


def succeeds_nearly_always(row: Row) -> bool:
    """Return whether the final robot succeeds in at least 90 % of its trials."""
    return bool(row["share"] >= WANTED)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize success, the examples needed, and the advice that was followed."""
    found = {(name, way): select_rows(rows, name, way) for name in EXERCISES for way in WAYS}
    numbers: dict[str, Any] = {
        f"{name}, {way}": {
            "novices": len(each),
            "succeed": sum(map(succeeds, each)),
            "everywhere": sum(row["everywhere"] for row in each),
            "nearly always": sum(map(succeeds_nearly_always, each)),
            "enough": count_examples_needed(each),
        }
        for (name, way), each in found.items()
    }
    return StudyFindings(
        headline=" ".join(_headline(name, *(found[name, way] for way in WAYS)) for name in EXERCISES),
        tables=(
            ResultTable(
                "Results after five minutes: medians (smallest–largest)",
                (
                    "task",
                    "novices",
                    "#succeed",
                    "#succeed in each kind of trial",
                    "#succeed in 90 % of trials",
                    "#trials that succeed",
                    "#examples",
                ),
                [(name, way, *_end(each)) for (name, way), each in found.items()],
            ),
            ResultTable(
                "Share of successful trials by number of examples, all novices",
                ("task", "novices", *(f"#{step}" for step in STEPS)),
                [
                    (name, way, *(f"{mean:.0%}" for mean in means(each)))
                    for (name, way), each in found.items()
                ],
            ),
        ),
        goals=tuple(
            goal
            for name in EXERCISES
            for goal in (
                *_goals(name, found[name, ALONE], found[name, COACHED]),
                *_live_goals(name, found[name, ALONE], found[name, LIVE]),
            )
        ),
        notes=(
            *(_sooner(name, found[name, ALONE], found[name, COACHED]) for name in EXERCISES),
            _followed([row for row in rows if row["task"]["way"] == COACHED]),
            *(_presses(name, found[name, LIVE]) for name in EXERCISES),
            "Examples are those made by presses (two per press), including those deleted later.",
        ),
        numbers=numbers,
    )


def _headline(name: str, alone: Sequence[Row], coached: Sequence[Row], live: Sequence[Row]) -> str:
    return (
        f"At {name}, {sum(map(succeeds, coached))} of {len(coached)} novices who follow the coach succeed, and "
        f"{sum(map(succeeds, alone))} of {len(alone)} novices without it. 90 % of trials succeed: with the "
        f"coach, {_after(coached)}; without it, {_after(alone)}. Taught live, {sum(map(succeeds, live))} of "
        f"{len(live)} succeed, and {sum(map(succeeds_nearly_always, live))} in 90 % of trials."
    )


def _after(rows: Sequence[Row]) -> str:
    step = count_examples_needed(rows)
    return f"never within {STEPS[-1]} examples" if step is None else f"after {step} examples"


def _end(rows: Sequence[Row]) -> tuple[str, ...]:
    good = sum(map(succeeds, rows))
    low, high = interval_of_share(good, len(rows))
    return (
        f"{good} of {len(rows)} ({100 * low:.0f}–{100 * high:.0f} %)",
        str(sum(row["everywhere"] for row in rows)),
        str(sum(map(succeeds_nearly_always, rows))),
        format_median([row["share"] for row in rows], percent=True),
        format_median([row["examples"] for row in rows]),
    )


def _goals(name: str, alone: Sequence[Row], coached: Sequence[Row]) -> tuple[StudyGoal, StudyGoal]:
    with_it, without = count_examples_needed(coached), count_examples_needed(alone)
    fewer = with_it is not None and (without is None or with_it <= FEWER * without)
    share = sum(map(succeeds, coached)) / len(coached)
    return (
        StudyGoal(
            f"{name}: examples until 90 % of trials succeed, of those who do not follow it",
            f"at most {FEWER:.0%}",
            f"{_after(coached)}; alone {_after(alone)}",
            fewer,
        ),
        StudyGoal(f"{name}: novices who succeed with it", f"{OVERALL:.0%}", f"{share:.0%}", share >= OVERALL),
    )


def _live_goals(name: str, alone: Sequence[Row], live: Sequence[Row]) -> tuple[StudyGoal, StudyGoal]:
    well = sum(map(succeeds_nearly_always, live)) / len(live)
    share = float(
        np.median([row["examples"] for row in live]) / np.median([row["examples"] for row in alone])
    )
    return (
        StudyGoal(
            f"{name}, taught live: robots that succeed in 90 % of trials",
            f"{OVERALL:.0%}",
            f"{well:.0%}",
            well >= OVERALL,
        ),
        StudyGoal(
            f"{name}, taught live: examples, relative to novices alone",
            f"at most {FEWER_LIVE}",
            f"{share:.2f}",
            share <= FEWER_LIVE,
        ),
    )


def _sooner(name: str, alone: Sequence[Row], coached: Sequence[Row]) -> str:
    """Return a sentence on when coached novices reach the best result of the others."""
    best = max(means(alone))
    step = next((step for step, mean in zip(STEPS, means(coached), strict=True) if mean >= best), None)
    after = "never" if step is None else f"after {step} examples"
    return f"At {name}, novices alone never exceed {best:.0%} of trials; coached novices reach that {after}."


def _presses(name: str, live: Sequence[Row]) -> str:
    return f"At {name}, novices who teach live press {format_median([row['presses'] for row in live])} times."


def _followed(rows: Sequence[Row]) -> str:
    counts: dict[str, int] = {}
    for row in rows:
        for kind, count in row["followed"].items():
            counts[kind] = counts.get(kind, 0) + count
    said = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items(), key=lambda each: -each[1]))
    return (
        "How often coached novices followed advice, by kind (asked: answered a question; corrected: corrected the "
        f"robot on their own): {said}."
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success over the number of examples."""
    figure, axes = panels(len(EXERCISES), wide=4.0)
    for panel, name in zip(axes, EXERCISES, strict=True):
        for way, color in zip(WAYS, COLORS, strict=False):
            panel.plot(STEPS, means(select_rows(rows, name, way)), "o-", color=color, markersize=3, label=way)
        panel.axhline(WANTED, color="#6b7280", linewidth=1, linestyle=":")
        panel.set_ylim(0.0, 1.03)
        panel.set_xlabel("examples")
        panel.set_ylabel("trials that succeed")
        panel.set_title(name)
        panel.legend(fontsize=7.5)
    return figure


EXPERIMENT = Study(
    name="coached",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("soccer", "forage"),
)
