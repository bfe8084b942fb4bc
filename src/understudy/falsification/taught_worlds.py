"""Teach until it holds: whether what was taught works in a wanted share of new worlds, and if not, where it goes wrong.

Each version of an automaton is tested in worlds of its own, one batch after the other, until an interval that is valid
at every look lies on one side of the wanted share. A world in which it went wrong is the next situation to teach in; it
never counts for a later version.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, islice

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.behavior_run import ProgramRun
from understudy.analysis.evaluate import find_success_flag, make_evaluation_task
from understudy.analysis.lesson_score import LONGEST_RUN_S
from understudy.analysis.measurement import TICKS_BETWEEN_READINGS, Progress, skip_progress
from understudy.analysis.raised_range import find_shown_goal
from understudy.analysis.sequential_interval import count_fewest_trials, interval_of_share_at_any_time
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.trial import GoalMeasure
from understudy.learning.shown_ranges import ShownRange
from understudy.model.describe import format_value
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.properties.run_property import Verdict
from understudy.runtime.program import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

WANTED = 0.95
"""The share of new worlds in which a behavior has to work."""
ERROR = 0.05
"""The probability with which anything that is said about any version of an automaton may be wrong, all together."""
MORE_WORLDS = 50
"""The number of worlds that are added at a time while it is not decided."""
MOST_WORLDS = 1_000
"""The largest number of worlds for one version."""
NEARER = 0.02
"""The share of the way to where a flag was shown by which a robot has to come nearer to make progress."""


@dataclass(frozen=True, slots=True)
class Mistake:
    """A world in which a behavior does not do what it was taught for.

    Parameters
    ----------
    seed
        The seed of the world.
    binding
        The target of each parameter.
    wrong_s
        When it went wrong, s: when it raised its flag elsewhere, or when it came no nearer.
    why
        What happened, in words.
    """

    seed: int
    binding: Mapping[str, str]
    wrong_s: float
    why: str


@dataclass(frozen=True, slots=True)
class HoldingResult:
    """The result of testing one version of an automaton in new worlds.

    Parameters
    ----------
    verdict
        Whether it works in the wanted share of worlds.
    held
        The number of worlds in which it works.
    worlds
        The number of worlds that were run.
    interval
        An interval of the share, valid at every look, and for all versions together.
    mistakes
        The worlds in which it does not work.
    """

    verdict: Verdict
    held: int
    worlds: int
    interval: tuple[float, float]
    mistakes: tuple[Mistake, ...]


@dataclass
class HoldingTest:
    """Tests versions of an automaton, each in new worlds, until it is decided whether it works in a share of them.

    Parameters
    ----------
    scenario
        The scenario.
    first_seed
        The first seed. Each world is run for one version only.
    wanted
        The share of worlds in which it has to work.
    """

    scenario: Scenario
    first_seed: int
    wanted: float = WANTED
    versions: int = 0
    """The number of versions that were tested."""
    _seeds: Iterator[int] = field(init=False)

    def __post_init__(self) -> None:
        self._seeds = count(self.first_seed)

    def test(
        self,
        library: Library,
        behavior: str,
        bindings: Sequence[Mapping[str, str]],
        *,
        progress: Progress = skip_progress,
    ) -> HoldingResult:
        """Test the next version.

        Parameters
        ----------
        library
            The library with this version.
        behavior
            Name of the behavior.
        bindings
            The targets that it is run with, in turn.
        progress
            Function called repeatedly with the number of completed worlds and their total; an exception that it raises
            ends the test.

        Returns
        -------
        HoldingResult
            The result: undecided if MOST_WORLDS worlds did not decide it.

        Raises
        ------
        SettingError
            If the behavior has no flag, and the scenario no goal.
        UnboundParameter
            If a parameter is not bound to a target.
        """
        self.versions += 1
        level = 1.0 - ERROR / (self.versions * (self.versions + 1))  # these sum up to ERROR
        held, worlds, mistakes = 0, 0, list[Mistake]()
        size = count_fewest_trials(self.wanted, level=level)
        while True:
            for number, binding in enumerate(bindings):
                some = list(islice(self._seeds, len(range(number, size, len(bindings)))))
                found = find_mistakes(library, behavior, self.scenario, some, binding, progress=progress)
                held, worlds, mistakes = held + len(some) - len(found), worlds + len(some), mistakes + found
            low, high = interval_of_share_at_any_time(held, worlds, level=level)
            verdict = Verdict.HOLDS if low >= self.wanted else Verdict.UNDECIDED
            verdict = Verdict.FAILS if high < self.wanted else verdict
            if verdict is not Verdict.UNDECIDED or worlds >= MOST_WORLDS:
                return HoldingResult(verdict, held, worlds, (low, high), tuple(mistakes))
            size = MORE_WORLDS


def find_mistakes(
    library: Library,
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    binding: Mapping[str, str],
    *,
    progress: Progress = skip_progress,
) -> list[Mistake]:
    """Find the worlds in which a behavior does not do what it was taught for, and when it goes wrong there.

    A behavior with a flag has to raise it where that was shown; any other has to reach the scenario's goal.

    Parameters
    ----------
    library
        The library, whose behavior all robots run.
    behavior
        Name of the behavior.
    scenario
        The scenario.
    seeds
        The seed of each world.
    binding
        The target of each parameter.
    progress
        Function called repeatedly with the number of completed worlds and their total.

    Returns
    -------
    list[Mistake]
        The worlds, in order.

    Raises
    ------
    SettingError
        If the behavior has no flag, and the scenario no goal.
    UnboundParameter
        If a parameter is not bound to a target.
    """
    flag = find_success_flag(library, behavior)
    if flag is not None:
        shown = find_shown_goal(library, behavior, flag)
        return _run_to_flag(library, behavior, World(scenario, seeds), binding, flag, shown, progress)
    task = make_evaluation_task(library, behavior, scenario, binding=binding)
    results = GoalMeasure(task)([Trial(scenario, seed) for seed in seeds])
    progress(len(seeds), len(seeds))
    rows = np.flatnonzero(results.failed).tolist()
    why = "the goal of the world was not reached"
    return [Mistake(seeds[row], binding, float(results.progress_s[row]), why) for row in rows]


def _run_to_flag(
    library: Library,
    behavior: str,
    world: World,
    binding: Mapping[str, str],
    flag: str,
    shown: ShownRange | None,
    progress: Progress,
) -> list[Mistake]:
    """Run worlds until their robots have raised a flag; return those in which that is elsewhere, or never happens."""
    run = ProgramRun(world, link(library, behavior, binding), library, binding, worlds=world.worlds)
    read = None if shown is None else run.find_reading(str(shown.feature)).read
    limit_s = min(world.scenario.limit_s, LONGEST_RUN_S)
    nearest, nearest_s = np.full(world.worlds, np.inf), np.zeros(world.worlds)
    values = np.full((world.worlds, world.robots), np.nan)
    raised = np.zeros(world.worlds, np.bool_)
    first: Column | None = None
    for tick in range(TICKS_BETWEEN_READINGS, round(limit_s / world.tick_s) + 1, TICKS_BETWEEN_READINGS):
        run.advance_all(TICKS_BETWEEN_READINGS)
        if read is not None and shown is not None:
            now = read()
            values[~raised] = now[~raised]
            gap = shown.measure_gap(now).max(axis=1)
            first = np.maximum(gap, 1e-9) if first is None else first
            nearer = ~raised & (gap < nearest - NEARER * first)
            nearest[nearer], nearest_s[nearer] = gap[nearer], tick * world.tick_s
        raised |= run.find_raised(flag)
        progress(int(raised.sum()), world.worlds)
        if raised.all():
            break
    times = run.find_raised_s(flag).max(axis=1)
    works: NDArray[np.bool_] = raised if shown is None else raised & shown.contains(values).all(axis=1)
    mistakes = []
    for row in np.flatnonzero(~works).tolist():
        if raised[row] and shown is not None:
            at = format_value(shown.feature, float(values[row, ~shown.contains(values[row])][0]))
            why = f"{flag} where {shown.feature} is {at}, shown at {shown.describe()}"
            mistakes.append(Mistake(world.seeds[row], binding, float(times[row]), why))
        else:
            why = f"it comes no nearer, and is not {flag} after {limit_s:.0f} s"
            mistakes.append(Mistake(world.seeds[row], binding, float(nearest_s[row]), why))
    return mistakes
