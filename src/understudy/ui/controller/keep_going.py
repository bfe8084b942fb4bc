"""Keep going: test what is in training in new worlds, and go to where it goes wrong, until it holds or presses end.

Where presses have made it worse, the best version is named, and undo leads back to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from understudy.addons.checks.falsification.holding_test import (
    MOST_WORLDS,
    WANTED,
    HoldingResult,
    HoldingTest,
)
from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorlds
from understudy.addons.checks.falsification.open_failure import BEFORE_S
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.coaching.fast_forward import stop_watching
from understudy.errors import SessionError
from understudy.judging.properties.offered_goals import find_success
from understudy.judging.properties.run_property import Verdict
from understudy.judging.raised_range import describe_raised
from understudy.learning.fit import learn_automaton
from understudy.learning.shown_ranges import find_shown_range
from understudy.learning.training_set import identify_teaching
from understudy.model.lesson import ExampleKind, Lesson
from understudy.model.library import TrainedAutomaton
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


@dataclass(frozen=True, slots=True)
class BetterVersion:
    """A former version of the lesson, which works in more new worlds.

    Parameters
    ----------
    result
        The result of its test.
    press
        The number of presses of that version.
    steps
        How many steps of the lesson were made since, which undo takes back.
    since
        What was done since, in words: "the last 2 presses".
    """

    result: HoldingResult
    press: int
    steps: int
    since: str

    def describe(self) -> str:
        """Say where it works: "97 of 100 after press 12, before the last 2 presses"."""
        return f"{self.result.held} of {self.result.worlds} after press {self.press}, before {self.since}"


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
        self._compared: object = None
        self._others = ""
        self._is_running = False
        self._key: object = None
        self._last: tuple[object, HoldingResult | None] = (None, None)
        self._better: HoldingResult | None = None
        self._found: tuple[object, BetterVersion | None] = (None, None)
        self._shown = dict[HoldingResult, int]()

    @property
    def presses(self) -> int:
        """The number of presses since the first test."""
        return max(0, count_presses(self._trainer.session.lesson) - (self._began_with or 0))

    @property
    def better(self) -> BetterVersion | None:
        """The best version, if the one that was tested last works in fewer worlds and undo leads back to it."""
        result, session, view = self._better, self._trainer.session, self._trainer.session_view
        presses = tuple(each for each in session.examples if each.is_from_press)
        key = result, session.automaton, presses, view.undoable, view.redoable
        if key != self._found[0]:  # asked for at every frame
            self._found = key, None if result is None else self._find_version(result)
        return self._found[1]

    def _find_version(self, result: HoldingResult) -> BetterVersion | None:
        lesson = result.library.taught[self._trainer.name].lesson
        if lesson is None:
            return None
        wanted, session = describe_teaching(lesson), self._trainer.session
        steps = session.count_steps_since(lambda former: describe_teaching(former) == wanted)
        if steps is None or describe_teaching(session.lesson) == wanted:
            return None
        press = count_presses(lesson)
        what = "press" if count_presses(session.lesson) - press == steps else "change"
        since = (
            f"the last {what}" if steps == 1 else f"the last {steps} {what}{'es' if what == 'press' else 's'}"
        )
        return BetterVersion(result, press, steps, since)

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
            first = FIRST_SEED + SEEDS_PER_EXAMPLE * numbers
            self._test = HoldingTest(partial(NewWorlds, setup), first, avoided=self._trainer.seen_seeds)
        if self._began_with is None:
            self._began_with = count_presses(session.lesson)
        self._test.make_worlds, self._others = partial(NewWorlds, setup), setup.describe_others(name)
        lesson, library, bindings = session.lesson, session.library, self._trainer.score.list_bindings()
        self._tested, test = describe_teaching(lesson), self._test
        compared = find_success(lesson), bindings, self._others
        if compared != self._compared:  # former results are about something else
            self._compared, test.best, self._better = compared, None, None
        key, (last_key, last) = (self._tested, compared), self._last
        self._is_running, self._key = True, key
        if last is not None and last_key == key and (last.verdict is Verdict.HOLDS or self._has_more(last)):
            return lambda: last

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
        if describe_teaching(self._trainer.session.lesson) != self._tested:
            return StatusMessage(
                f"{name} was changed while it was tested: keep going to test it as it is now"
            )
        others = f" ({self._others})" if self._others else ""
        count = f"{result.held} of {result.worlds} new worlds{others}"
        after = f"after {presses} press{'es' * (presses != 1)}" if presses else "as it is"
        self._better = None
        if result.verdict is Verdict.HOLDS:
            self._began_with = None
            share = f"{WANTED:.0%}".replace("%", " %")
            return StatusMessage(
                f"{name} holds, {after}: in at least {share} of worlds ({count}{self._find_caution()})",
                "recorded",
            )
        best = self._test.best if self._test is not None else None
        if presses >= MOST_PRESSES or not result.mistakes:
            self._began_with = None
            self._better = best if best is not None and best.share > result.share else None
            offered = "" if self.better is None else f". The best version works in {self.better.describe()}"
            undo = "" if self.better is None else f": undo {self._name_steps(self.better)} to keep that"
            sentence = f"{name} does not hold yet, {after}: it works in {count}{offered}{undo}"
            return StatusMessage(sentence, "error")
        self._better = best if best is not None and result.is_worse(best) else None
        here = self._show_mistake(result)
        if self.better is None:
            return StatusMessage(f"{name} works in {count}. Here, {here}")
        undo = self._name_steps(self.better)
        sentence = f"{name} works in {count}: {self.better.describe()}. Undo {undo}, or go on here: {here}"
        return StatusMessage(sentence, "error")

    @staticmethod
    def _name_steps(better: BetterVersion) -> str:
        return "it" if better.steps == 1 else "them"

    def go_back(self) -> StatusMessage:
        """Undo what was done since the best version, and go to another world in which that one goes wrong.

        Returns
        -------
        StatusMessage
            What was undone, and what goes wrong there.

        Raises
        ------
        SessionError
            If no better version is known, or undo does not lead back to it.
        """
        session, result = self._trainer.session, self._better
        better = None if result is None else self._find_version(result)
        if better is None:
            raise SessionError(
                "no better version is known: keep going tests this one in new worlds, and names the best so far"
            )
        if session.view().waiting is not None:
            session.undo()
        for _ in range(better.steps):
            session.undo()
        self._trainer.note_lesson_change()
        self._better = None
        sentence = (
            f"{self._trainer.name} is as after press {better.press} again; redo brings back {better.since}"
        )
        if not self._has_more(better.result):
            held = better.result.verdict is Verdict.HOLDS
            count = f"It works in {better.result.held} of {better.result.worlds} new worlds"
            return StatusMessage(f"{sentence}. {count if held else 'Keep going to find where it goes wrong'}")
        return StatusMessage(f"{sentence}. Here, {self._show_mistake(better.result)}")

    def _has_more(self, result: HoldingResult) -> bool:
        """Return whether a version goes wrong in a world that was not shown yet."""
        return self._shown.get(result, 0) < len(result.mistakes)

    def _show_mistake(self, result: HoldingResult) -> str:
        """Go to the next world in which a version goes wrong, and say when and why."""
        number = self._shown.get(result, 0)
        self._shown[result], mistake = number + 1, result.mistakes[number]
        return go_to_mistake(self._trainer, mistake)

    def _find_caution(self) -> str:
        """Say that a raised flag counted as success in every situation, if its presses have nothing in common."""
        lesson = self._trainer.session.lesson
        flag = find_success(lesson)
        return (
            f"; {describe_raised(flag, None)}"
            if isinstance(flag, str) and find_shown_range(lesson, flag) is None
            else ""
        )


def go_to_mistake(trainer: Trainer, mistake: Mistake) -> str:
    """Run a world until shortly before a mistake, without learning, and pause; say when and why it goes wrong."""
    session = trainer.session
    trainer.load_world(mistake.seed)
    if dict(session.view().targets) != dict(mistake.binding):
        session.bind_targets(**mistake.binding)
    if session.mode is Mode.TRAINING:
        session.test()
    if not session.paused:
        trainer.pause()
    with stop_watching(session):
        session.run_for(max(0.0, mistake.wrong_s - BEFORE_S - session.body.time_s))
    trainer.note_moved(f"World {mistake.seed}")
    before_s = mistake.wrong_s - session.body.time_s
    when = "from now on" if before_s < session.body.tick_s else f"in {before_s:.1f} s"
    path = trainer.session_view.path
    inner = f" {path[-2]} runs here: to correct that, open it." if len(path) > 1 else ""
    return f"{when}: {mistake.why}.{inner} Press what it should do, and resume"


def describe_teaching(lesson: Lesson) -> object:
    """Return a value that changes with each press or edit that changes what is learned, or what success means."""
    return lesson.goal, identify_teaching(lesson)


def count_presses(lesson: Lesson) -> int:
    """Count the presses of a lesson; the default that one adds is no press."""
    return sum(each.is_from_press and each.kind is not ExampleKind.DEFAULT for each in lesson.examples)
