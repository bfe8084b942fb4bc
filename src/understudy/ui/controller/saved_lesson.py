"""The lesson as the library has it, with which the lesson in training is compared, and what others saved meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from understudy.errors import UnderstudyError
from understudy.learning.fit import learn
from understudy.learning.lesson_change import ChangeSince
from understudy.model.automaton import Automaton, Transition
from understudy.model.change_summary import ChangeSummary
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.storage.library_folder import make_file_stem, read_document, save_automaton
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

    def list_library_changes(self, library: Library, automaton: Automaton) -> tuple[str, ...]:
        """List what others have saved in the folder since the session began: one sentence for each automaton.

        `automaton` is the one in training, and `library` has the automata that it uses, as the session read them. A
        file that cannot be read counts as changed.
        """
        name, used = automaton.name, _list_used(library, automaton, {})
        sentences = [
            f"others had saved another version of {name} meanwhile, which is kept as a former version"
        ]
        return (
            *(sentences if _differs(self.folder, library, name, self.lesson) else ()),
            *(
                f"{part} was changed meanwhile, and is taught here as it was: open {name} again to use it"
                for part in used
                if _differs(self.folder, library, part, library.taught[part].lesson)
            ),
        )


def _list_used(library: Library, automaton: Automaton, names: dict[str, None]) -> dict[str, None]:
    """Add the automata that an automaton contains, directly and through others, to those that were found."""
    behaviors = [state.behavior for state in automaton.states if state.behavior is not None]
    for behavior in behaviors:
        if behavior in library.taught and behavior not in names:
            names[behavior] = None
            _list_used(library, library.automaton(behavior), names)
    return names


def _differs(folder: Path, library: Library, name: str, lesson: Lesson | None) -> bool:
    """Return whether a folder has another lesson of an automaton than the one that is known."""
    path = folder / f"{make_file_stem(name)}.json"
    if not path.exists():
        return False
    try:
        stored: TrainedAutomaton = read_document(path, library.kit, learn).taught
    except UnderstudyError:
        return True
    if stored.lesson is None or lesson is None:
        return stored.lesson is not lesson
    return not is_same_lesson(stored.lesson, lesson)
