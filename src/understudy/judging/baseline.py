"""Controllers written by hand for a scenario, which behaviors are compared with; entry points find them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.entry_points import BASELINES, list_entry_points, load_object
from understudy.errors import SettingError, UnknownName
from understudy.judging.behavior_run import BehaviorRun, RunReading
from understudy.judging.outcomes import Outcomes, measure_success
from understudy.judging.rollout import Progress, skip_progress
from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

REMEDY = "let the entry point name a function from a scenario to its Baseline, or None"

LENIENCE = 3.0
"""The time limit of a taught robot, in multiples of the baseline's time."""


DecideCommands: TypeAlias = Callable[[Percept], Commands]


class Controller(Protocol):
    """The interface of a controller that decides for N robots at once; `keys` lists the readings that it needs."""

    keys: Sequence[ReadingKey]

    def decide(self, percept: Percept) -> Commands:
        """Decide on the readings of a tick.

        Parameters
        ----------
        percept
            A column for each of `keys`: float64 [N], NaN where the reading is absent.

        Returns
        -------
        Commands
            A column for each channel: finite float64 [N]. A channel that is left out rests.
        """
        ...


@dataclass(frozen=True)
class Baseline:
    """A controller written by hand for a scenario, which behaviors are compared with.

    Parameters
    ----------
    scenario
        The scenario in which it is measured.
    make_controller
        Function that makes the controller for a `World` of the scenario. It may keep memory from tick to tick; all
        calls come from one thread.
    limits_s
        Function that returns the time limit of the baseline in each of the B worlds of a `World`, in s: finite float64
        [B] above 0, which should be ample.
    """

    scenario: Scenario
    make_controller: Callable[[World], Controller]
    limits_s: Callable[[World], Column]


def find_baseline(scenario: Scenario) -> Baseline | None:
    """Return the baseline of a scenario from the installed entry points, or None if there is none."""
    for name in list_entry_points(BASELINES):
        function = load_object(name, BASELINES, where="baseline", remedy=REMEDY)
        if not callable(function):
            raise _refuse(name, f"is a {type(function).__name__}")
        baseline = function(scenario)
        if isinstance(baseline, Baseline):
            return baseline
        if baseline is not None:
            raise _refuse(name, f"returned a {type(baseline).__name__}")
    return None


def _refuse(name: str, problem: str) -> SettingError:
    return SettingError(where="baseline", setting=repr(name), problem=problem, remedy=REMEDY)


class ControllerRun(BehaviorRun):
    """Robots in B worlds that a controller drives. It has no flags, and reads only what it decides by.

    Parameters
    ----------
    world
        The worlds.
    decide
        Returns the commands of a tick, given what was sensed.
    keys
        The readings that it needs.
    """

    def __init__(self, world: World, decide: DecideCommands, keys: Sequence[ReadingKey]) -> None:
        super().__init__(world, world.worlds)
        self._decide, self._keys = decide, keys

    def _tick(self) -> None:
        self.body.act(self._decide(self.body.sense(self._keys)))

    def find_raised_agents(self, flag: str) -> NDArray[np.bool_]:
        """Raise UnknownName."""
        raise UnknownName(what="flag", name=flag, where="a controller", known=())

    def find_reading(self, text: str) -> RunReading:
        """Raise UnknownName."""
        raise UnknownName(what="reading", name=text, where="a controller", known=())


def measure_baseline(
    baseline: Baseline, seeds: Sequence[int], *, progress: Progress = skip_progress
) -> Outcomes:
    """Measure a baseline on one world per seed."""
    world = World(baseline.scenario, seeds)
    controller = baseline.make_controller(world)
    run = ControllerRun(world, controller.decide, controller.keys)
    return measure_success(run, baseline.limits_s(world), progress=progress)
