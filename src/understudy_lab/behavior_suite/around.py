"""Circumnavigating obstacles, convex and concave, with the left hand on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import tau

import numpy as np

from understudy.model.kinds import Column
from understudy.model.lesson import Options
from understudy_lab.behavior_suite.random_rooms import Plot, apart, built, concave, convex, middles
from understudy_lab.behavior_suite.rovers import RADIUS, SPEED
from understudy_lab.behavior_suite.task import Feat, Judged, Trial
from understudy_lab.behavior_suite.tracks import Table, Tracks, gained, length_of, medians, turns
from understudy_lab.behavior_suite.wall_following import LEFT, by_hand, follow

NEAR_M, CIRCLING_LIMIT_S = 1.0, 90.0


def judge_circling(tracks: Tracks, plots: Sequence[Plot]) -> Judged:
    """When it was once around since it was last a meter away from the obstacle; and how far away it was till then."""
    far, _ = apart(tracks.x, tracks.y, plots)
    middle = middles(len(plots))
    gone = gained(turns(tracks.x, tracks.y, middle[:, 0], middle[:, 1]), far <= NEAR_M)
    seconds = tracks.first(gone >= 1.0)
    last = np.where(np.isnan(seconds), np.inf, seconds / tracks.tick_s + 0.5)
    till_then = np.where((far <= NEAR_M) & (np.arange(len(far))[:, None] <= last), far, np.nan)
    return Judged(seconds, {"turns": gone.max(axis=0), "distance kept, m": medians(till_then)})


def compute_circling_bound(tracks: Tracks, plots: Sequence[Plot]) -> Column:
    """To within a meter, then around the obstacle's convex hull, the rover's radius away, less the meter that closing
    the loop may save, at full speed [W], s.
    """
    far, _ = apart(tracks.x[:1], tracks.y[:1], plots)
    loops = np.array([length_of(hull(plot.corners)) for plot in plots]) + tau * RADIUS
    seconds: Column = (np.maximum(0.0, far[0] - NEAR_M) + loops - NEAR_M) / SPEED
    return seconds


def hull(corners: Table) -> Table:
    """The corners [P, 2] of the convex hull, counter-clockwise (Andrew 1979)."""
    points = sorted((float(x), float(y)) for x, y in corners)

    def half(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        found: list[tuple[float, float]] = []
        for x, y in points:
            while len(found) > 1:
                (x0, y0), (x1, y1) = found[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                    break
                found.pop()
            found.append((x, y))
        return found[:-1]

    return np.array(half(points) + half(points[::-1]))


def _make_circling_trial(seeds: Sequence[int], make: Callable[[int], Plot]) -> Trial:
    plots = [make(seed) for seed in seeds]
    return Trial(
        built(plots, solid=True),
        CIRCLING_LIMIT_S,
        lambda tracks: judge_circling(tracks, plots),
        lambda tracks: compute_circling_bound(tracks, plots),
    )


def _make_circling_task(name: str, what: str, make: Callable[[int], Plot]) -> Feat:
    return Feat(
        name=name,
        does=f"goes once around a {what}",
        measured="once around in 90 s, never more than 1 m away from it",
        bounded="the obstacle's convex hull, once around",
        kit=built([make(0)], solid=True).kit,
        topics=(follow(name, LEFT, "obstacle", cases=2, seconds=20.0),),
        options={name: Options(watched=True, reaction_s=0.2)},
        practice=lambda practice, seed: built([make(seed)], solid=True),
        trial=lambda seeds: _make_circling_trial(seeds, make),
        hand=by_hand(LEFT),
    )


CIRCLING_TASKS = (
    _make_circling_task("around_convex", "convex obstacle", convex),
    _make_circling_task("around_concave", "concave obstacle (an L or a U)", concave),
)
