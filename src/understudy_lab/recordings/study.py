"""The experiment: simulated hands drive with a stick, and robots learn the same behaviors from the recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from understudy.model.library import Library
from understudy_lab.figures import dots, panels
from understudy_lab.recordings import driven_foraging, driven_goto, driven_servoing, driven_walls
from understudy_lab.recordings.driven_lesson import DrivenLesson
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class DrivenBehavior:
    """A behavior of the experiment.

    Parameters
    ----------
    title
        Name of the behavior for people.
    first_seed
        How much its first seed is above that of the experiment, so that no two behaviors share a hand.
    learn
        Function that drives with the hand of a seed, and learns from the recordings.
    teach
        Function that teaches the same by presses.
    measure
        Function that returns the share of unseen worlds of a seed in which a learned library succeeds.
    measure_pressed
        The same for what was taught by presses.
    """

    title: str
    first_seed: int
    learn: Callable[[int], DrivenLesson]
    teach: Callable[[int], Library]
    measure: Callable[[Library, int], float]
    measure_pressed: Callable[[Library, int], float]


GOTO, WALLS, SERVOING, FORAGING = "goto", "walls", "servoing", "foraging"
BEHAVIORS: Mapping[str, DrivenBehavior] = MappingProxyType(
    {
        GOTO: DrivenBehavior(
            "GoTo",
            0,
            driven_goto.learn_from_drives,
            driven_goto.teach_by_presses,
            driven_goto.measure_success,
            driven_goto.measure_pressed_success,
        ),
        WALLS: DrivenBehavior(
            "wall following",
            80,
            driven_walls.learn_walls_from_drives,
            driven_walls.teach_walls_by_presses,
            driven_walls.measure_wall_success,
            driven_walls.measure_wall_success,
        ),
        SERVOING: DrivenBehavior(
            "servoing",
            180,
            driven_servoing.learn_servoing_from_drives,
            driven_servoing.teach_servoing_by_presses,
            driven_servoing.measure_servoing_success,
            driven_servoing.measure_servoing_success,
        ),
        FORAGING: DrivenBehavior(
            "foraging",
            280,
            driven_foraging.learn_foraging_from_drives,
            driven_foraging.teach_foraging_by_presses,
            driven_foraging.measure_foraging_success,
            driven_foraging.measure_foraging_success,
        ),
    }
)
"""The behaviors in the order in which they are told."""

SEEDS = range(16_420, 16_440)
"""The seeds of the hands and worlds of GoTo; those of other behaviors lie above. Tuning used seeds 0 to 19."""
WORLDS = 100
TICKS, SWITCHES, APART = 0.95, 0.9, 0.05
REACHED, REACHING = 0.95, 0.85
"""The success that a robot which learned to forage reaches, and the share of hands of which it is asked."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per behavior and hand."""
    return [
        {"behavior": name, "seed": seed + each.first_seed}
        for name, each in BEHAVIORS.items()
        for seed in plan.seeds
    ]


def work(task: Task) -> Row:
    """Drive with one hand, learn from the recordings, teach the same by presses, and test both in the same worlds."""
    behavior, seed = BEHAVIORS[task["behavior"]], task["seed"]
    driven = behavior.learn(seed)
    scores = driven.hits.score()
    return {
        "ticks": round(scores.ticks, 4),
        "answered": round(scores.answered, 4),
        "switches": round(scores.switches, 4),
        "driven": behavior.measure(driven.library, seed),
        "pressed": behavior.measure_pressed(behavior.teach(seed), seed),
    }


MEASURES = {
    "ticks as the driver meant": "ticks",
    "ticks as the hand answered": "answered",
    "switches within 0.3 s": "switches",
    "success, learned from recordings": "driven",
    "success, taught by presses": "pressed",
}


def select_rows(rows: Sequence[Row], behavior: str) -> list[Row]:
    """Return the rows of a behavior."""
    return [row for row in rows if row["task"]["behavior"] == behavior]


def count_near(rows: Sequence[Row]) -> int:
    """Count the hands whose success is within 5 points of that by presses."""
    return sum(row["pressed"] - row["driven"] <= APART + 1e-9 for row in rows)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize all hands by behavior."""
    found = {name: select_rows(rows, name) for name in BEHAVIORS}
    hands = {name: f"{count_near(mine)} of {len(mine)}" for name, mine in found.items()}
    told = "; ".join(
        f"for {BEHAVIORS[name].title} {_take_median(mine, 'ticks'):.1%} of the ticks and "
        f"{_take_median(mine, 'switches'):.1%} of the switches, and {hands[name]} hands"
        for name, mine in found.items()
    )
    return StudyFindings(
        headline="From drives with a stick, without a press, behaviors are recognized and learned. Recognized in the "
        f"median, and hands from whose drives a robot learns to succeed within {100 * APART:.0f} points of presses: "
        f"{told}.",
        tables=tuple(_make_table(name, mine) for name, mine in found.items()),
        goals=tuple(goal for name, mine in found.items() for goal in _make_goals(name, mine)),
        notes=(
            "The hand answers to what the driver means 0 to 0.2 s later, so each switch costs as many ticks.",
        ),
        numbers={
            name: {key: round(_take_median(mine, key), 4) for key in MEASURES.values()}
            for name, mine in found.items()
        },
    )


def _take_median(rows: Sequence[Row], key: str) -> float:
    return float(np.median([row[key] for row in rows]))


def _make_table(name: str, rows: Sequence[Row]) -> ResultTable:
    first, last = rows[0]["task"]["seed"], rows[-1]["task"]["seed"]
    return ResultTable(
        f"{BEHAVIORS[name].title} from drives, % of ticks, switches and {WORLDS} unseen worlds "
        f"(seeds {first} to {last})",
        ("", "#median [smallest, largest]"),
        [(what, format_median([100 * row[key] for row in rows], 1)) for what, key in MEASURES.items()],
    )


def _make_goals(name: str, rows: Sequence[Row]) -> tuple[StudyGoal, ...]:
    title, near = BEHAVIORS[name].title, count_near(rows)
    reached, asked = sum(row["driven"] >= REACHED for row in rows), ceil(REACHING * len(rows))
    ticks, switches = _take_median(rows, "ticks"), _take_median(rows, "switches")
    return (
        StudyGoal(
            f"{title}: ticks as the driver meant, median", f"{TICKS:.0%}", f"{ticks:.1%}", ticks >= TICKS
        ),
        StudyGoal(
            f"{title}: switches within 0.3 s, median",
            f"{SWITCHES:.0%}",
            f"{switches:.1%}",
            switches >= SWITCHES,
        ),
        StudyGoal(
            f"{title}: hands whose success is within {100 * APART:.0f} points of that by presses",
            f"{len(rows)} of {len(rows)}",
            f"{near} of {len(rows)}",
            near == len(rows),
        ),
        StudyGoal(
            f"{title}: hands whose success is at least {REACHED:.0%}",
            f"{asked} of {len(rows)}",
            f"{reached} of {len(rows)}",
            reached >= asked,
        ),
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the shares of ticks and switches, and the success, of each hand by behavior."""
    figure, axes = panels(2 * len(BEHAVIORS), rows=2, wide=3.3, tall=2.6)
    labels = {
        "ticks": "ticks\nas meant",
        "answered": "ticks\nas answered",
        "switches": "switches\nwithin 0.3 s",
    }
    success = {"driven": "from\nrecordings", "pressed": "by presses"}
    count = len(BEHAVIORS)
    for name, above, below in zip(BEHAVIORS, axes[:count], axes[count:], strict=True):
        mine = select_rows(rows, name)
        dots(above, {what: [100 * row[key] for row in mine] for key, what in labels.items()}, "% right")
        above.set_title(f"Labels, {BEHAVIORS[name].title}")
        shares = {what: [100 * row[key] for row in mine] for key, what in success.items()}
        dots(below, shares, "% of worlds")
        below.set_ylim(min(90.0, *(min(each) for each in shares.values())) - 4.0, 102.0)
        below.set_title(f"Success, {BEHAVIORS[name].title}")
    return figure


EXPERIMENT = Study(
    name="recordings", seeds=SEEDS, quick=2, tasks=tasks, work=work, conclude=conclude, draw=draw
)
