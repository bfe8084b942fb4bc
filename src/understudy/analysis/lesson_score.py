"""The score of a behavior while it is taught: in how many new worlds it works, before and after a press."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.baseline import LENIENCE, find_baseline, measure_baseline
from understudy.analysis.evaluate import find_flags, find_success_flag
from understudy.analysis.goal_runs import Criteria, run_many_ticks
from understudy.analysis.measurement import Progress, skip_progress
from understudy.analysis.paired_tests import compute_mcnemar_p
from understudy.analysis.raised_range import RaisedRange, find_shown_goal
from understudy.errors import SettingError
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

Trend: TypeAlias = Literal["", "rising", "falling", "slower"]
"""What changed between two scores."""
CHANCE = 0.1
"""The largest p-value (McNemar's test, two-sided) at which a difference between the same worlds is no chance."""
SLOWER = 1.25
"""How many times as long a behavior takes to be called slower, in the worlds in which it works before and after."""
LONGEST_RUN_S = 120.0
"""The longest time that a behavior with a flag is given for each of its targets, s."""


@dataclass(frozen=True)
class LessonScore:
    """The results of a behavior in K new worlds.

    Parameters
    ----------
    behavior
        Name of the behavior.
    works
        In which worlds it did what it was taught for [K].
    seconds
        How long it took [K], s; NaN where it did not.
    raised
        Where its flag was raised, for each time that the behavior was run. Empty without a flag, or if presses for it
        have nothing in common.
    """

    behavior: str
    works: NDArray[np.bool_]
    seconds: Column
    raised: tuple[RaisedRange, ...] = ()

    @property
    def worlds(self) -> int:
        """The number of worlds."""
        return len(self.works)

    @property
    def count(self) -> int:
        """The number of worlds in which the behavior works."""
        return int(self.works.sum())

    @property
    def elsewhere(self) -> int:
        """How often the flag was raised where it was not shown."""
        return sum(each.elsewhere for each in self.raised)

    def describe(self) -> str:
        """Return the score in words: "goto works in 97 of 100 new worlds"."""
        return f"{self.behavior} works in {self.count} of {self.worlds} new worlds"


@dataclass(frozen=True)
class ScoreChange:
    """The scores of a behavior in the same new worlds, before and after a press.

    Parameters
    ----------
    before
        The score before it. None: there was nothing to run.
    after
        The score after it.
    """

    before: LessonScore | None
    after: LessonScore

    @property
    def has_fallen(self) -> bool:
        """Whether the behavior works in fewer worlds than before, by more than chance."""
        return self._is_beyond_chance(-1)

    @property
    def has_risen(self) -> bool:
        """Whether the behavior works in more worlds than before, by more than chance."""
        return self._is_beyond_chance(1)

    def _is_beyond_chance(self, sign: int) -> bool:
        if self.before is None:
            return False
        lost = int((self.before.works & ~self.after.works).sum())
        won = int((self.after.works & ~self.before.works).sum())
        return sign * (won - lost) > 0 and compute_mcnemar_p(lost, won) <= CHANCE

    @property
    def times_slower(self) -> float:
        """How many times as long the behavior takes, in the median of the worlds in which it works before and after."""
        if self.before is None:
            return 1.0
        both = self.before.works & self.after.works
        was, now = self.before.seconds[both], self.after.seconds[both]
        ratio = now[was > 0] / was[was > 0]
        return float(np.median(ratio)) if len(ratio) else 1.0

    @property
    def trend(self) -> Trend:
        """What changed by more than chance; empty if nothing did."""
        if self.has_fallen:
            return "falling"
        if self.has_risen:
            return "rising"
        return "slower" if self.times_slower > SLOWER else ""

    def describe(self) -> str:
        """Return the change in words."""
        said, was = self.after.describe(), 0 if self.before is None else self.before.count
        words = {
            "falling": f", and before this press in {was}",
            "rising": f", up from {was}",
            "slower": f", and takes {self.times_slower:.1f} times as long as before",
            "": "",
        }
        return said + words[self.trend]


@dataclass(frozen=True)
class ScoreWorlds:
    """The worlds of a score: their scenario, their seeds, and how long each may take.

    Parameters
    ----------
    scenario
        The scenario.
    seeds
        The seed of each world.
    limits
        How long a behavior without a flag may take to reach the scenario's goal, s, for all or each [K].
    """

    scenario: Scenario
    seeds: Sequence[int]
    limits: float | Column

    @classmethod
    def from_seeds(cls, scenario: Scenario, seeds: Sequence[int], *, by_flag: bool) -> Self:
        """Make the worlds of some seeds; without a flag, the baseline sets the limits if there is one."""
        baseline = None if by_flag else find_baseline(scenario)
        if baseline is None:
            return cls(scenario, seeds, scenario.limit_s)
        expert = measure_baseline(baseline, seeds)
        return cls(scenario, seeds, LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s))


def score_behavior(
    library: Library,
    behavior: str,
    worlds: ScoreWorlds,
    bindings: Sequence[Mapping[str, str]],
    *,
    progress: Progress = skip_progress,
) -> LessonScore:
    """Run a behavior in new worlds, and count those in which it does what it was taught for.

    A behavior with a flag is run for each binding in turn, and works in a world if all its agents raise the flag each
    time, at values that agree with what was shown. Any other works where the scenario's goal is reached in time.

    Parameters
    ----------
    library
        The library, whose behavior all robots run.
    behavior
        Name of the behavior.
    worlds
        The worlds.
    bindings
        The target of each parameter, for each time that the behavior is run. A world goes on where the time before
        ended.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the runs.

    Returns
    -------
    LessonScore
        The score.

    Raises
    ------
    SettingError
        If the behavior has no flag, and the scenario no goal.
    UnboundParameter
        If a parameter is not bound to a target.
    """
    scenario = worlds.scenario
    flag = find_success_flag(library, behavior)
    if flag is None and scenario.goal is None:
        raise SettingError(
            where=f"scenario {scenario.name!r}",
            setting="goal",
            problem=f"is missing, and {behavior} has no flag",
            remedy="give either",
        )
    shown = find_shown_goal(library, behavior, flag)
    criteria = Criteria(flag, find_flags(library, behavior), {}, {}, shown)
    world = World(scenario, worlds.seeds)
    limits = worlds.limits if flag is None else min(scenario.limit_s, LONGEST_RUN_S)
    works, seconds, raised = np.ones(world.worlds, np.bool_), np.zeros(world.worlds), list[RaisedRange]()
    for binding in bindings[:1] if flag is None else bindings:
        program = link(library, behavior, binding)
        part = run_many_ticks(
            world, program, library, binding, criteria, limits, progress, stops=flag is None
        )
        works &= part.outcomes.finished if part.raised is None else part.raised.agrees
        seconds += part.outcomes.seconds
        raised += [] if part.raised is None else [part.raised]
    return LessonScore(behavior, works, np.where(works, seconds, np.nan), tuple(raised))
