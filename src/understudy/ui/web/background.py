"""Work beside the world on the page: runs that take long, and actions longer than a tick.

A run reports how far it is, and can be cancelled. What it was run with is compared with the lesson in training.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future
from dataclasses import dataclass
from functools import partial
from time import sleep
from typing import Generic, TypeVar

from understudy.clock import REAL_TIME
from understudy.judging.rollout import Progress
from understudy.learning.training_set import identify_teaching
from understudy.model.lesson import Lesson
from understudy.ui.controller.beside import Beside
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.clients import Client

T = TypeVar("T")
YIELD_S = 0.0002
"""The pause of a run after each progress report, s.

Without it, the thread that advances the world on the page would wait 5 ms for the interpreter each time.
"""


@dataclass(frozen=True, slots=True)
class SlowAction:
    """An action that takes longer than a tick may.

    Attributes
    ----------
    status
        What the studio says while it lasts.
    work
        What is done beside the world, such as in another thread.
    finish
        What is done in the thread of the ticks when `work` has succeeded; it returns what the studio then says.
    """

    status: StatusMessage
    work: Callable[[], None]
    finish: Callable[[], StatusMessage]


@dataclass(frozen=True, slots=True)
class BegunAction:
    """A slow action that was begun, and the message (its page and number) that is answered at its end."""

    action: SlowAction
    work: Future[None]
    viewer: Client
    number: int | None

    def finish(self) -> StatusMessage:
        """Finish the action, and return what the studio says; raise what `work` raised."""
        self.work.result()
        return self.action.finish()


class SlowActions:
    """The slow actions that are under way."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._begun: list[BegunAction] = []

    def begin(self, action: SlowAction, viewer: Client, number: int | None) -> None:
        """Begin an action beside the world, for a page's message of this number."""
        self._begun.append(BegunAction(action, self._executor.submit(action.work), viewer, number))

    def take_done(self) -> list[BegunAction]:
        """Remove and return the actions whose work is done."""
        done = [each for each in self._begun if each.work.done()]
        self._begun = [each for each in self._begun if each not in done]
        return done


class BackgroundRun(Generic[T]):
    """A run beside the world, which reports how far it is, and can be cancelled."""

    def __init__(
        self, run: Callable[[Progress], T], beside: Beside, wall: Callable[[], float] = REAL_TIME
    ) -> None:
        self.result: T | None = None
        """Its result; None until it has ended, if an error ended it, and if it was cancelled."""
        self.problem = ""
        """The error that ended it; empty if none did."""
        self.finished, self.total = 0, 1
        """How much of it is done, as it reported last, and how much there is to do."""
        self.seconds = 0.0
        """How long it took, s, by the clock `wall`; known at its end."""
        self._wall, self._cancelled = wall, False
        beside.begin_run(partial(self._run, run))

    @property
    def is_running(self) -> bool:
        """True as long as there is neither a result nor an error, also after `cancel`."""
        return self.result is None and not self.problem

    def cancel(self) -> None:
        """Cancel it at its next report; there is no result."""
        self._cancelled = True

    def _run(self, run: Callable[[Progress], T]) -> None:
        began_s = self._wall()
        try:
            result = run(self._report)
            self.seconds = self._wall() - began_s
            self.result = result
        except CancelledError:
            pass
        except Exception as error:
            self.problem = describe_error(error)

    def _report(self, finished: int, total: int) -> None:
        if self._cancelled:
            raise CancelledError
        self.finished, self.total = finished, total
        sleep(YIELD_S)


class LessonIdentity:
    """The presses and the design of the lesson in training, by which another state of it is told from this one."""

    def __init__(self) -> None:
        self._lesson: Lesson | None = None
        self._key: tuple[object, ...] = ()
        self._ran_with: tuple[object, ...] = ()

    def note_run(self, trainer: Trainer | None) -> None:
        """Note that something is run with the lesson as it stands."""
        self._ran_with = self._identify(trainer)

    def has_changed(self, trainer: Trainer | None) -> bool:
        """Return whether the lesson is no longer as it was at the last run."""
        if trainer is None:
            return False
        if self._ran_with == () and not trainer.has_unsaved_changes:  # it ran with what was saved, as this is
            self.note_run(trainer)
        return self._ran_with != self._identify(trainer)

    def _identify(self, trainer: Trainer | None) -> tuple[object, ...]:
        if trainer is None:
            return ()
        lesson, _ = trainer.explainer.learn_lesson()
        if lesson is not self._lesson:
            self._lesson, self._key = lesson, identify_teaching(lesson)
        return self._key
