"""The experiment: teachers who press wrong buttons and press late, corrected with and without unlearning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.figures import COLORS, panels
from understudy_lab.noisy_teachers.teach import (
    ASKED,
    CLEAN,
    IN_A_ROW,
    MOST,
    PLAIN,
    TASKS,
    UNHURRIED,
    WAYS,
    teach,
)
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(63_000, 63_080)
CHANCES = (0.05, 0.1, 0.2)
SHORT = 0.05
"""The largest gap to a teacher without faults that counts as equally good."""
WANTED = 0.5


def tasks(plan: StudyPlan) -> list[Task]:
    """Return the work to do: one teaching for each behavior, share of wrong presses, way of correcting, and seed."""
    kinds = [(CLEAN, 0.0), *((way, chance) for chance in CHANCES for way in WAYS)]
    return [
        {"task": name, "way": way, "chance": chance, "seed": seed}
        for name in TASKS
        for way, chance in kinds
        for seed in plan.seeds
    ]


def work(task: Task) -> Row:
    """Run one teaching and return the share of successful trials after each correction."""
    name, seed = task["task"], task["seed"]
    course = teach(name, task["way"], seed, task["chance"])
    shares = [EXERCISES[name].judge(taught, seed)[0] for taught in course.taught]
    return {
        "shares": [round(share, 4) for share in shares],
        "corrections": course.corrections,
        "slipped": course.slipped,
        "asked": course.asked,
        "held": course.held,
    }


def select_rows(rows: Sequence[Row], name: str, way: str, chance: float) -> list[Row]:
    """Return the rows of one task, way and chance of a slip; teachers without faults have no chance."""
    wanted = name, way, 0.0 if way == CLEAN else chance
    return [row for row in rows if tuple(row["task"][key] for key in ("task", "way", "chance")) == wanted]


def means(rows: Sequence[Row]) -> list[float]:
    """Return the mean share of successful trials after 0, 1, ... corrections."""
    padded = [row["shares"] + [row["shares"][-1]] * (MOST + 1 - len(row["shares"])) for row in rows]
    return [float(np.mean(shares)) for shares in zip(*(each[: MOST + 1] for each in padded), strict=True)]


def count_corrections_needed(rows: Sequence[Row], clean: Sequence[Row]) -> int | None:
    """Return the corrections after which robots are, and stay, as good as those of teachers without faults."""
    good = [mean >= means(clean)[-1] - SHORT for mean in means(rows)]
    return next((count for count in range(len(good)) if all(good[count:])), None)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize the corrections, questions and quarantined examples of each way."""
    found = {
        (name, way, chance): select_rows(rows, name, way, chance)
        for name in TASKS
        for chance in CHANCES
        for way in (CLEAN, *WAYS)
    }
    numbers: dict[str, Any] = {
        f"{name}, {chance:.0%}, {way}": {
            "needed": count_corrections_needed(each, found[name, CLEAN, chance]),
            "end": round(means(each)[-1], 3),
        }
        for (name, way, chance), each in found.items()
    }
    return StudyFindings(
        headline=" ".join(_headline(found, "goto", chance) for chance in CHANCES[:2]),
        tables=(
            ResultTable(
                "Share of successful trials by number of corrections; corrections until a robot is as good as without "
                f"faults; and totals until {IN_A_ROW} tries in a row needed no correction, medians (smallest–largest)",
                (
                    "task",
                    "slips",
                    "way",
                    *(f"#{count}" for count in (0, 2, 4, 8, 16, MOST)),
                    "#as good after",
                    "#corrections",
                    "#questions",
                    "#quarantined",
                ),
                [
                    row
                    for name in TASKS
                    for row in (
                        _row(found, name, CLEAN, 0.0),
                        *(_row(found, name, way, chance) for chance in CHANCES for way in WAYS),
                    )
                ],
            ),
        ),
        goals=tuple(_goal(found, chance, way) for way in (ASKED, UNHURRIED) for chance in CHANCES),
        notes=_notes(found),
        numbers=numbers,
    )


Found = dict[tuple[str, str, float], list[Row]]


def _row(found: Found, name: str, way: str, chance: float) -> tuple[str, ...]:
    rows = found[name, way, chance or CHANCES[0]]
    mean, enough = means(rows), count_corrections_needed(rows, found[name, CLEAN, CHANCES[0]])
    return (
        name,
        f"{chance:.0%}",
        way,
        *(f"{mean[count]:.0%}" for count in (0, 2, 4, 8, 16, MOST)),
        "never" if enough is None else str(enough),
        *(format_median([row[key] for row in rows]) for key in ("corrections", "asked", "held")),
    )


def _said(count: int | None) -> str:
    if count is None:
        return f"not within {MOST} corrections"
    return f"after {count} correction{'s' * (count != 1)}"


def _headline(found: Found, name: str, chance: float) -> str:
    clean = found[name, CLEAN, chance]
    asked, plain = (count_corrections_needed(found[name, way, chance], clean) for way in (ASKED, PLAIN))
    return (
        f"Teachers of {name} who press late, and press a wrong button in {chance:.0%} of presses, come within "
        f"{100 * SHORT:.0f} points of a teacher without faults {_said(asked)} if they are asked about odd presses, and "
        f"{_said(plain)} if not."
    )


def _goal(found: Found, chance: float, way: str) -> StudyGoal:
    clean = found["goto", CLEAN, chance]
    asked, plain = (count_corrections_needed(found["goto", each, chance], clean) for each in (way, PLAIN))
    return StudyGoal(
        f"goto, {chance:.0%} slips, {way}: corrections until robots are as good as those of a teacher without faults",
        f"at most {WANTED:.0%} of those without unlearning",
        f"{_said(asked)}; without {_said(plain)}",
        asked is not None and asked <= WANTED * (MOST + 1 if plain is None else plain),
    )


def _notes(found: Found) -> tuple[str, ...]:
    ends = [means(found["servoing", way, chance])[0] for way in (PLAIN, ASKED) for chance in CHANCES]
    return (
        "Servoing needs hardly any corrections: before the first correction, robots succeed in "
        f"{100 * min(ends):.0f} to {100 * max(ends):.0f} % of trials, with any of these faults.",
        "Unlearning without questions saves few corrections here, if any: where presses of one kind are rare, it "
        "quarantines good ones, too. It is meant for demonstrators who cannot be asked.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the success of GoTo over the number of corrections."""
    figure, axes = panels(len(CHANCES), wide=3.2)
    for panel, chance in zip(axes, CHANCES, strict=True):
        for way, color in zip((CLEAN, *WAYS), ("#6b7280", *COLORS), strict=False):
            mean = means(select_rows(rows, "goto", way, chance))
            panel.plot(range(MOST + 1), mean, "-", color=color, linewidth=1.4, label=way)
        panel.set_ylim(0.0, 1.03)
        panel.set_xlabel("corrections")
        panel.set_ylabel("trials that succeed")
        panel.set_title(f"goto, {chance:.0%} slips")
        panel.legend(fontsize=7)
    return figure


EXPERIMENT = Study(
    name="slips",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage", "soccer"),
)
