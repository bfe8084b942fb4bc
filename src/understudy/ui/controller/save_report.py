"""Saving: a word of what worked and no longer does."""

from __future__ import annotations

from pathlib import Path

from understudy.analysis.lesson_tests import NOBODY, find_regressions
from understudy.errors import UnderstudyError
from understudy.learning.fit import learn
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.team.libraries import Libraries
from understudy.storage.library_folder import make_file_stem, read_document

MOST_SAID = 2


def find_regressions_since_saved(
    folder: Path, library: Library, taught: TrainedAutomaton, libraries: Libraries = NOBODY
) -> tuple[str, ...]:
    """What worked with the version in the folder and no longer does with this one, a sentence each: see
    `find_regressions`.
    """
    return find_regressions(
        library, taught, _former(folder / f"{make_file_stem(taught.automaton.name)}.json", library), libraries
    )


def _former(path: Path, library: Library) -> TrainedAutomaton | None:
    """The version before; None where there is none, or none that could be compared with."""
    if not path.exists():
        return None
    try:
        return read_document(path, library.kit, learn).taught
    except UnderstudyError:
        return None  # saving keeps it as a former version, whatever is wrong with it


def format_saved_message(path: Path, worse: tuple[str, ...]) -> str:
    """That it is saved, and what no longer works."""
    if not worse:
        return f"Saved in {path}"
    more = (
        f"; and {len(worse) - MOST_SAID} more, which understudy test tells" if len(worse) > MOST_SAID else ""
    )
    return f"Saved in {path}, but something that worked no longer does: {'; '.join(worse[:MOST_SAID])}{more}"
