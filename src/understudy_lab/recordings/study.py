"""The experiment: simulated hands drive with a stick, and robots learn the same behaviors from the recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Any

from understudy.model.library import Library
from understudy_lab.behavior_suite.task import teach
from understudy_lab.declaration import ColumnPerGroup, Conclusion, CountGoal, Goal, goals_among
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.forage import teach as forage
from understudy_lab.recordings import driven_foraging, driven_goto, driven_servoing, driven_walls
from understudy_lab.recordings.drive_recording import DrivenLesson
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.servoing import trials as servoing
from understudy_lab.study import Row, Study, StudyPlan, Task


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
        Function that returns the share of unseen worlds of a seed in which a library succeeds, learned in either way.
    """

    title: str
    first_seed: int
    learn: Callable[[int], DrivenLesson]
    teach: Callable[[int], Library]
    measure: Callable[[Library, int], float]


GOTO, WALLS, SERVOING, FORAGING = "goto", "walls", "servoing", "foraging"
BEHAVIORS: Mapping[str, DrivenBehavior] = MappingProxyType(
    {
        GOTO: DrivenBehavior(
            "GoTo",
            0,
            driven_goto.learn_from_drives,
            driven_goto.teach_by_presses,
            driven_goto.measure_success,
        ),
        WALLS: DrivenBehavior(
            "wall following",
            80,
            driven_walls.learn_walls_from_drives,
            lambda seed: teach(driven_walls.find_wall_task(seed), seed).library,
            driven_walls.measure_wall_success,
        ),
        SERVOING: DrivenBehavior(
            "servoing",
            180,
            driven_servoing.learn_servoing_from_drives,
            lambda seed: servoing.teach(seed, driven_servoing.METHOD).library,
            driven_servoing.measure_servoing_success,
        ),
        FORAGING: DrivenBehavior(
            "foraging",
            280,
            driven_foraging.learn_foraging_from_drives,
            lambda seed: forage.teach(seed).library,
            lambda library, seed: forage.judge(library, seed).success,
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
    return {
        **{name: round(share, 4) for name, share in driven.hits.score().items()},
        "driven": behavior.measure(driven.library, seed),
        "pressed": behavior.measure(behavior.teach(seed), seed),
    }


MEASURES = {
    "ticks as the driver meant": "ticks",
    "ticks as the hand answered": "answered",
    "switches within 0.3 s": "switches",
    "success, learned from recordings": "driven",
    "success, taught by presses": "pressed",
}
NEAR = Count(lambda row: row["pressed"] - row["driven"] <= APART + 1e-9)
GROUPS = group_by("behavior", BEHAVIORS)
GOALS = (
    Goal("ticks as the driver meant, median", "ticks", ".1%", TICKS, wanted=f"{TICKS:.0%}"),
    Goal("switches within 0.3 s, median", "switches", ".1%", SWITCHES, wanted=f"{SWITCHES:.0%}"),
    CountGoal(
        f"hands whose success is within {100 * APART:.0f} points of that by presses", 1, NEAR.condition
    ),
    CountGoal(
        f"hands whose success is at least {REACHED:.0%}", REACHING, lambda row: row["driven"] >= REACHED
    ),
)
"""The goals of each behavior."""


def _headline(groups: Mapping[str, Rows]) -> str:
    each = "; ".join(
        f"for {BEHAVIORS[name].title} {rows.median('ticks'):.1%} of the ticks and {rows.median('switches'):.1%} of the "
        f"switches, and {NEAR(rows)} hands"
        for name, rows in groups.items()
    )
    return (
        "From drives with a stick, without a press, behaviors are recognized and learned. Recognized in the "
        f"median, and hands from whose drives a robot learns to succeed within {100 * APART:.0f} points of presses: "
        f"{each}."
    )


def _table(name: str) -> ColumnPerGroup:
    return ColumnPerGroup(
        f"{BEHAVIORS[name].title} from drives, % of ticks, switches and {WORLDS} unseen worlds (seeds {{seeds}})",
        lambda groups: {"median [smallest, largest]": groups[name]},
        {what: Median(lambda row, key=key: 100 * row[key], 1) for what, key in MEASURES.items()},
    )


def _draw_labels(name: str) -> Dots:
    labels = {
        "ticks": "ticks\nas meant",
        "answered": "ticks\nas answered",
        "switches": "switches\nwithin 0.3 s",
    }
    shares = by_value(labels, 100)
    return Dots(f"Labels, {BEHAVIORS[name].title}", "% right", lambda groups: shares(groups[name]))


def _draw_success(name: str) -> Callable[[Any, Any], None]:
    shares = by_value({"driven": "from\nrecordings", "pressed": "by presses"}, 100)

    def draw(axes: Any, groups: Mapping[str, Rows]) -> None:
        values = shares(groups[name])
        least = min(90.0, *map(min, values.values())) - 4.0
        Dots(f"Success, {BEHAVIORS[name].title}", "% of worlds", lambda _: values, (least, 102.0))(
            axes, groups
        )

    return draw


EXPERIMENT = Study(
    name="recordings",
    seeds=SEEDS,
    quick=2,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=GROUPS,
        headline=_headline,
        tables=[_table(name) for name in BEHAVIORS],
        goals=[
            goal
            for name, each in BEHAVIORS.items()
            for goal in goals_among(itemgetter(name), GOALS, f"{each.title}: ")
        ],
        notes=(
            "The hand answers to what the driver means 0 to 0.2 s later, so each switch costs as many ticks.",
        ),
        numbers=lambda groups: {
            name: {key: round(rows.median(key), 4) for key in MEASURES.values()}
            for name, rows in groups.items()
        },
    ),
    draw=Panels(
        [*map(_draw_labels, BEHAVIORS), *map(_draw_success, BEHAVIORS)],
        rows=2,
        wide=3.3,
        tall=2.6,
        prepare=GROUPS,
    ),
)
