"""Metrics of a patrol, computed from its tracks: cycles, attacks on absent intruders, encounters with the boss."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy_lab.patrol.tracks import ATTACK, DISPERSE, HOME, RUN_AWAY, PatrolTracks

AT_HOME_M = 3.0
CYCLE_S = 120.0
OPEN_S = 60.0
"""A cycle that is still open at the end of the run counts as failed after this time, s."""
CAPTURE_S = 2.0
VIEW = pi / 3
TURNS_S = (tau - VIEW) / 1.0
"""The longest time in s to bring an object into view by turning one way at 1 rad/s."""
LEEWAY_S = 1.0


@dataclass(frozen=True, slots=True)
class PatrolCycle:
    """A cycle from a capture until all robots are ordered to disperse: its world, first tick and duration in s.

    `seconds` is NaN if the cycle was still open at the end; `farthest_m` is the distance of the farthest robot from its
    home when they were ordered to disperse.
    """

    world: int
    tick: int
    seconds: float
    farthest_m: float

    @property
    def complete(self) -> bool:
        """Whether all robots were at home, and in time."""
        return self.seconds <= CYCLE_S and self.farthest_m <= AT_HOME_M


def captures(tracks: PatrolTracks) -> list[tuple[int, int]]:
    """Return the captures: for each intruder, the number of its world and the first tick after its removal."""
    there = tracks.intruder.there
    gone = there[:-1] & ~there[1:]
    return [(int(world), int(tick) + 1) for tick, world in np.argwhere(gone)]


def cycles(tracks: PatrolTracks) -> Iterator[PatrolCycle]:
    """Yield the cycles of a team. A cycle begins when an intruder is captured that a squad was attacking.

    A capture on the way home belongs to the open cycle. A cycle that the boss interrupts is not counted.
    """
    ordered = tracks.ordered
    until = dict.fromkeys(range(ordered.shape[1]), -1)
    for world, tick in sorted(captures(tracks)):
        doing = ordered[:, world]
        since = max(0, tick - 1 - round(CAPTURE_S / tracks.tick_s))
        if tick < until[world] or not (doing[since : tick + 1] == ATTACK).any():
            continue
        after = np.flatnonzero(np.isin(doing[tick:], (DISPERSE, RUN_AWAY)).all(axis=1))
        if len(after):
            end = until[world] = tick + int(after[0])
            if (doing[end] == RUN_AWAY).any():
                continue
            yield PatrolCycle(world, tick, (end - tick) * tracks.tick_s, _farthest(tracks, world, end))
        else:
            until[world] = tracks.ticks
            if (tracks.ticks - tick) * tracks.tick_s > OPEN_S:
                yield PatrolCycle(world, tick, float("nan"), float("nan"))


def count_cycles(tracks: PatrolTracks) -> dict[str, Any]:
    """Return the numbers of cycles, complete ones and captures, and the duration of each cycle in s, None if open."""
    ended = list(cycles(tracks))
    return {
        "cycles": len(ended),
        "complete": sum(each.complete for each in ended),
        "captures": len(captures(tracks)),
        "cycle_s": [None if np.isnan(each.seconds) else round(each.seconds, 1) for each in ended],
    }


def _farthest(tracks: PatrolTracks, world: int, tick: int) -> float:
    x, y = tracks.home.T
    return float(np.hypot(tracks.x[tick, world] - x, tracks.y[tick, world] - y).max())


def false_homes(tracks: PatrolTracks) -> int:
    """Count how often all robots went home though nothing was captured."""
    home, count = (tracks.ordered == HOME).all(axis=2), 0
    margin = round((CAPTURE_S + 0.5) / tracks.tick_s)
    for tick, world in np.argwhere(home[1:] & ~home[:-1]):
        there = tracks.intruder.there[max(0, tick - margin) : tick + 1 + margin, world]
        count += bool(there.all()) and len(there) > margin
    return count


def residual_s(tracks: PatrolTracks) -> float:
    """Return the robot-seconds spent attacking an intruder that is no longer there."""
    return float(((tracks.doing == ATTACK) & ~tracks.intruder.there[:, :, None]).sum() * tracks.tick_s)


def count_joint_attacks(tracks: PatrolTracks) -> tuple[int, int]:
    """Count the sightings while dispersing, and those after which all were ordered to attack in the same tick."""
    before, now = tracks.doing[:-1], tracks.doing[1:]
    sightings = tracks.sees[1:].any(axis=2) & (before == DISPERSE).all(axis=2)
    return int(sightings.sum()), int((sightings & (now == ATTACK).all(axis=2)).sum())


def attackers(tracks: PatrolTracks) -> NDArray[np.int64]:
    """Return for each captured intruder how many robots were attacking when the first came close enough."""
    since = round(CAPTURE_S / tracks.tick_s) + 1
    counts = [
        int((tracks.doing[max(0, tick - since), world] == ATTACK).sum()) for world, tick in captures(tracks)
    ]
    return np.array([count for count in counts if count], np.int64)


def sighting_to_capture(tracks: PatrolTracks) -> NDArray[np.float64]:
    """Return for each captured intruder the time in s from its first sighting to its removal."""
    times = []
    for world, tick in captures(tracks):
        gone_before = np.flatnonzero(~tracks.intruder.there[:tick, world])
        first = int(gone_before[-1]) + 1 if len(gone_before) else 0
        sightings = np.flatnonzero(tracks.sees[first:tick, world].any(axis=1))
        if len(sightings):
            times.append((tick - first - int(sightings[0])) * tracks.tick_s)
    return np.array(times)


@dataclass(frozen=True, slots=True)
class BossEncounter:
    """An encounter of a patrol with the boss, a moving person from whom all robots must run away.

    `in_sight` counts the robots between which and the boss nothing stood until all had to have turned, `turned` those
    of them that turned to him.
    `resumed_s` is the time from the last sighting of the boss until the patrol went on; NaN if it did not.
    """

    world: int
    tick: int
    in_sight: int
    turned: int
    resumed_s: float

    @property
    def deferred(self) -> bool:
        """Whether every robot that could see the boss turned to him in time."""
        return self.turned == self.in_sight


def encounters(tracks: PatrolTracks, *, within_s: float = TURNS_S + LEEWAY_S) -> Iterator[BossEncounter]:
    """Yield the encounters, each from the tick in which the whole team begins to run away."""
    away = (tracks.doing == RUN_AWAY).all(axis=2)
    span = round(within_s / tracks.tick_s)
    for before, world in np.argwhere(away[1:] & ~away[:-1]):
        tick = before + 1
        if tick + span >= tracks.ticks:
            continue
        rows = slice(int(tick), int(tick) + span)
        sight = find_boss_sightings(tracks, world, rows).all(axis=0)
        turned = (find_boss_in_view(tracks, world, rows) & sight).any(axis=0)
        yield BossEncounter(
            int(world),
            int(tick),
            int(sight.sum()),
            int(turned.sum()),
            _resumed(tracks, int(world), int(tick)),
        )


def _resumed(tracks: PatrolTracks, world: int, tick: int) -> float:
    over = np.flatnonzero((tracks.doing[tick:, world] != RUN_AWAY).any(axis=1))
    end = tick + int(over[0]) if len(over) else 0
    sightings = np.flatnonzero(tracks.sees_boss[: end + 1, world].any(axis=1))
    return float((end - sightings[-1]) * tracks.tick_s) if end and len(sightings) else float("nan")


def find_boss_in_view(tracks: PatrolTracks, world: int, rows: slice) -> NDArray[np.bool_]:
    """Return which robots have the boss in their field of view [rows, N], ignoring occlusion."""
    x, y = tracks.x[rows, world], tracks.y[rows, world]
    toward = np.arctan2(tracks.boss.y[rows, world, None] - y, tracks.boss.x[rows, world, None] - x)
    off = np.mod(toward - tracks.heading[rows, world] + pi, tau) - pi
    in_view: NDArray[np.bool_] = np.abs(off) <= VIEW / 2
    return in_view


def find_boss_sightings(
    tracks: PatrolTracks, world: int, rows: slice, *, robot_m: float = 0.2
) -> NDArray[np.bool_]:
    """Return which robots have a free line to the boss [rows, N]: no obstacle, robot or intruder on it."""
    eye = np.stack([tracks.x[rows, world], tracks.y[rows, world]], axis=-1).astype(np.float64)
    boss = np.stack([tracks.boss.x[rows, world], tracks.boss.y[rows, world]], axis=-1).astype(np.float64)
    free = np.repeat(tracks.boss.there[rows, world, None], eye.shape[1], axis=1)
    for x, y, radius in tracks.obstacles[world]:
        if radius > 0:
            free &= ~_hides(eye, boss, np.broadcast_to([x, y], boss.shape), radius)
    for robot in range(eye.shape[1]):
        hidden = _hides(eye, boss, eye[:, robot], robot_m)
        hidden[:, robot] = False
        free &= ~hidden
    there = tracks.intruder.there[rows, world, None]
    at = np.stack([tracks.intruder.x[rows, world], tracks.intruder.y[rows, world]], axis=-1).astype(
        np.float64
    )
    return free & ~(_hides(eye, boss, at, robot_m) & there)


def _hides(
    eye: NDArray[np.float64], boss: NDArray[np.float64], disc: NDArray[np.float64], radius: float
) -> NDArray[np.bool_]:
    """Return whether a disc [T, 2] touches the line from each eye [T, N, 2] to the boss [T, 2]."""
    line, to_disc = boss[:, None] - eye, disc[:, None] - eye
    length = np.maximum((line**2).sum(axis=-1), 1e-9)
    along = np.clip((line * to_disc).sum(axis=-1) / length, 0.0, 1.0)
    nearest = eye + along[..., None] * line
    hides: NDArray[np.bool_] = ((disc[:, None] - nearest) ** 2).sum(axis=-1) < radius**2
    return hides
