"""The history of a lesson: every step that changed it, so that each can be undone and done again."""

from __future__ import annotations

from dataclasses import dataclass, replace

from understudy.errors import SessionError
from understudy.model.lesson import Example, Lesson
from understudy.runtime.interpreter import StackFrame


@dataclass(frozen=True, slots=True)
class HistoryStep:
    """What a step changes: the lesson, and the run state of its automaton."""

    lesson: Lesson
    run: tuple[StackFrame, ...] = ()


class History:
    """The current lesson, the steps behind it and the undone ones ahead."""

    def __init__(self, lesson: Lesson) -> None:
        self.lesson = lesson
        self._done: list[tuple[str, HistoryStep, HistoryStep]] = []
        self._undone: list[tuple[str, HistoryStep, HistoryStep]] = []

    def step(
        self, what: str, lesson: Lesson, *, before: tuple[StackFrame, ...], after: tuple[StackFrame, ...]
    ) -> None:
        """Take a step: `what` was done to the lesson, from run state `before` to `after`."""
        self._done.append((what, HistoryStep(self.lesson, before), HistoryStep(lesson, after)))
        self._undone.clear()
        self.lesson = lesson

    def amend(self, *watched: Example) -> None:
        """Add watched examples to the current lesson: no step of their own."""
        self.lesson = replace(self.lesson, examples=(*self.lesson.examples, *watched))

    def undo(self) -> tuple[str, tuple[StackFrame, ...]]:
        """Go back one step: what it was, and the run state before it."""
        if not self._done:
            raise SessionError("there is nothing to undo: no step has changed this lesson yet")
        step = self._done.pop()
        self._undone.append((step[0], step[1], HistoryStep(self.lesson, step[2].run)))
        self.lesson = step[1].lesson
        return step[0], step[1].run

    def redo(self) -> tuple[str, tuple[StackFrame, ...]]:
        """Do the last undone step again: what it was, and the run state after it."""
        if not self._undone:
            raise SessionError("there is nothing to redo: nothing was undone since the last step")
        step = self._undone.pop()
        self._done.append((step[0], HistoryStep(self.lesson, step[1].run), step[2]))
        self.lesson = step[2].lesson
        return step[0], step[2].run

    @property
    def undoable(self) -> str | None:
        """What undo would take back."""
        return self._done[-1][0] if self._done else None

    @property
    def redoable(self) -> str | None:
        """What redo would do again."""
        return self._undone[-1][0] if self._undone else None
