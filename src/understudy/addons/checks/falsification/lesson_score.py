"""The score of a behavior while it is taught: in how many new worlds it works, and at which decisions it went wrong.

Scores before and after a press are compared. A decision is known by its state and its feature vector. Where the
behavior raised its flag elsewhere than shown, it is the decision that raised it. Where it came no nearer, these are its
decisions in the time after that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorlds, NewWorldsResult
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.coaching.advice import WrongDecisions
from understudy.coaching.lesson_analysis import MetDecision
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.paired_tests import compute_mcnemar_p
from understudy.judging.rollout import Progress, skip_progress
from understudy.model.library import Library
from understudy.model.value_kinds import Column
from understudy.sim.world import World

Trend: TypeAlias = Literal["", "rising", "falling", "slower"]
"""What changed between two scores."""
CHANCE = 0.1
"""The largest p-value (McNemar's test, two-sided) at which a difference between the same worlds is no chance."""
LEAST_FALL = 0.05
"""The smallest share of worlds that a behavior has to lose to be called worse."""
SLOWER = 1.25
"""How many times as long a behavior takes to be called slower, in the worlds in which it works before and after."""
AFTER_S, EVERY_S = 20.0, 2.0
"""For how long the decisions of a robot that comes no nearer are looked at, and how often, s."""


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
    others
        What the other agents did: "the other robots idle"; empty if there are none.
    mistakes
        The worlds in which it did not, with the target of each parameter and the time.
    raised
        The values at which the flag was raised where it worked, in no order; none if it counts wherever it is raised.
    """

    behavior: str
    works: NDArray[np.bool_]
    seconds: Column
    others: str = ""
    mistakes: tuple[Mistake, ...] = ()
    raised: Column = field(default_factory=lambda: np.empty(0))

    @property
    def worlds(self) -> int:
        """The number of worlds."""
        return len(self.works)

    @property
    def count(self) -> int:
        """The number of worlds in which the behavior works."""
        return int(self.works.sum())

    def describe(self) -> str:
        """Return the score in words: "goto works in 97 of 100 new worlds (the other robots idle)"."""
        others = f" ({self.others})" if self.others else ""
        return f"{self.behavior} works in {self.count} of {self.worlds} new worlds{others}"


@dataclass(frozen=True)
class ScoreChange:
    """The scores of a behavior in the same new worlds, before and after a press.

    Parameters
    ----------
    before
        The score before it. None: there was nothing to run.
    after
        The score after it.
    goal
        Where a flag counted in both, in words: "distance_to(A) was 0.17 to 0.44 m where it was pressed", or that it
        counts wherever it is raised. Empty if there is another goal.
    is_measured
        Whether success is measured: a flag that counts wherever it is raised is only the robot's own word.
    is_goal_present
        Whether this is what success means now. It is not if a feature was removed since the last press.
    """

    before: LessonScore | None
    after: LessonScore
    goal: str = ""
    is_measured: bool = True
    is_goal_present: bool = True

    @property
    def has_fallen(self) -> bool:
        """Whether the behavior works in fewer worlds than before, by more than chance; False if it is not measured."""
        if self.before is None or not self.is_measured:
            return False
        lost = self.before.count - self.after.count
        return lost >= LEAST_FALL * self.after.worlds and self._is_beyond_chance(-1)

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
        was = 0 if self.before is None else self.before.count
        words = {
            "falling": f", and before the last change in {was}",
            "rising": f", up from {was}",
            "slower": f", and takes {self.times_slower:.1f} times as long as before",
            "": "",
        }
        is_own_word = not self.is_measured and self.after.count > 0
        is_goal_said = self.trend == "falling" or is_own_word or not self.is_goal_present
        goal = f" ({self.goal})" if self.goal and is_goal_said else ""
        return f"{self.after.describe()}{words[self.trend]}{goal}"


def score_behavior(
    library: Library,
    behavior: str,
    worlds: NewWorlds,
    bindings: Sequence[Mapping[str, str]],
    *,
    progress: Progress = skip_progress,
) -> LessonScore:
    """Run a behavior in new worlds, and count those in which it does what it was taught for with each of its targets.

    Parameters
    ----------
    library
        The library of the trained agent.
    behavior
        Name of the behavior.
    worlds
        The worlds.
    bindings
        The targets of its parameters, each of which it is run with in all worlds.
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
        If the behavior has no goal of its own, and the scenario none.
    UnboundParameter
        If a parameter is not bound to a target.
    """

    def run(index: int, binding: Mapping[str, str]) -> NewWorldsResult:
        def report(done: int, total: int) -> None:
            progress(index * total + done, len(bindings) * total)

        return worlds.run(library, behavior, binding, progress=report)

    results = [run(index, binding) for index, binding in enumerate(bindings)]
    works = np.logical_and.reduce([each.works for each in results])
    seconds = np.sum([each.seconds for each in results], axis=0)
    mistakes = tuple(mistake for each in results for mistake in each.mistakes)
    raised = np.concatenate([each.raised for each in results])
    return LessonScore(behavior, works, seconds, worlds.setup.describe_others(behavior), mistakes, raised)


def find_wrong_decisions(library: Library, setup: SessionSetup, score: LessonScore) -> WrongDecisions:
    """Run a behavior again in the worlds in which it went wrong, and find what it decided there.

    Parameters
    ----------
    library
        The library with the behavior.
    setup
        What runs in the worlds; a robot is trained there.
    score
        The score of the behavior in these worlds.

    Returns
    -------
    WrongDecisions
        The decisions in each failing world.
    """
    by_binding: dict[tuple[tuple[str, str], ...], list[Mistake]] = {}
    for mistake in score.mistakes:
        by_binding.setdefault(tuple(mistake.binding.items()), []).append(mistake)
    why, met = dict[int, str](), list[MetDecision]()
    for binding, mistakes in by_binding.items():
        for mistake, decision in _list_decisions(library, score.behavior, setup, dict(binding), mistakes):
            why.setdefault(mistake.seed, mistake.why)
            met.append(decision)
    return WrongDecisions(score.worlds, why, met)


def _list_decisions(
    library: Library,
    behavior: str,
    setup: SessionSetup,
    binding: Mapping[str, str],
    mistakes: Sequence[Mistake],
) -> Iterator[tuple[Mistake, MetDecision]]:
    """Yield the decisions from each mistake on, with the mistake, until the robot raises a flag."""
    run = setup.start([each.seed for each in mistakes], library, behavior, binding)
    if not isinstance(run, ProgramRun) or not isinstance(run.body, World):
        return
    world, automaton = run.body, library.taught[behavior].automaton
    looks = _list_looks(mistakes, world.tick_s)
    for tick in sorted(looks):
        run.advance(tick - run.ticks)
        decisions = run.engine.read_decisions([row * world.robots + setup.agent for row in looks[tick]])
        for row, (place, values) in zip(looks[tick], decisions, strict=True):
            if automaton.state(place.state).flag is None:
                met = MetDecision(mistakes[row].seed, float(world.time_s), place.state, values)
                yield mistakes[row], met


def _list_looks(mistakes: Sequence[Mistake], tick_s: float) -> dict[int, list[int]]:
    """List the ticks before which decisions are looked at, with the places of the mistakes that these concern."""
    every, looks = max(1, round(EVERY_S / tick_s)), dict[int, list[int]]()
    for row, mistake in enumerate(mistakes):
        first = max(0, round(mistake.wrong_s / tick_s) - 1)  # it raised its flag by the end of a tick
        later = range(first - first % every + every, first + round(AFTER_S / tick_s), every)
        for tick in (first, *later):
            looks.setdefault(tick, []).append(row)
    return looks
