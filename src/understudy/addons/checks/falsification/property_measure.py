"""Runs of a behavior until it is known whether a property holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import GoalMeasure, TrialMeasure, TrialResults, WrongMoment
from understudy.errors import SettingError
from understudy.judging.evaluate import find_runners, make_evaluation_task
from understudy.judging.properties.condition import parse_condition
from understudy.judging.properties.margins import bind_condition
from understudy.judging.properties.monitor import monitor_property
from understudy.judging.properties.offered_goals import find_behavior_success
from understudy.judging.properties.run_property import check_property, make_property_task
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.library import Library
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries


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
    is_cause_later = False

    @property
    def name_in_file(self) -> str | None:
        """The name of the property in the library's file; None for a chosen goal, which is part of a lesson."""
        start = self.subject.start
        return self.subject.name if isinstance(start, SeededWorlds) and start.seeds else None

    def get_limit(self, scenario: Scenario) -> float:
        """Return the longest run in a scenario, s."""
        if self.subject.kind is PropertyKind.ALWAYS and self.subject.seconds is not None:
            return self.subject.seconds
        start = self.subject.start
        longest_s = start.limit_s if isinstance(start, SeededWorlds) else None
        return next(each for each in (self.limit_s, longest_s, scenario.limit_s) if each is not None)

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

    def find_wrong_moment(self, trial: Trial, *, until_s: float) -> WrongMoment:
        """Find the moment at which the property failed."""
        tick_s = trial.scenario.tick_s
        tick = round(min(float(self([trial]).failed_s[0]), until_s) / tick_s)
        return WrongMoment(tick, "failed", f"At {tick * tick_s:.1f} s it failed: {self.subject.claim}.")

    def choose_robot(self, trial: Trial, wrong: int) -> int:
        """Choose the robot for which the condition of the property was farthest from what is demanded.

        If the condition is not about each robot, it is the same robot as for a goal.
        """
        run, kind = self.start([trial]), self.subject.kind
        if kind is PropertyKind.PROGRESS:
            return super().choose_robot(trial, wrong)
        run.advance(wrong)
        margins = bind_condition(parse_condition(self.subject.what), run, self.task.criteria.flags)()[0]
        if len(margins) != run.get_world().robots:
            return super().choose_robot(trial, wrong)
        return int(margins.argmin() if kind is PropertyKind.ALWAYS else margins.argmax())


def make_success_measure(
    library: Library | Libraries,
    behavior: str,
    scenario: Scenario,
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    limit_s: float | None = None,
) -> TrialMeasure:
    """Make what runs a behavior and judges it by what success means for it.

    Parameters
    ----------
    library
        The library, whose behavior all robots run; or for a team the library of each sort of agents.
    behavior
        Name of the behavior, in a team with the sort of agents before it: SORT/BEHAVIOR.
    scenario
        The scenario.
    binding
        The target of each parameter.
    limit_s
        The time limit, s. None: that of the chosen goal, or of each scenario.

    Returns
    -------
    TrialMeasure
        By the goal that was chosen for the behavior; without one by its flag, where it was shown, or by the goal of the
        scenario.

    Raises
    ------
    UnderstudyError
        If the behavior cannot be run or measured there.
    """
    _, _, name, own = find_runners(library, behavior, scenario)
    success = find_behavior_success(own, name)
    if not isinstance(success, Property):
        task = make_evaluation_task(library, behavior, scenario, binding=binding, limit_s=limit_s)
        return GoalMeasure(task, limit_s)
    subject = replace(success, behavior=behavior, targets=Binding(dict(binding)))
    return make_property_measure(subject, library, scenario, limit_s=limit_s)


def make_property_measure(
    subject: Property, library: Library | Libraries, scenario: Scenario, *, limit_s: float | None
) -> PropertyMeasure:
    """Make what runs a property's behavior and judges it by the property; see `check_property` for the errors."""
    task = make_property_task(subject, library, scenario)
    check_property(subject, task, scenario)
    return PropertyMeasure(task, limit_s, subject=subject)


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
    chosen = next((each for each in properties if each.name == name), None)
    if chosen is None:
        names = ", ".join(each.name for each in properties) or "none"
        raise SettingError(
            where="falsify",
            setting="--property",
            problem=f"names {name!r}, which {file} does not have",
            remedy=f"its properties are {names}",
        )
    if behavior not in (chosen.behavior, chosen.behavior.rpartition("/")[2]):
        raise SettingError(
            where="falsify",
            setting="--property",
            problem=f"names {name!r}, which is about {chosen.behavior}",
            remedy=f"give {chosen.behavior} as NAME, or a property of {behavior}",
        )
    return chosen
