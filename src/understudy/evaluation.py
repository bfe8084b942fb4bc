"""Batches of runs, measured: time to finish, food per second, and the yardstick for taught robots.

Whatever decides - the hand-coded forager here, or an engine that runs a taught library - is a function from a
percept to commands, so that `measure` treats all alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import dist, pi, tau
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.binding import NOTHING_BOUND
from understudy.model.feature import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.body import Body, Commands
from understudy.runtime.program import link
from understudy.runtime.run import Run
from understudy.worlds.catalog import CatalogWorld
from understudy.worlds.forage import Forage, ForageSettings, ForageView

Point: TypeAlias = tuple[float, float]
Decide: TypeAlias = Callable[[Percept], Commands]


class Task(Body, Protocol):
    """A body whose worlds have something to finish."""

    @property
    def delivered(self) -> NDArray[np.int64]:
        """Units brought so far [N]."""
        ...

    def success(self) -> NDArray[np.bool_]:
        """Whether each world is finished [N]."""
        ...


@dataclass(frozen=True)
class Outcomes:
    """How N worlds went: columns [N]."""

    seconds: Column
    """Time to finish; absent (NaN) where the limit came first."""
    limit_s: Column
    """How long each was given."""
    delivered: NDArray[np.int64]
    """Units brought within that time."""

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Whether each world finished in time [N]."""
        return ~np.isnan(self.seconds)

    @property
    def success(self) -> float:
        """The share of worlds that finished in time."""
        return float(self.finished.mean())

    @property
    def food_per_s(self) -> Column:
        """Units per second until finished, or until the limit [N]; absent where no time passed."""
        spent = np.where(self.finished, self.seconds, self.limit_s)
        rate: Column = np.divide(self.delivered, spent, out=np.full(len(spent), np.nan), where=spent > 0)
        return rate


def measure(body: Task, decide: Decide, keys: Sequence[ReadingKey], *, limit_s: float | Column) -> Outcomes:
    """Run until each world has finished or reached its limit (one for all, or a column [N]).

    A world that has finished, or is past its limit, runs on unobserved until all are through.
    """
    limits = np.broadcast_to(np.asarray(limit_s, np.float64), (body.agents,)).copy()
    if not (np.isfinite(limits) & (limits >= 0)).all():
        raise SettingError(where="measure", setting="limit_s", problem="is not a time", remedy="give seconds")
    last = np.floor(limits / body.tick_s + 1e-9).astype(np.int64)  # each world's last tick
    seconds, delivered = np.full(body.agents, np.nan), body.delivered
    running = np.ones(body.agents, np.bool_)
    tick = 0
    while True:
        finished = running & body.success()
        seconds[finished] = tick * body.tick_s
        delivered = np.where(running, body.delivered, delivered)
        running &= ~finished & (tick < last)
        if not running.any():
            return Outcomes(seconds, limits, delivered)
        body.act(decide(body.sense(keys)))
        tick += 1


class HandForager:
    """The yardstick: a forager written by hand, for N robots at once, that does one basic behavior at a time.

    It turns until it faces its target to half a tick's turn, then drives, and turns again only when the
    target is off by more than `astray` (rad), so that it never chatters between the two. It goes home when
    full or when no food is left, and stays with that until it carries nothing.
    """

    keys: Sequence[ReadingKey] = (
        ("range", "nearest_food"),
        ("bearing", "nearest_food"),
        ("bearing", "station"),
        ("food_here", None),
        ("food_stored", None),
        ("food_left", None),
        ("station_here", None),
    )

    def __init__(self, agents: int, settings: ForageSettings, *, astray: float = 0.2) -> None:
        self._capacity = settings.capacity
        self._facing = 0.55 * settings.turning_speed * settings.tick_s
        self._astray = max(astray, 2.0 * self._facing)
        self._homing = np.zeros(agents, np.bool_)
        self._turning = np.zeros(agents)  # 1 left, -1 right, 0 not

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        stored, none_left = percept["food_stored", None], percept["food_left", None] == 0.0
        self._homing = (stored > 0) & (self._homing | (stored >= self._capacity) | none_left)
        unload = self._homing & (percept["station_here", None] == 1.0)
        load = ~self._homing & (percept["food_here", None] > 0)
        go = ~(unload | load) & (self._homing | ~none_left)
        bearing = np.where(self._homing, percept["bearing", "station"], percept["bearing", "nearest_food"])
        off = np.where(go, (bearing + pi) % tau - pi, 0.0)  # signed, left positive
        keep_on = (self._turning != 0.0) & (np.abs(off) > self._facing)
        begin = (self._turning == 0.0) & (np.abs(off) > self._astray)
        self._turning = np.where(begin, np.sign(off), np.where(keep_on, self._turning, 0.0))
        drive = go & (self._turning == 0.0)
        return {
            "drive": drive.astype(np.float64),
            "turn": self._turning,
            "load": load.astype(np.float64),
            "unload": unload.astype(np.float64),
        }


def lower_bound(world: Forage) -> Column:
    """Seconds [N] that no robot can beat which visits the places nearest-first, from where it stands now.

    A trip goes to the nearest source with food, and on to the next nearest while there is room and food, then
    to the station; what is nearest is judged from where a straight way comes within reach. Counted are the
    straight lines between those places, less the reach at either end, at forward speed; and loading and
    unloading each unit. Turning costs nothing and ticks need not be whole, so for that order of visits it is
    a true bound. A robot that chooses another order may beat it.
    """
    return np.array([_bound(world.view(agent), world.settings) for agent in range(world.agents)])


def _bound(view: ForageView, settings: ForageSettings) -> float:
    amounts = [source.amount for source in view.sources]
    unload = sum(amounts) + view.stored
    route = _Route(view.reach, (view.x, view.y))
    stored = view.stored
    while stored or any(amounts):
        while stored < view.capacity and any(amounts):
            with_food = [k for k, amount in enumerate(amounts) if amount]
            nearest = min(with_food, key=lambda k: dist(route.spot, view.sources[k][:2]))
            route.go(view.sources[nearest][:2])
            taken = min(amounts[nearest], view.capacity - stored)
            amounts[nearest] -= taken
            stored += taken
        route.go(view.station)
        stored = 0
    work = (unload - view.stored) * settings.load_s + unload * settings.unload_s
    return route.meters / settings.forward_speed + work


class _Route:
    """Straight ways from place to place, each from and to anywhere within reach of its ends."""

    def __init__(self, reach: float, start: Point) -> None:
        self.reach, self.spot, self.meters = reach, start, 0.0
        self._place, self._slack = start, 0.0

    def go(self, place: Point) -> None:
        """Go where `place` is within reach; `spot` is where a straight way there would end."""
        self.meters += max(0.0, dist(self._place, place) - self._slack - self.reach)
        straight = dist(self.spot, place)
        if straight > self.reach:
            left = self.reach / straight
            (x, y), (to_x, to_y) = self.spot, place
            self.spot = (to_x + (x - to_x) * left, to_y + (y - to_y) * left)
        self._place, self._slack = place, self.reach


LENIENCE = 3.0
"""How many times the yardstick's time a taught robot is given."""

Progress: TypeAlias = Callable[[int, int], None]
"""Called now and then with how many worlds are finished, and how many there are."""


@dataclass(frozen=True)
class Evaluation:
    """A taught behavior judged on N worlds beside the yardstick on the same ones: columns [N]."""

    behavior: str
    world: str
    seeds: tuple[int, ...]
    taught: Outcomes
    expert: Outcomes

    @property
    def success(self) -> float:
        """The share of worlds that the taught robot finished within three times the yardstick's time."""
        return self.taught.success

    @property
    def relative(self) -> Column:
        """Taught food per second as a share of the yardstick's [N]; absent where there is no food."""
        expert = self.expert.food_per_s
        ratio: Column = np.divide(
            self.taught.food_per_s, expert, out=np.full(len(expert), np.nan), where=expert > 0
        )
        return ratio

    @property
    def relative_to_expert(self) -> float:
        """The median of `relative` over the worlds that have food; absent where none has."""
        known = self.relative[~np.isnan(self.relative)]
        return float(np.median(known)) if len(known) else float("nan")


def evaluate(
    library: Library,
    behavior: str,
    world: CatalogWorld,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Judge a behavior of a library on one world per seed, all side by side."""
    if not seeds:
        raise SettingError(
            where="evaluation", setting="seeds", problem="are none", remedy="give at least one"
        )
    program = link(library, behavior, binding)
    expert = judge_expert(world, seeds)
    limits = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    body = world.make(list(seeds))
    run = Run.of(body, program)
    decide = run.decide if progress is None else _reporting(body, run.decide, progress)
    taught = measure(body, decide, run.keys, limit_s=limits)
    if progress is not None:
        progress(len(seeds), len(seeds))
    return Evaluation(behavior, world.name, tuple(seeds), taught, expert)


def judge_expert(world: CatalogWorld, seeds: Sequence[int]) -> Outcomes:
    """The yardstick on one world per seed, given ample time."""
    body = world.make(list(seeds))
    hand = HandForager(body.agents, body.settings)
    return measure(body, hand.decide, hand.keys, limit_s=10.0 * lower_bound(body) + 60.0)


def _reporting(body: Task, decide: Decide, progress: Progress) -> Decide:
    calls = 0

    def reporting(percept: Percept) -> Commands:
        nonlocal calls
        if calls % 50 == 0:
            progress(int(body.success().sum()), body.agents)
        calls += 1
        return decide(percept)

    return reporting
