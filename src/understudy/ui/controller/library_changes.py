"""What was saved in a library's folder by others while an automaton of it was being taught."""

from __future__ import annotations

from pathlib import Path

from understudy.errors import UnderstudyError
from understudy.learning.fit import learn
from understudy.model.automaton import Automaton
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.storage.library_folder import make_file_stem, read_document
from understudy.ui.controller.interrupted_sessions import is_same_lesson


def list_library_changes(
    folder: Path, library: Library, automaton: Automaton, saved: Lesson | None
) -> tuple[str, ...]:
    """List what others have saved in a folder since a session began: one sentence for each automaton.

    `automaton` is the one in training, `saved` its lesson as the session last read or saved it, and `library` has the
    automata that it uses, as the session read them. A file that cannot be read counts as changed.
    """
    name, used = automaton.name, _list_used(library, automaton, {})
    sentences = [f"others had saved another version of {name} meanwhile, which is kept as a former version"]
    return (
        *(sentences if _differs(folder, library, name, saved) else ()),
        *(
            f"{part} was changed meanwhile, and is taught here as it was: open {name} again to use it"
            for part in used
            if _differs(folder, library, part, library.taught[part].lesson)
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
