"""The lesson as the library has it, beside which the lesson in training is compared and saved."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from understudy.learning.lesson_change import ChangeSince
from understudy.model.automaton import Transition
from understudy.model.change_summary import ChangeSummary
from understudy.model.lesson import Lesson
from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton
from understudy.training.session import Session
from understudy.ui.controller.interrupted_sessions import is_same_lesson


class SavedLesson:
    """The lesson that was saved last.

    Parameters
    ----------
    folder
        The folder of the library.
    lesson
        The lesson as the library has it; None if it has none.
    """

    def __init__(self, folder: Path, lesson: Lesson | None) -> None:
        self.folder, self.lesson = folder, lesson
        self._since = ChangeSince(lesson)
        self._compared: tuple[tuple[object, ...], bool] | None = None

    def differs_from(self, session: Session) -> bool:
        """Return whether the lesson of a session is another one; compared again only when that one changed."""
        saved = self.lesson
        key = (session.examples, session.automaton, saved)
        if self._compared is None or any(
            new is not old for new, old in zip(key, self._compared[0], strict=True)
        ):
            differs = bool(session.examples) if saved is None else not is_same_lesson(saved, session.lesson)
            self._compared = key, differs
        return self._compared[1]

    def summarize_change(self, lesson: Lesson, transitions: Mapping[str, Transition]) -> ChangeSummary | None:
        """Summarize what the transition functions learned from a lesson decide otherwise, apart from new presses."""
        return self._since.summarize(lesson, transitions)

    def save(self, taught: TrainedAutomaton) -> Path:
        """Save an automaton with its lesson, keep its former version, and return where it was saved."""
        path = save_automaton(self.folder, taught)
        self.lesson, self._since = taught.lesson, ChangeSince(taught.lesson)
        return path
