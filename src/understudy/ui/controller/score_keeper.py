"""The score of the automaton in training, taken after each press in new worlds, in a thread of its own."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError
from threading import Lock, Thread
from time import sleep

from understudy.analysis.evaluate import choose_success_flag
from understudy.falsification.lesson_score import LessonScore, ScoreChange, Trend, score_behavior
from understudy.falsification.new_worlds import NewWorlds
from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.ui.controller.status import describe_error

WORLDS = 100
"""The number of new worlds after each press; half as many if the goal of the world counts, which takes longer."""
FIRST_SEED = 500_000_000
"""The first seed of new worlds. Each is used once, and for nothing else: no lesson was taught there."""
MOST_BINDINGS = 4
"""With how many targets a behavior is run in each world, at most: those that it was taught with first."""
YIELD_S = 0.0002
"""The pause after each report of progress, s, in which the thread that advances the world gets the interpreter."""

Begin = Callable[[Callable[[], None]], None]
"""A function that begins some work, which may go on in another thread."""


def begin_in_thread(work: Callable[[], None]) -> None:
    """Begin some work in a thread of its own."""
    Thread(target=work, name="lesson score", daemon=True).start()


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
        self._begin = begin_in_thread if begin is None else begin
        self._bindings: dict[tuple[tuple[str, str], ...], Mapping[str, str]] = {}
        self._seed, self._lock = FIRST_SEED, Lock()
        self._scored: TrainedAutomaton | None = None
        self._waiting: Lesson | None = None
        self._fresh: ScoreChange | None = None
        self.change: ScoreChange | None = None
        """The newest score, beside the one before. None: there is none yet."""
        self.problem = ""
        """What ended the last runs; empty if nothing did."""
        self.enabled = True
        self.is_running = False

    def find_obstacle(self) -> str:
        """Say why there is no score; empty if there can be one."""
        body, name = self._session.body, self._session.automaton.name
        if not self.enabled:
            return "not measured: turned off"
        if not isinstance(body, World):
            return "not measured: there are no other worlds to run it in"
        if (os.cpu_count() or 1) < 2:
            return "not measured: this computer has a single core, which runs the world"
        if body.scenario.goal is None and choose_success_flag(self._session.automaton.flags) is None:
            return f"not measured: {name} has no flag, and the world no goal"
        return ""

    def describe(self) -> str:
        """Return the score in words, or why there is none; empty before the first press."""
        if obstacle := self.find_obstacle():
            return obstacle
        if self.problem:
            return f"not measured: {self.problem}"
        return "" if self.change is None else self.change.describe()

    @property
    def trend(self) -> Trend:
        """What changed between the newest score and the one before; empty if nothing did, or there is none."""
        return "" if self.change is None or self.find_obstacle() or self.problem else self.change.trend

    def note_change(self) -> None:
        """Take the score of what is learned now, after a press or another change; what is running is finished first."""
        targets = dict(self._session.view().targets)
        self._bindings.setdefault(tuple(targets.items()), targets)
        if not any(example.is_from_press for example in self._session.examples):
            self._scored = self.change = None
            return
        if self.find_obstacle():
            return
        with self._lock:
            self._waiting = self._session.lesson
            begins, self.is_running = not self.is_running, True
        if begins:
            self._begin(self._run)

    def find_scored(self) -> tuple[Library, Scenario, LessonScore] | None:
        """Return what was scored last, in its library, with the scenario and its score.

        None if nothing was, it is turned off, or the next score is being taken.
        """
        change, taught, body = self.change, self._scored, self._session.body
        if self.is_running or self.find_obstacle():
            return None
        if change is None or taught is None or not isinstance(body, World):
            return None
        return self._session.library.with_automaton(taught), body.scenario, change.after

    def take_change(self) -> ScoreChange | None:
        """Return the newest score on the first call after it was taken, else None."""
        fresh, self._fresh = self._fresh, None
        return fresh

    def _run(self) -> None:
        while (lesson := self._take_waiting()) is not None:
            try:
                self._score(TrainedAutomaton(learn_automaton(lesson), lesson))
            except CancelledError:
                pass
            except Exception as error:
                self._scored, self.problem = None, describe_error(error)

    def _take_waiting(self) -> Lesson | None:
        """Return the lesson to score next; None if there is none, which ends the runs."""
        with self._lock:
            lesson, self._waiting = self._waiting, None
            self.is_running = lesson is not None
            return lesson

    def turn(self, enabled: bool) -> None:
        """Turn the score on or off; what is running ends."""
        self.enabled = enabled
        if enabled:
            self.note_change()

    def _score(self, taught: TrainedAutomaton) -> None:
        """Score an automaton, and the one before, in worlds that were never used."""
        body = self._session.body
        if not isinstance(body, World):
            return
        by_flag = choose_success_flag(taught.automaton.flags) is not None
        count = self._worlds if by_flag else self._worlds // 2
        seeds = range(self._seed, self._seed + count)
        self._seed += count
        worlds = NewWorlds.from_seeds(body.scenario, seeds, by_flag=by_flag)
        before = None if self._scored is None else self._run_worlds(self._scored, worlds)
        after = self._run_worlds(taught, worlds)
        self._scored = taught
        self.problem, self.change = "", ScoreChange(before, after)
        self._fresh = self.change

    def list_bindings(self) -> list[Mapping[str, str]]:
        """List the targets that the parameters had at presses, in order; the present ones if there was no press."""
        parameters = set(self._session.automaton.parameters)
        known = [each for each in self._bindings.values() if set(each) == parameters]
        return known or [dict(self._session.view().targets)]

    def _run_worlds(self, taught: TrainedAutomaton, worlds: NewWorlds) -> LessonScore:
        library, name = self._session.library.with_automaton(taught), taught.automaton.name
        bindings = self.list_bindings()[:MOST_BINDINGS]
        return score_behavior(library, name, worlds, bindings, progress=self._report)

    def _report(self, through: int, worlds: int) -> None:
        if not self.enabled:
            raise CancelledError
        sleep(YIELD_S)
