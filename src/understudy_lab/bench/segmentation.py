"""The speed of segmentation: an hour of driving, recorded at 20 Hz, with ten behaviors that may explain it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from understudy.addons.recordings.candidates import BehaviorCandidate
from understudy.addons.recordings.segment import segment
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import NOTHING_BOUND
from understudy.records.record import Episode, Record
from understudy.runtime.body import Channel
from understudy.runtime.link import GroundBehavior
from understudy_lab.bench.harness import medians

TICKS, TICK_S, BEHAVIORS = 72_000, 0.05, 10
STAY_TICKS = 40
GAIN, NOISE = 0.4, 0.03
GOAL_S = 5.0
ROUNDS = 5


def make_candidates() -> list[BehaviorCandidate]:
    """Make behaviors that each command a speed and a rate of turning, at random."""
    drawn = np.random.default_rng(0).uniform(-1, 1, (BEHAVIORS, 2)).tolist()
    behaviors = [
        Behavior(f"move_{number}", Command(drive=drive, turn=turn))
        for number, (drive, turn) in enumerate(drawn)
    ]
    return [BehaviorCandidate(GroundBehavior(each, NOTHING_BOUND)) for each in behaviors]


def make_drive(ticks: int = TICKS) -> Record:
    """Make a drive in which a hand with noise follows another behavior every two seconds."""
    random = np.random.default_rng(1)
    commands = [
        [each.ground.behavior.command["drive"], each.ground.behavior.command["turn"]]
        for each in make_candidates()
    ]
    meant = np.repeat(random.integers(0, BEHAVIORS, -(-ticks // STAY_TICKS)), STAY_TICKS)[:ticks]
    aims, noise = np.array(commands)[meant], NOISE * random.normal(size=(ticks, 2))
    moved, hand = np.empty((ticks, 2)), np.zeros(2)
    for tick in range(ticks):
        hand = hand + GAIN * (aims[tick] - hand)
        moved[tick] = hand + noise[tick]
    channels = (Channel("drive"), Channel("turn"))
    return Record(
        np.arange(ticks, dtype=np.float64) * TICK_S,
        {},
        moved,
        channels,
        (),
        (),
        TICK_S,
        (Episode("drive", 0, ticks),),
    )


def run(*, rounds: int = ROUNDS, ticks: int = TICKS) -> dict[str, Any]:
    """Return the median time in s of a segmentation, with the goal for an hour."""
    taken = medians(rounds, segment=partial(segment, make_drive(ticks), make_candidates()))
    taken_s = taken["segment_ms"] / 1000
    return {
        "ticks": ticks,
        "hours": ticks * TICK_S / 3600,
        "behaviors": BEHAVIORS,
        "s": taken_s,
        "goal_s": GOAL_S,
        "passed": taken_s <= GOAL_S,
    }
