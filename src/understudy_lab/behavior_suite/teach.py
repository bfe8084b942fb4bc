"""Teaching one feat, and judging what was taught beside the hand-written controller: one row of the experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy_lab.behavior_suite.task import Feat, Judged, Trial
from understudy_lab.behavior_suite.tracks import Tracks, record
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.teachers.teacher import Teacher, Teaching

WORLDS = 100


def worlds_of(seed: int) -> range:
    """The unseen worlds that a teaching is judged on; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def teach(feat: Feat, seed: int) -> Teaching:
    """Teach its automata, one after the other. Same seed, same library."""
    return Teacher(Library(feat.kit), feat.practice, seed, options=feat.options).teach(*feat.topics)


def by_taught(trial: Trial, library: Library, behavior: str) -> Tracks:
    """What robots do that all run a taught behavior, each with its own bindings."""
    programs = [link(library, behavior, binding) for binding in trial.bindings]
    engine = Engine(trial.world, programs * (trial.world.agents // len(programs)))
    return record(trial.world, engine.tick, trial.seconds)


def by_hand(trial: Trial, feat: Feat) -> Tracks:
    """What robots do that run the controller written by hand."""
    world, hand = trial.world, feat.hand(trial.world)
    return record(world, lambda: world.act(hand.decide(world.sense(hand.keys))), trial.seconds)


def row_of(feat: Feat, seed: int) -> dict[str, Any]:
    """Teach and judge: plain data."""
    teaching = teach(feat, seed)
    trial = feat.trial(worlds_of(seed))
    taught = trial.judge(by_taught(trial, teaching.library, feat.behavior))
    trial = feat.trial(worlds_of(seed))
    tracks = by_hand(trial, feat)
    hand, bound = trial.judge(tracks), trial.bound(tracks)
    accounts = teaching.accounts
    return {
        "success": share_done(taught),
        "ratio": compared(taught, hand),
        "measures": {name: middle(column) for name, column in measures(taught).items()},
        "hand": {
            "success": share_done(hand),
            "of_bound": middle(hand.seconds / bound),
            "measures": {name: middle(column) for name, column in measures(hand).items()},
        },
        "examples": teaching.examples,
        "presses": sum(account.presses for account in accounts.values()),
        "seconds": round(teaching.seconds, 1),
        "lessons": [
            {**lesson, "attempts": accounts[lesson["name"]].lessons} for lesson in lessons_of(teaching)
        ],
    }


def share_done(judged: Judged) -> float:
    """The share of worlds in which it was done in time."""
    return float((~np.isnan(judged.seconds)).mean())


def compared(taught: Judged, hand: Judged) -> float | None:
    """How fast it is beside the one written by hand: median over the worlds where that one did it; 0 where not done."""
    known = ~np.isnan(hand.seconds)
    return middle(np.nan_to_num(hand.seconds / taught.seconds)[known])


def measures(judged: Judged) -> Mapping[str, Any]:
    """All that was measured, seconds first."""
    return {"seconds": judged.seconds, **judged.measures}


def middle(column: Any) -> float | None:
    """The median of what is there; None where nothing is."""
    known = column[~np.isnan(column)]
    return round(float(np.median(known)), 4) if len(known) else None
