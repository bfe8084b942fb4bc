"""Measurement of batches of runs: time to finish, and food per second relative to a baseline.

A behavior that can raise the flag `done`, or a single other one, is finished when it raises it; any other when the
scenario's goal is reached.

A baseline is a controller written by hand for a scenario, found by entry points (`BASELINES`). A world that has one
has a time limit of three times the baseline's time; any other has the scenario's limit.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.evaluation_display import EvaluationDisplay
from understudy.analysis.intervals import interval_of_share as interval_of_share
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
"""A function that is called with the number of completed worlds and their total.

An exception that it raises ends the evaluation.
"""


def skip_progress(through: int, worlds: int) -> None:
    """Ignore a report of progress."""


BASELINES = "understudy.baselines"
"""Entry points of this group are functions that take a scenario and return its `Baseline`, or None."""

SUCCESS_FLAG, FAILURE_FLAG = "done", "failed"
"""The flags that a behavior raises when it has succeeded, and when it has given up."""

LENIENCE = 3.0
"""The time limit of a taught robot, in multiples of the baseline's time."""

TICKS_AT_ONCE = 200
"""The number of ticks simulated between two checks of which worlds have finished."""

WORLDS_AT_ONCE = 5_000
"""The largest number of worlds that are simulated together, to bound memory."""


@dataclass(frozen=True)
class Outcomes:
    """The results of N worlds, as columns of shape [N]."""

    seconds: Column
    """Time to finish, in s. NaN if the limit came first."""
    limit_s: Column
    """Time limit of each world, in s."""
    delivered: NDArray[np.int64]
    """Units of food delivered within that time."""
    gathered: NDArray[np.int64]
    """Boxes gathered within that time."""

    @property
    def finished(self) -> NDArray[np.bool_]:
        """True for each world [N] that finished in time."""
        return ~np.isnan(self.seconds)

    @property
    def success(self) -> float:
        """The share of worlds that finished in time."""
        return float(self.finished.mean())

    @property
    def food_per_s(self) -> Column:
        """Food delivered per second until the world finished or reached its limit [N]; NaN if no time passed."""
        spent = np.where(self.finished, self.seconds, self.limit_s)
        rate: Column = np.divide(self.delivered, spent, out=np.full(len(spent), np.nan), where=spent > 0)
        return rate

    @classmethod
    def concatenate(cls, parts: Sequence[Outcomes]) -> Outcomes:
        """Join the outcomes of several batches, in order."""
        return cls(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)))


class Controller(Protocol):
    """The interface of a controller that decides for N robots at once; `keys` lists the readings that it needs."""

    keys: Sequence[ReadingKey]

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of this tick."""
        ...


@dataclass(frozen=True)
class Baseline:
    """A controller written by hand for a scenario.

    `make_controller` makes the controller for a world of this scenario.
    """

    scenario: Scenario
    make_controller: Callable[[World], Controller]
    limits_s: Callable[[World], Column]
    """A function that returns the time limit of the baseline in each world [B], in s, which should be ample."""


def find_baseline(scenario: Scenario) -> Baseline | None:
    """Return the baseline of a scenario from the installed entry points, or None if there is none."""
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
    """Run a controller until each world has reached its goal or its limit (s, one for all or a column [B]).

    A world that is finished runs on, without being recorded, until all worlds are.
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
    """Run one program on all robots until each world has finished or reached its time limit.

    The limit is in s, one for all worlds or a column [B].

    With a `flag`, a world is finished once all its robots have raised it, whatever its goal; otherwise once its goal
    is reached. Many ticks are simulated at once if the whole program can be compiled. Reset the worlds before further
    use: without a flag they may have stopped at the tick in which each reached its goal.
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
    """Compute when the last robot of each world raised a flag [B], in s; NaN if one has not.

    A robot stays in the state that raises the flag, so the time at which it entered that state can be read later.
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


@dataclass(frozen=True, repr=False)
class Evaluation(EvaluationDisplay):
    """The results of a behavior in N worlds, and those of the baseline in the same worlds.

    Parameters
    ----------
    behavior
        Name of the behavior.
    world
        Name of the scenario.
    seeds
        Seed of each world.
    taught
        Results of the behavior.
    expert
        Results of the baseline. None if the scenario has none, or success was judged by a flag.
    flag
        Name of the flag that counted as success. None: the scenario's goal did.
    """

    behavior: str
    world: str
    seeds: tuple[int, ...]
    taught: Outcomes
    expert: Outcomes | None
    flag: str | None = None

    def __repr__(self) -> str:
        count = f"{int(self.taught.finished.sum())} of {len(self.seeds)} worlds"
        return f"<Evaluation of {self.behavior!r} in {self.world}: success in {count}>"

    @property
    def success(self) -> float:
        """The share of worlds that finished in time, from 0 to 1."""
        return self.taught.success

    @property
    def relative(self) -> Column:
        """The behavior's food per second divided by the baseline's [N].

        It is NaN without a baseline, and in worlds where the baseline delivers no food.
        """
        absent = np.full(len(self.seeds), np.nan)
        if self.expert is None:
            return absent
        expert = self.expert.food_per_s
        ratio: Column = np.divide(self.taught.food_per_s, expert, out=absent, where=expert > 0)
        return ratio

    @property
    def relative_to_expert(self) -> float:
        """The median of `relative` over the worlds in which it is not NaN; NaN if it is NaN in all."""
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
    """Evaluate a behavior of a library in one world per seed, in which all robots run it.

    A behavior that can raise the flag `done` succeeds if all robots raise it in time, any other if the scenario's
    goal is reached in time. If the goal counts and the scenario has a baseline, the limit is three times the
    baseline's time; otherwise it is the scenario's.

    Parameters
    ----------
    library
        The library.
    behavior
        Name of the basic behavior or automaton to evaluate.
    world
        The scenario, or its name or path.
    seeds
        Seeds of the worlds, at least one.
    binding
        Name of a target by parameter of the behavior.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the evaluation. None: no reports.

    Returns
    -------
    Evaluation
        The results by world, and those of the baseline if there is one.

    Raises
    ------
    SettingError
        If `seeds` is empty or no list, or neither a goal nor the flag `done` defines success.
    UnknownName
        If there is no such behavior or scenario.
    UnboundParameter
        If a parameter of the behavior is not bound to a target.
    FileError
        If `world` is the path of a file that cannot be read or is no scenario.
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
    """Evaluate a behavior of coordinators, or of one of several types of robots, in one world per seed.

    Success is defined as in `evaluate`. An automaton is run by all agents of the given `sort`, a basic behavior by
    all robots that have it. Agents below a coordinator follow its orders.
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
    """Run a simulated team until each world has finished or reached its limit (s, one for all or a column [B]).

    With a `flag`, a world is finished once all agents of the given `sorts` have raised it; otherwise once its goal is
    reached.
    """
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
    """Return in which worlds [B] all agents of these sorts have raised a flag."""
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
    """Evaluate in batches of worlds with the function `measure`, and the baseline too if the goal counts as success."""
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
    """Return the flag by which a behavior is judged: `done`, or else its only one besides `failed`.

    None if it has no such flag, and the scenario's goal counts.
    """
    found = library.taught.get(behavior)
    flags = set() if found is None else {*found.automaton.flags}
    goals = flags & {SUCCESS_FLAG} or flags - {FAILURE_FLAG}
    return goals.pop() if len(goals) == 1 else None


def link_for_evaluation(
    library: Library, behavior: str, scenario: Scenario, binding: Mapping[str, str] = NOTHING_BOUND
) -> Program:
    """Link the program that `evaluate` runs; refuse a behavior for whose success the scenario defines no goal."""
    if scenario.goal is None and find_success_flag(library, behavior) is None:
        raise SettingError(
            where=f"scenario {scenario.name!r}",
            setting="goal",
            problem="is missing, and a run cannot be evaluated without it",
            remedy="give it a [goal], or watch it with understudy run",
        )
    return link(library, behavior, binding)


def _batches(seeds: Sequence[int]) -> Iterator[tuple[int, list[int]]]:
    """Yield batches of seeds to simulate together, each with the number of seeds before it."""
    for first in range(0, len(seeds), WORLDS_AT_ONCE):
        yield first, list(seeds[first : first + WORLDS_AT_ONCE])
