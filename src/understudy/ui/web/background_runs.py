"""Runs beside the world on the page, in threads of their own, and whether the lesson has changed since they began."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from threading import Thread
from time import sleep
from typing import Generic, TypeVar

from msgspec import structs

from understudy.analysis.evaluation import Evaluation
from understudy.analysis.rollout import Progress
from understudy.clock import REAL_TIME
from understudy.model.lesson import Example, Lesson
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.views.session import EvaluationData, EvaluationResultData, describe_evaluation

YIELD_S = 0.0002
"""The pause of a run after each progress report, s.

Without it, the thread that advances the world on the page would wait 5 ms for the interpreter each time.
"""

Result = TypeVar("Result")


class BackgroundRun(Generic[Result]):
    """A run in a thread of its own, which reports its progress and can be cancelled.

    Parameters
    ----------
    work
        What is run. It calls its argument with what is finished and the total; an error from that ends it.
    wall
        What tells how long it took, s.
    """

    def __init__(self, work: Callable[[Progress], Result], wall: Callable[[], float] = REAL_TIME) -> None:
        self.result: Result | None = None
        self.problem = ""
        self.finished, self.total = 0, 1
        self.seconds = 0.0
        """How long it took, s; known at its end."""
        self._wall, self._cancelled = wall, False
        Thread(target=self._run, args=(work,), daemon=True).start()

    @property
    def is_running(self) -> bool:
        """True as long as there is neither a result nor an error, also after `cancel`."""
        return self.result is None and not self.problem

    def cancel(self) -> None:
        """Cancel the run at its next progress report; it gets no result."""
        self._cancelled = True

    def _run(self, work: Callable[[Progress], Result]) -> None:
        began_s = self._wall()
        try:
            result = work(self._report)
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


class UnseenWorldsEvaluation(BackgroundRun[EvaluationResultData]):
    """An evaluation of the automaton in training in unseen worlds."""

    def __init__(
        self, called: str, edition: int, *, worlds: int, evaluate: Callable[[Progress], Evaluation]
    ) -> None:
        self._data = EvaluationData(
            behavior=called, edition=edition, worlds=worlds, finished=0, result=None, problem=""
        )
        self._untold = True
        super().__init__(lambda progress: describe_evaluation(evaluate(progress)))

    @property
    def data(self) -> EvaluationData:
        """The evaluation as the page shows it."""
        data = self._data
        if (data.finished, data.result, data.problem) != (self.finished, self.result, self.problem):
            self._data = structs.replace(
                data, finished=self.finished, result=self.result, problem=self.problem
            )
        return self._data

    def take_status(self) -> StatusMessage | None:
        """Return the message about the finished evaluation on the first call after its end, else None."""
        if self.is_running or not self._untold:
            return None
        self._untold, data = False, self.data
        if data.result is None:
            return StatusMessage(data.problem, "error")
        worlds = f"{data.worlds} world{'s' * (data.worlds != 1)}"
        raised = f" ({data.result.raised})" if data.result.raised else ""
        return StatusMessage(
            f"{data.behavior} succeeded in {data.result.succeeded} of {worlds}{raised}",
            "error" if data.result.leaves_shown else "",
        )


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
            presses = (each for each in lesson.examples if each.is_from_press)
            self._lesson = lesson
            self._key = (lesson.automaton, lesson.options, tuple(map(_identify_example, presses)))
        return self._key


def _identify_example(example: Example) -> tuple[object, ...]:
    return (example.number, example.state, example.next, repr(example.values), example.quarantined)
