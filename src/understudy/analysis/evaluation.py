"""Measure batches of runs: time to finish, and food per second relative to a baseline.

A behavior that can raise the flag `done` is finished when it does; any other when the scenario's goal is reached.

A baseline is a controller written by hand for a scenario, found by entry points (`BASELINES`). Every world that has one
gets three times the baseline's time to reach its goal; everything else is given the scenario's own limit.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from importlib.metadata import entry_points
from math import sqrt
from pathlib import Path
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.binding import NOTHING_BOUND
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.body import Commands
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import Program, link
from understudy.runtime.team.team import Team
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, list_running_sorts, make_team
from understudy.sim.world import World

DecideCommands: TypeAlias = Callable[[Percept], Commands]
Progress: TypeAlias = Callable[[int, int], None]
"""Called now and then with how many worlds are through, and how many there are; what it raises ends the evaluation."""


def skip_progress(through: int, worlds: int) -> None:
    """Tell nobody how many worlds are through."""


BASELINES = "understudy.baselines"
"""Entry points of this group are functions that take a scenario and return its `Baseline`, or None."""

SUCCESS_FLAG = "done"
"""With this flag a behavior says that it has done what it is for."""

LENIENCE = 3.0
"""How many times the baseline's time a taught robot is given."""

TICKS_AT_ONCE = 200
"""After so many ticks of all worlds in one go there is a look at who has finished, and at the keyboard."""

WORLDS_AT_ONCE = 5_000
"""So many worlds lie side by side in memory."""

Z95 = 1.959964


@dataclass(frozen=True)
class Outcomes:
    """How N worlds went: columns [N]."""

    seconds: Column
    """Time to finish; absent (NaN) where the limit came first."""
    limit_s: Column
    """How long each was given."""
    delivered: NDArray[np.int64]
    """Units brought within that time."""
    gathered: NDArray[np.int64]
    """Boxes gathered within that time."""

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
        """Units per second until finished, or until the limit [N]; absent where there is nothing to bring."""
        spent = np.where(self.finished, self.seconds, self.limit_s)
        rate: Column = np.divide(self.delivered, spent, out=np.full(len(spent), np.nan), where=spent > 0)
        return rate

    @classmethod
    def concatenate(cls, parts: Sequence[Outcomes]) -> Outcomes:
        """Those of several batches as one."""
        return cls(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)))


class Controller(Protocol):
    """Decides for N robots at once, from the readings that it names."""

    keys: Sequence[ReadingKey]

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of this tick."""
        ...


@dataclass(frozen=True)
class Baseline:
    """A controller written by hand, and the worlds in which it is measured."""

    scenario: Scenario
    make_controller: Callable[[World], Controller]
    limits_s: Callable[[World], Column]
    """Ample time for each world [B]."""


def find_baseline(scenario: Scenario) -> Baseline | None:
    """Find the baseline of a scenario among those installed; None where there is none."""
    found = (entry.load()(scenario) for entry in entry_points(group=BASELINES))
    return next((baseline for baseline in found if baseline is not None), None)


def measure_baseline(
    baseline: Baseline, seeds: Sequence[int], *, progress: Progress = skip_progress
) -> Outcomes:
    """Measure a baseline on one world per seed."""
    world = World(baseline.scenario, seeds)
    controller = baseline.make_controller(world)
    limits = baseline.limits_s(world)
    return measure_outcomes(world, controller.decide, controller.keys, limit_s=limits, progress=progress)


def measure_outcomes(
    world: World,
    decide: DecideCommands,
    keys: Sequence[ReadingKey],
    *,
    limit_s: float | Column,
    progress: Progress = skip_progress,
) -> Outcomes:
    """Run until each world has reached its goal or its limit (one for all, or a column [B]), tick by tick.

    A world that is through runs on unobserved until all are.
    """

    def advance(ticks: int) -> None:
        for _ in range(ticks):
            world.act(decide(world.sense(keys)))

    return _measured(world, advance, lambda: world.finished_s, limit_s, at_once=1, progress=progress)


def measure_program_outcomes(
    world: World,
    program: Program,
    *,
    limit_s: float | Column,
    flag: str | None = None,
    progress: Progress = skip_progress,
) -> Outcomes:
    """As `measure_outcomes`, for robots that all run one program: many ticks in one go where all of it is data.

    Given a `flag`, a world is finished once all its robots have raised it, whatever its goal. Otherwise a world ends
    with the tick in which it reaches its goal; reset them before anything goes on with them.
    """
    engine = Engine.from_program(world, program)
    plan = engine.plan()

    def advance(ticks: int) -> None:
        if plan is not None:
            world.advance(plan, ticks, until_finished=flag is None)
        else:
            for _ in range(ticks):
                engine.tick()

    def finished_s() -> Column:
        return world.finished_s if flag is None else _raised_s(world, engine, flag)

    at_once = 1 if plan is None else TICKS_AT_ONCE
    return _measured(world, advance, finished_s, limit_s, at_once=at_once, progress=progress)


def _raised_s(world: World, engine: Engine, flag: str) -> Column:
    """When the last robot of each world raised a flag [B], s; absent where one has not.

    It stays in the state that raises it, so that when it entered this state can be read off many ticks later.
    """
    ticks = np.where(
        engine.find_raised(flag), np.rint(engine.stacks.entered[:, 0] / world.tick_s) + 1, np.nan
    )
    last: Column = world.tick_s * ticks.reshape(world.worlds, -1).max(axis=1)
    return last


def _measured(
    world: World,
    advance: Callable[[int], None],
    finished_s: Callable[[], Column],
    limit_s: float | Column,
    *,
    at_once: int,
    progress: Progress,
) -> Outcomes:
    limits = np.broadcast_to(np.asarray(limit_s, np.float64), (world.worlds,)).copy()
    if not (np.isfinite(limits) & (limits >= 0)).all():
        raise SettingError(where="measure", setting="limit_s", problem="is not a time", remedy="give seconds")
    last = np.floor(limits / world.tick_s + 1e-9).astype(np.int64)  # each world's last tick
    seconds, delivered, gathered = np.full(world.worlds, np.nan), world.delivered, world.gathered
    running = np.ones(world.worlds, np.bool_)
    tick = 0
    while True:
        finished = finished_s()
        through = running & (~np.isnan(finished) | (tick >= last))
        seconds[through], delivered[through] = finished[through], world.delivered[through]
        gathered[through] = world.gathered[through]
        running &= ~through
        progress(world.worlds - int(running.sum()), world.worlds)
        if not running.any():
            return Outcomes(seconds, limits, delivered, gathered)
        ticks = min(at_once, int(last[running].min()) - tick)
        advance(ticks)
        tick += ticks


@dataclass(frozen=True)
class Evaluation:
    """A behavior judged on N worlds, beside the baseline on the same ones where there is one: columns [N]."""

    behavior: str
    world: str
    seeds: tuple[int, ...]
    taught: Outcomes
    expert: Outcomes | None
    flag: str | None = None
    """Raised, it was success; None: the scenario's goal was."""

    @property
    def success(self) -> float:
        """The share of worlds that were finished in time."""
        return self.taught.success

    @property
    def relative(self) -> Column:
        """Taught food per second as a share of the baseline's [N]; absent where there is no food, or no baseline."""
        absent = np.full(len(self.seeds), np.nan)
        if self.expert is None:
            return absent
        expert = self.expert.food_per_s
        ratio: Column = np.divide(self.taught.food_per_s, expert, out=absent, where=expert > 0)
        return ratio

    @property
    def relative_to_expert(self) -> float:
        """The median of `relative` over the worlds that have it; absent where none has."""
        known = self.relative[~np.isnan(self.relative)]
        return float(np.median(known)) if len(known) else float("nan")


def evaluate(
    library: Library,
    behavior: str,
    world: Scenario | Path | str,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Judge a behavior of a library on one world per seed; all robots run it. A world may be given by name or path.

    One that can raise the flag `done` succeeds by raising it in time, any other by reaching the scenario's goal.
    """
    scenario = world if isinstance(world, Scenario) else find_scenario(world)
    seeds = _read_seeds(seeds)
    program = link_for_evaluation(library, behavior, scenario, binding)
    flag = find_success_flag(library, behavior)

    def measure(batch: Sequence[int], limits: float | Column, report: Progress) -> Outcomes:
        return measure_program_outcomes(
            World(scenario, batch), program, limit_s=limits, flag=flag, progress=report
        )

    return _evaluate(behavior, scenario, seeds, measure, flag=flag, progress=progress)


def evaluate_team(
    libraries: Libraries,
    sort: str,
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Judge a behavior of coordinators, or of one of several types of robots, on one world per seed.

    What counts as success is as in `evaluate`. All agents of the `sort` run it, or all robots that have it where it is
    a basic one; coordinators order those below them about.
    """
    seeds = _read_seeds(seeds)
    link_for_evaluation(libraries[sort], behavior, scenario, binding)
    flag = find_success_flag(libraries[sort], behavior)
    roots = dict.fromkeys(list_running_sorts(libraries, sort, behavior), (behavior, binding))

    def measure(batch: Sequence[int], limits: float | Column, report: Progress) -> Outcomes:
        team = make_team(scenario, batch, libraries, roots)
        return measure_team_outcomes(team, roots, limit_s=limits, flag=flag, progress=report)

    return _evaluate(behavior, scenario, seeds, measure, flag=flag, progress=progress)


def measure_team_outcomes(
    team: Team,
    sorts: Collection[str],
    *,
    limit_s: float | Column,
    flag: str | None = None,
    progress: Progress = skip_progress,
) -> Outcomes:
    """As `measure_program_outcomes`, for a simulated team, tick by tick; the flag is one of the agents of `sorts`."""
    world = team.ground
    if not isinstance(world, World):
        raise TypeError("a team of real robots")
    raised_s = np.full(world.worlds, np.nan)

    def advance(ticks: int) -> None:
        for _ in range(ticks):
            team.tick()
            if flag is not None:
                raised = np.isnan(raised_s) & _have_raised(team, sorts, flag, world.worlds)
                raised_s[raised] = world.time_s

    def finished_s() -> Column:
        return world.finished_s if flag is None else raised_s

    return _measured(world, advance, finished_s, limit_s, at_once=1, progress=progress)


def _have_raised(team: Team, sorts: Collection[str], flag: str, worlds: int) -> NDArray[np.bool_]:
    """In which worlds all agents of these sorts have raised a flag [B]."""
    found = np.ones(worlds, np.bool_)
    for sort in sorts:
        raised = team.find_raised(sort, [flag]).reshape(worlds, -1)
        if sort in team.tree.types:  # robots of all types are in one layer
            raised = raised[:, np.array(team.tree.type_of) == team.tree.types.index(sort)]
        found &= raised.all(axis=1)
    return found


def _read_seeds(seeds: Sequence[int]) -> list[int]:
    try:
        seeds = list(seeds)
    except TypeError:  # one number, say
        remedy = "give a list of whole numbers, one for each world: [5]"
        raise SettingError(
            where="evaluation", setting="seeds", problem=f"are {seeds!r:.60}", remedy=remedy
        ) from None
    if not seeds:
        raise SettingError(
            where="evaluation", setting="seeds", problem="are none", remedy="give at least one"
        )
    return seeds


def _evaluate(
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    measure: Callable[[Sequence[int], float | Column, Progress], Outcomes],
    *,
    flag: str | None,
    progress: Progress | None,
) -> Evaluation:
    """Evaluate in batches of worlds with what measures one, beside the baseline where the goal is what counts."""
    baseline = find_baseline(scenario) if flag is None else None
    taught, expert = list[Outcomes](), list[Outcomes]()
    for first, batch in _batches(seeds):

        def report(through: int, _: int, first: int = first) -> None:
            if progress is not None:
                progress(first + through, len(seeds))

        limits: float | Column = scenario.limit_s
        if baseline is not None:
            by_hand = measure_baseline(baseline, batch, progress=lambda *_: report(0, 0))
            expert.append(by_hand)
            limits = LENIENCE * np.where(by_hand.finished, by_hand.seconds, by_hand.limit_s)
        taught.append(measure(batch, limits, report))
    joined = Outcomes.concatenate(expert) if expert else None
    return Evaluation(behavior, scenario.name, tuple(seeds), Outcomes.concatenate(taught), joined, flag)


def find_success_flag(library: Library, behavior: str) -> str | None:
    """The flag by which a behavior is judged; None where it can raise none, so that the scenario's goal counts."""
    found = library.taught.get(behavior)
    return SUCCESS_FLAG if found is not None and SUCCESS_FLAG in found.automaton.flags else None


def link_for_evaluation(
    library: Library, behavior: str, scenario: Scenario, binding: Mapping[str, str] = NOTHING_BOUND
) -> Program:
    """The program that `evaluate` judges; raises what it would of the behavior, or where there is no goal for it."""
    if scenario.goal is None and find_success_flag(library, behavior) is None:
        raise SettingError(
            where=f"scenario {scenario.name!r}",
            setting="goal",
            problem="is missing, and a run cannot be evaluated without it",
            remedy="give it a [goal], or watch it with understudy run",
        )
    return link(library, behavior, binding)


def _batches(seeds: Sequence[int]) -> Iterator[tuple[int, list[int]]]:
    """So many seeds at a time as lie side by side, each with how many came before."""
    for first in range(0, len(seeds), WORLDS_AT_ONCE):
        yield first, list(seeds[first : first + WORLDS_AT_ONCE])


def interval_of_share(count: int, of: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share (Wilson 1927)."""
    if of == 0:
        return 0.0, 1.0
    share, square = count / of, Z95 * Z95 / of
    middle = (share + square / 2) / (1 + square)
    half = Z95 * sqrt(share * (1 - share) / of + square / (4 * of)) / (1 + square)
    return max(0.0, middle - half), min(1.0, middle + half)
