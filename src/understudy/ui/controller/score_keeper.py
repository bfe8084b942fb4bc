"""The score of the automaton in training, taken after each press in new worlds, beside the world."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import partial
from threading import RLock
from time import sleep

from understudy.addons.checks.falsification.lesson_score import (
    LessonScore,
    ScoreChange,
    Trend,
    score_behavior,
)
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup, offer_session_goals
from understudy.errors import SessionError
from understudy.judging.properties.offered_goals import describe_goal, find_success
from understudy.learning.fit import learn_automaton
from understudy.learning.shown_ranges import ShownRange, find_shown_range
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.property import Property
from understudy.training.session import Session
from understudy.ui.controller.beside import NO_RUNS, Begin, Beside, begin_in_thread
from understudy.ui.controller.status import describe_error

WORLDS = 100
"""The number of new worlds after each press; half as many without a flag, which takes longer."""
MOST_ROBOTS, FEWEST_WORLDS = 6_000, 30
"""The number of robots in all new worlds together, which decides how long it takes, and the fewest worlds with many."""
FIRST_SEED = 500_000_000
"""The first seed of new worlds. Each is used once, and for nothing else: no lesson was taught there."""
MOST_BINDINGS = 4
"""The largest number of targets with which a behavior is run in each world, the ones taught first."""
COMPARED_CHANCE = 0.7
"""The largest p-value of the range by which two versions are compared: of a press that lies beyond two others."""
YIELD_S = 0.0002
"""The pause after each report of progress, s, in which the thread that advances the world gets the interpreter."""


class LessonScoreKeeper:
    """Takes the score of the automaton in training after each press, beside the one before it in the same worlds.

    Parameters
    ----------
    session
        The session.
    begin
        Begins the runs. None: they are done in a thread of their own.
    worlds
        The number of worlds after each press.
    """

    def __init__(
        self,
        session: Session,
        *,
        begin: Begin | None = None,
        worlds: int = WORLDS,
    ) -> None:
        self._session, self._worlds = session, worlds
        self.begin = begin_in_thread if begin is None else begin
        self._can_begin = True
        self._seed, self._lock = FIRST_SEED, RLock()
        self._scored: TrainedAutomaton | None = None
        self._waiting: Callable[[], None] | None = None
        self._fresh: ScoreChange | None = None
        self._present: Lesson | None = None
        self.change: ScoreChange | None = None
        """The newest score, beside the one before. None: there is none yet."""
        self.problem = ""
        """What ended the last runs; empty if nothing did."""
        self._goals: tuple[str, tuple[Property, ...], bool] | None = None
        self.enabled = True
        self.is_running = False

    def find_obstacle(self) -> str:
        """Say why there is no score; empty if there can be one."""
        setup = SessionSetup.from_session(self._session)
        if setup is None:
            return "not measured: there are no other worlds to run it in"
        if not self._can_begin:
            return f"not measured: {NO_RUNS}"
        if not self.enabled:
            return "not measured: turned off"
        if (os.cpu_count() or 1) < 2:
            return "not measured: this computer has a single core, which runs the world"
        if not self.goal:
            return "not measured: choose what success means"
        return ""

    def run_beside(self, beside: Beside) -> None:
        """Let runs begin where the other work of the session is done; there is no score where the world would wait."""
        self._can_begin = beside.begin is not None
        self.begin = beside.begin or self.begin

    @property
    def goal(self) -> str:
        """What success means, in words; empty if there is nothing by which to measure it."""
        return self._look_at_goals()[0]

    @property
    def offers(self) -> tuple[Property, ...]:
        """The goals of which a person can pick one; none if a flag says what success is, and no goal was chosen."""
        return self._look_at_goals()[1]

    @property
    def is_goal_chosen(self) -> bool:
        """Whether a person has chosen what success means."""
        return self._look_at_goals()[2]

    def _look_at_goals(self) -> tuple[str, tuple[Property, ...], bool]:
        """Return what success means, and what is offered; computed once for each change of the lesson."""
        if self._goals is None:
            lesson, setup = self._session.lesson, SessionSetup.from_session(self._session)
            goal = describe_goal(lesson, of_world=setup is not None and setup.scenario.goal is not None)
            offers = () if isinstance(find_success(lesson), str) else offer_session_goals(self._session)
            self._goals = goal, offers, lesson.goal is not None
        return self._goals

    def find_offer(self, name: str) -> Property:
        """Find an offered goal by its name; SessionError if it is not offered."""
        for each in self.offers:
            if each.name == name:
                return each
        names = "; ".join(each.name for each in self.offers) or "none"
        raise SessionError(f"this goal is not offered: {name!r:.80}; offered are: {names}")

    def describe(self) -> str:
        """Return the score in words, or why there is none; empty before the first one."""
        if obstacle := self.find_obstacle():
            return obstacle
        if self.problem:
            return f"not measured: {self.problem}"
        if self.change is None:
            return "" if self._scored is None else f"{self._session.automaton.name} runs in new worlds…"
        return self.change.describe()

    @property
    def trend(self) -> Trend:
        """What changed between the newest score and the one before; empty if nothing did, or there is none."""
        return "" if self.change is None or self.find_obstacle() or self.problem else self.change.trend

    def note_change(self) -> None:
        """Take the score of what is learned now, after a press or another change; what is running is finished first."""
        self._goals = None
        has_press = any(example.is_from_press for example in self._session.examples)
        self._present = self._session.lesson if has_press else None
        setup = SessionSetup.from_session(self._session)
        self._forget_outdated()
        if self._present is None or setup is None or self.find_obstacle():
            return
        with self._lock:
            bindings = self.list_bindings()[:MOST_BINDINGS]
            self._waiting = partial(self._score, self._present, setup, bindings)
            begins, self.is_running = not self.is_running, True
        if begins:
            self.begin(self._run)

    def _forget_outdated(self) -> None:
        """Forget a score if nothing is to be scored or success has another meaning, and the fall by an undone press."""
        with self._lock:
            now, scored = self._present, None if self._scored is None else self._scored.lesson
            if now is None:
                self._scored, self.problem = None, ""
            if now is None or (scored is not None and not is_success_same(scored, now)):
                self.change = self._fresh = None
            elif self.change is not None and scored is not None and not has_presses_of(now, scored):
                self.change, self._fresh = replace(self.change, before=None), None

    def find_scored(self) -> tuple[Library, SessionSetup, LessonScore] | None:
        """Return what was scored last, in its library, with what ran in new worlds and its score.

        None if nothing was, it is turned off, the next score is being taken, or a coordinator is trained.
        """
        change, taught, setup = self.change, self._scored, SessionSetup.from_session(self._session)
        if self.is_running or self.find_obstacle():
            return None
        if change is None or taught is None or setup is None or setup.team is not None:
            return None
        return self._session.library.with_automaton(taught), setup, change.after

    def take_change(self) -> ScoreChange | None:
        """Return the newest score on the first call after it was taken, else None."""
        with self._lock:
            fresh, self._fresh = self._fresh, None
        return fresh

    def _run(self) -> None:
        while (score := self._take_waiting()) is not None:
            try:
                score()
            except CancelledError:
                pass
            except Exception as error:
                self._scored, self.problem = None, describe_error(error)

    def _take_waiting(self) -> Callable[[], None] | None:
        """Return what scores the lesson that is next; None if there is none, which ends the runs."""
        with self._lock:
            waiting, self._waiting = self._waiting, None
            self.is_running = waiting is not None
            return waiting

    def turn(self, enabled: bool) -> None:
        """Turn the score on or off; what is running ends."""
        self.enabled = enabled
        if enabled:
            self.note_change()

    def _score(self, lesson: Lesson, setup: SessionSetup, bindings: Sequence[Mapping[str, str]]) -> None:
        """Score what is learned from a lesson, and the version before, in worlds that were never used."""
        taught = TrainedAutomaton(learn_automaton(lesson), lesson)
        success = find_success(lesson)
        by_flag = isinstance(success, str)
        count = self._worlds if by_flag else self._worlds // 2
        count = min(count, max(FEWEST_WORLDS, MOST_ROBOTS // setup.robots))
        seeds = range(self._seed, self._seed + count)
        self._seed += count
        former = self._scored
        if former is not None and not is_comparable(former, taught):
            former = None
        shown_range = find_compared_range(former, taught) if by_flag else None
        worlds = NewWorlds(setup, seeds, shown_range)
        before = None if former is None else self._run_worlds(former, worlds, bindings)
        if before is not None and shown_range is not None:
            worlds = replace(worlds, shown=shown_range.limit_near(before.raised))
        after = self._run_worlds(taught, worlds, bindings)
        if shown_range is None:
            goal = f"{success} counts wherever it is raised" if by_flag else ""
            change = ScoreChange(before, after, goal, is_measured=not by_flag)
        else:
            goal = f"{shown_range.feature} was {shown_range.describe()} where it was pressed"
            is_present = shown_range.feature in lesson.automaton.features
            change = ScoreChange(before, after, goal, is_goal_present=is_present)
        with self._lock:
            self._scored, self.problem = taught, ""
            self.change = self._fresh = change
            self._forget_outdated()

    def list_bindings(self) -> list[Mapping[str, str]]:
        """List the targets that the parameters had at presses, in order; the present ones if there was none here."""
        session, parameters = self._session, set(self._session.automaton.parameters)
        bindings = dict.fromkeys(each.binding for each in session.examples if each.is_from_press)
        here = set(session.body.targets)
        usable: list[Mapping[str, str]]
        usable = [dict(each) for each in bindings if set(each) == parameters and here >= set(each.values())]
        return usable or [dict(session.view().targets)]

    def _run_worlds(
        self, taught: TrainedAutomaton, worlds: NewWorlds, bindings: Sequence[Mapping[str, str]]
    ) -> LessonScore:
        library, name = self._session.library.with_automaton(taught), taught.automaton.name
        return score_behavior(library, name, worlds, bindings, progress=self._report)

    def _report(self, through: int, worlds: int) -> None:
        if not self.enabled:
            raise CancelledError
        sleep(YIELD_S)


def find_compared_range(former: TrainedAutomaton | None, taught: TrainedAutomaton) -> ShownRange | None:
    """Find the range in which a flag counts as success when two versions of a lesson are compared.

    It is the range of the former version, even of a single press, since the last press may be a slip far outside. If
    the former version has no press for the flag, it is the range of the present one; None if there is none.
    """
    flag = None if taught.lesson is None else find_success(taught.lesson)
    if taught.lesson is None or not isinstance(flag, str):
        return None
    shown_range = None
    if former is not None and former.lesson is not None and flag in former.automaton.flags:
        shown_range = find_shown_range(former.lesson, flag, fewest=1, chance=COMPARED_CHANCE)
    shown_range = shown_range or find_shown_range(taught.lesson, flag, chance=COMPARED_CHANCE)
    return None if shown_range is None else shown_range.restrict_limits()


def is_comparable(former: TrainedAutomaton, taught: TrainedAutomaton) -> bool:
    """Return whether success means the same for two versions, and they can be run with the same targets."""
    if former.lesson is None or taught.lesson is None:
        return False
    same_targets = former.automaton.parameters == taught.automaton.parameters
    return same_targets and is_success_same(former.lesson, taught.lesson)


def is_success_same(first: Lesson, second: Lesson) -> bool:
    """Return whether success means the same in two lessons; a flag also if the same feature was shown to tell where.

    Only a change of the features changes which one that is for good. The last press may be a slip.
    """
    success = find_success(first)
    if success != find_success(second):
        return False
    if not isinstance(success, str) or first.automaton.features == second.automaton.features:
        return True
    ranges = [find_shown_range(each, success) for each in (first, second)]
    return len({each.feature for each in ranges if each is not None}) < 2


def has_presses_of(lesson: Lesson, scored: Lesson) -> bool:
    """Return whether a lesson has all presses of one that was scored: none was undone, deleted or changed since."""
    presses = {(example.number, example.next) for example in lesson.examples}
    return all((each.number, each.next) in presses for each in scored.examples if each.is_from_press)
