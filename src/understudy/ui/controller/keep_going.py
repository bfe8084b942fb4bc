"""Keep going: test what is in training in new worlds, and go to where it goes wrong, until it holds or presses end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from understudy.analysis.raised_range import describe_raised
from understudy.errors import SessionError
from understudy.falsification.holding_test import MOST_WORLDS, WANTED, HoldingResult, HoldingTest
from understudy.falsification.new_worlds import Mistake, NewWorlds
from understudy.falsification.open_failure import BEFORE_S
from understudy.falsification.session_setup import SessionSetup
from understudy.learning.fit import learn_automaton
from understudy.learning.shown_ranges import find_shown_range
from understudy.model.library import TrainedAutomaton
from understudy.properties.offered_goals import find_success
from understudy.properties.run_property import Verdict
from understudy.training.trainee import Mode
from understudy.ui.controller.status import StatusMessage

if TYPE_CHECKING:
    from understudy.ui.controller.trainer import Trainer

FIRST_SEED = 100_000
"""The first seed of new worlds; each is used for one version of a lesson, and for no score."""
SEEDS_PER_EXAMPLE = 2 * MOST_WORLDS
"""How many seeds further a lesson begins for each example, so that it is not tested where it was taught formerly."""
MOST_PRESSES = 60
"""The number of presses after which it is said that the behavior does not hold yet."""


class LessonContinuation:
    """Teaching of one session until the behavior works in a wanted share of new worlds.

    Parameters
    ----------
    trainer
        The trainer of the session.
    """

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._test: HoldingTest | None = None
        self._began_with: int | None = None
        self._tested: object = None
        self._others = ""
        self._is_running = False
        self._key: object = None
        self._last: tuple[object, HoldingResult] | None = None

    @property
    def presses(self) -> int:
        """The number of presses since the first test."""
        return max(0, self._count() - (self._began_with or 0))

    def _count(self) -> int:
        return self._trainer.session_view.examples

    def _describe_lesson(self) -> object:
        """Return what differs after each change by a person of what is learned."""
        lesson = self._trainer.session.lesson
        presses = [each for each in self._trainer.session.examples if each.is_from_press]
        return lesson.automaton, lesson.options, lesson.goal, presses

    def begin(self) -> Callable[[], HoldingResult]:
        """Return a function that tests the present lesson, which may run in another thread.

        Nothing is tested twice: a lesson that was not changed since its test goes on with the next mistake of that.

        Returns
        -------
        function
            It returns the result.

        Raises
        ------
        SessionError
            If there are no other worlds, nothing to test, or a test is running.
        """
        session, name = self._trainer.session, self._trainer.name
        if self._is_running:
            raise SessionError(f"{name} is being tested in new worlds already: wait for the result")
        setup = SessionSetup.from_session(session)
        if setup is None:
            raise SessionError(
                "there are no other worlds to test it in: watch the robot, and press where it is wrong"
            )
        if not self._trainer.score.goal:
            raise SessionError("success is not measured: choose what success means first")
        if not any(example.is_from_press for example in session.examples):
            raise SessionError("there is nothing to test yet: press a state to direct the robot first")
        if self._test is None:
            numbers = max(example.number for example in session.examples)
            self._test = HoldingTest(partial(NewWorlds, setup), FIRST_SEED + SEEDS_PER_EXAMPLE * numbers)
        if self._began_with is None:
            self._began_with = self._count()
        self._test.make_worlds, self._others = partial(NewWorlds, setup), setup.describe_others(name)
        self._tested = self._describe_lesson()
        lesson, library, bindings = session.lesson, session.library, self._trainer.score.list_bindings()
        test, last, key = self._test, self._last, (self._tested, self._others, bindings)
        self._is_running, self._key = True, key
        if (
            last is not None
            and last[0] == key
            and (last[1].verdict is Verdict.HOLDS or len(last[1].mistakes) > 1)
        ):
            return lambda: replace(last[1], mistakes=last[1].mistakes[1:])

        def run() -> HoldingResult:
            taught = TrainedAutomaton(learn_automaton(lesson), lesson)
            try:
                return test.test(library.with_automaton(taught), name, bindings)
            except BaseException:
                self._is_running = False
                raise

        return run

    def finish(self, result: HoldingResult) -> StatusMessage:
        """Go to where the behavior goes wrong, or say that it holds, or that it does not hold yet."""
        name, presses = self._trainer.name, self.presses
        self._is_running, self._last = False, (self._key, result)
        if self._describe_lesson() != self._tested:
            return StatusMessage(
                f"{name} was changed while it was tested: keep going to test it as it is now"
            )
        others = f" ({self._others})" if self._others else ""
        count = f"{result.held} of {result.worlds} new worlds{others}"
        after = f"after {presses} press{'es' * (presses != 1)}" if presses else "as it is"
        if result.verdict is Verdict.HOLDS:
            self._began_with = None
            share = f"{WANTED:.0%}".replace("%", " %")
            return StatusMessage(
                f"{name} holds, {after}: in at least {share} of worlds ({count}{self._find_caution()})",
                "recorded",
            )
        if presses >= MOST_PRESSES or not result.mistakes:
            self._began_with = None
            return StatusMessage(f"{name} does not hold yet, {after}: it works in {count}", "error")
        mistake = result.mistakes[0]
        before_s = mistake.wrong_s - self._go_to(mistake)
        when = "from now on" if before_s < self._trainer.session.body.tick_s else f"in {before_s:.1f} s"
        path = self._trainer.session_view.path
        inner = f" {path[-2]} runs here: to correct that, open it." if len(path) > 1 else ""
        said = f"{name} works in {count}. Here, {when}: {mistake.why}.{inner} Press what it should do, and resume"
        return StatusMessage(said)

    def _find_caution(self) -> str:
        """Say that a flag was counted wherever it is raised, if its presses have nothing in common."""
        lesson = self._trainer.session.lesson
        flag = find_success(lesson)
        return (
            f"; {describe_raised(flag, None)}"
            if isinstance(flag, str) and find_shown_range(lesson, flag) is None
            else ""
        )

    def _go_to(self, mistake: Mistake) -> float:
        """Run its world until shortly before the mistake, with nobody watching, and pause; return the time, s."""
        trainer, session = self._trainer, self._trainer.session
        trainer.load_world(mistake.seed)
        if dict(session.view().targets) != dict(mistake.binding):
            session.bind_targets(**mistake.binding)
        if session.mode is Mode.TRAINING:
            session.test()
        if not session.paused:
            trainer.pause()
        watching, session.is_watching = session.is_watching, False
        try:
            while session.body.time_s < mistake.wrong_s - BEFORE_S - session.body.tick_s / 2:
                session.tick()
        finally:
            session.is_watching = watching
        trainer.note_moved(f"World {mistake.seed}")
        return session.body.time_s
