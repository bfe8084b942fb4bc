"""Tell whether the lesson in training is still the one that something was run with."""

from __future__ import annotations

from understudy.model.lesson import Example, Lesson
from understudy.ui.controller.trainer import Trainer


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
