"""Batches of runs, measured: time to finish, food per second, beside the yardstick on the same worlds.

Whatever decides - a forager written by hand, or a run of a taught library - is a function from a percept to
commands, so that `measure` treats all alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
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
from understudy.worlds.catalog import CatalogWorld, find_world
from understudy.worlds.forage_expert import HandForager, lower_bound

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
    world: CatalogWorld | str,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Judge a behavior of a library on one world per seed, all side by side; a world may be given by name."""
    world = find_world(world) if isinstance(world, str) else world
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
