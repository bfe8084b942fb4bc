"""Following the walls of random rooms, with either hand on them."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, tau

import numpy as np

from understudy.model.kinds import Column
from understudy.model.lesson import Options
from understudy_lab.behavior_suite.random_rooms import Plot, apart, built, lengths, room
from understudy_lab.behavior_suite.rovers import SPEED
from understudy_lab.behavior_suite.task import Feat, Judged, Trial
from understudy_lab.behavior_suite.tracks import Table, Tracks, gained, medians
from understudy_lab.behavior_suite.wall_following import LEFT, RIGHT, by_hand, follow

AT_WALL_M, WALL_LIMIT_S = 1.0, 120.0


def judge_wall_following(tracks: Tracks, plots: Sequence[Plot], hand: str) -> Judged:
    """When the loop was closed since the wall was last farther away than it may be; and how far it was till then."""
    far, along = apart(tracks.x, tracks.y, plots)
    way, whole = (1.0 if hand == RIGHT else -1.0), lengths(plots)
    gone = gained(way * _unwrapped(along, whole), far <= AT_WALL_M)
    seconds = tracks.first(gone >= whole)
    last = np.where(np.isnan(seconds), np.inf, seconds / tracks.tick_s + 0.5)
    till_then = np.where((far <= AT_WALL_M) & (np.arange(len(far))[:, None] <= last), far, np.nan)
    return Judged(
        seconds,
        {"loops": gone.max(axis=0) / whole, "distance kept, m": medians(till_then)},
    )


def _unwrapped(along: Table, whole: Column) -> Table:
    """How far along in all, where the line begins anew after its whole length."""
    return np.unwrap(along / whole * tau, axis=0) * whole / tau


def compute_wall_following_bound(tracks: Tracks, plots: Sequence[Plot]) -> Column:
    """The straight line to within 1 m, then around the room shrunk by that, at full speed [W], s."""
    far, _ = apart(tracks.x[:1], tracks.y[:1], plots)
    inner = np.array([saved(plot.corners) for plot in plots])
    seconds: Column = (np.maximum(0.0, far[0] - AT_WALL_M) + lengths(plots) - inner) / SPEED
    return seconds


def saved(corners: Table) -> float:
    """What a way 1 m inside the corners [P, 2] is shorter by, m: at those that go out; others save nothing."""
    edges = np.roll(corners, -1, axis=0) - corners
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    bends = (np.roll(angles, -1) - angles + pi) % tau - pi
    return float(sum(2 * AT_WALL_M * np.tan(bend / 2) for bend in bends if bend > 0))


def _make_room_trial(seeds: Sequence[int], hand: str) -> Trial:
    plots = [room(seed) for seed in seeds]
    return Trial(
        built(plots, solid=False),
        WALL_LIMIT_S,
        lambda tracks: judge_wall_following(tracks, plots, hand),
        lambda tracks: compute_wall_following_bound(tracks, plots),
    )


def _make_wall_task(hand: str) -> Feat:
    name = f"wall_{hand}"
    return Feat(
        name=name,
        does=f"follows the walls of a random room, its {hand} hand on them",
        measured="the loop along the wall closed in 120 s, never more than 1 m away",
        bounded="the room shrunk by 1 m, once around",
        kit=built([room(0)], solid=False).kit,
        topics=(follow(name, hand, "room", cases=2, seconds=20.0),),
        options={name: Options(watched=True, reaction_s=0.2)},
        practice=lambda practice, seed: built([room(seed)], solid=False),
        trial=lambda seeds: _make_room_trial(seeds, hand),
        hand=by_hand(hand),
    )


WALL_TASKS = (_make_wall_task(LEFT), _make_wall_task(RIGHT))
