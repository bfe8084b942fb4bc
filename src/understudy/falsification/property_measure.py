"""Runs of a behavior until it is known whether a property holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from understudy.errors import SettingError
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.trial import TrialMeasure, TrialResults
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.properties.condition import parse_condition
from understudy.properties.margins import bind_condition
from understudy.properties.monitor import monitor_property
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World


@dataclass(frozen=True, kw_only=True)
class PropertyMeasure(TrialMeasure):
    """Runs of a behavior until it is known whether a property holds.

    The robustness is that of the property, see `monitor_property`. A run went wrong when the property failed.

    Parameters
    ----------
    subject
        The property. Where its runs start is not used.
    """

    subject: Property
    is_cause_later, wrong_label = False, "failed"

    def get_limit(self, scenario: Scenario) -> float:
        """Return the longest run in a scenario, s."""
        if self.subject.kind is PropertyKind.ALWAYS and self.subject.seconds is not None:
            return self.subject.seconds
        start = self.subject.start
        given = start.limit_s if isinstance(start, SeededWorlds) else None
        return next(each for each in (self.limit_s, given, scenario.limit_s) if each is not None)

    def run_together(self, trials: Sequence[Trial]) -> TrialResults:
        """Run the behavior in worlds that differ only in places and amounts, and observe the property."""
        outcomes = monitor_property(
            self.subject,
            self.start(trials),
            self.task.criteria.flags,
            limit_s=self.get_limit(trials[0].scenario),
        )
        states = np.empty(len(trials), np.object_)
        states[:] = [frozenset[str]()] * len(trials)
        return TrialResults(outcomes.robustness, outcomes.failed_s, outcomes.failed_s, states)

    def find_wrong_tick(self, trial: Trial, *, until_s: float) -> int:
        """Find the tick at which the property failed."""
        failed_s = float(self([trial]).failed_s[0])
        return round(min(failed_s, until_s) / trial.scenario.tick_s)

    def choose_robot(self, trial: Trial, wrong: int) -> int:
        """Choose the robot for which the condition of the property was farthest from what is demanded.

        If the condition is not about each robot, it is the same robot as for a goal.
        """
        run = self.start([trial])
        kind, world = self.subject.kind, run.body
        if kind is PropertyKind.PROGRESS or not isinstance(world, World):
            return super().choose_robot(trial, wrong)
        run.advance_all(wrong)
        margins = bind_condition(parse_condition(self.subject.what), run, self.task.criteria.flags)()[0]
        if len(margins) != world.robots:
            return super().choose_robot(trial, wrong)
        return int(margins.argmin() if kind is PropertyKind.ALWAYS else margins.argmax())

    def describe_wrong_time(self, wrong_s: float) -> str:
        """Describe the failure of the property."""
        return f"At {wrong_s:.1f} s it failed: {self.subject.claim}."


def choose_property(properties: Sequence[Property], name: str, *, behavior: str, file: str) -> Property:
    """Choose a property of a behavior by its name.

    Parameters
    ----------
    properties
        The properties of a file.
    name
        Name of the property.
    behavior
        Name of the behavior, with the sort of agents before it or without.
    file
        The file, for errors.

    Returns
    -------
    Property
        The property.

    Raises
    ------
    SettingError
        If there is none of that name, or it is about another behavior.
    """
    found = next((each for each in properties if each.name == name), None)
    if found is None:
        known = ", ".join(each.name for each in properties) or "none"
        raise SettingError(
            where="falsify",
            setting="--property",
            problem=f"names {name!r}, which {file} does not have",
            remedy=f"its properties are {known}",
        )
    if behavior not in (found.behavior, found.behavior.rpartition("/")[2]):
        raise SettingError(
            where="falsify",
            setting="--property",
            problem=f"names {name!r}, which is about {found.behavior}",
            remedy=f"give {found.behavior} as NAME, or a property of {behavior}",
        )
    return found
