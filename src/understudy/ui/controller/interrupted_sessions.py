"""The journals of a library's sessions: their files, and which sessions were interrupted.

library/.journals/goto-2026-11-21-10.15.00.journal      a session that runs, or was killed
library/.journals/goto-2026-11-21-09.50.12.ended        one that ended: the last few are kept
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime
from itertools import chain, count
from pathlib import Path
from urllib.parse import unquote

from understudy.errors import UnderstudyError
from understudy.learning.training_set import identify_teaching
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.storage.append_log import JournalLock
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.library_folder import make_file_stem
from understudy.training.journal_replay import ReplayedSession

FOLDER = ".journals"
RUNNING, ENDED = ".journal", ".ended"
_NAMED = re.compile(r"(.+)-\d{4}-\d\d-\d\d-\d\d\.\d\d\.\d\d(?:-\d+)?" + re.escape(RUNNING))
KEPT = 5
"""How many ended journals of an automaton are kept."""


@dataclass(frozen=True, slots=True)
class InterruptedSession:
    """A session that was interrupted with unsaved examples."""

    path: Path
    began: datetime
    examples: int
    steps: str
    """What its last step was."""


def make_journal_path(library: Path, name: str, *, now: datetime) -> Path:
    """Make the path of the journal of a session that begins now."""
    folder = library / FOLDER
    with convert_os_errors(folder, "making the folder of journals"):
        folder.mkdir(parents=True, exist_ok=True)
    began = f"{make_file_stem(name)}-{now:%Y-%m-%d-%H.%M.%S}"
    names = chain([began], (f"{began}-{number}" for number in count(2)))
    return next(path for each in names if not (path := folder / f"{each}{RUNNING}").exists())


def find_interrupted_session(
    library: Path, name: str, world: str, opened: Library
) -> InterruptedSession | None:
    """Find the newest interrupted session of an automaton in this world that has unsaved examples."""
    for path in reversed(_of(library, name, RUNNING)):
        lock = JournalLock.try_acquire(path)
        if lock is None:
            continue  # it is open elsewhere
        lock.release()
        try:
            past = ReplayedSession.from_journal(path, opened)
        except UnderstudyError:
            continue  # of another version, or cut off before anything was shown
        taught = opened.taught.get(name)
        saved = taught.lesson if taught is not None else None
        carried_to, lesson = past.about.get("carried_to"), past.history.lesson
        step = past.history.undoable or (f"going to {carried_to}" if carried_to else None)
        if (
            past.about.get("world") == world
            and step
            and not (saved is not None and is_same_lesson(saved, lesson))
        ):
            examples = sum(example.is_from_press for example in lesson.examples)
            return InterruptedSession(path, _date(path), examples, step)
    return None


def list_interrupted_sessions(library: Path, world: str, opened: Library) -> dict[str, InterruptedSession]:
    """List, by name, the newest interrupted session of each automaton in this world that has unsaved changes."""
    folder = library / FOLDER
    if not folder.is_dir():
        return {}
    matches = (_NAMED.fullmatch(path.name) for path in folder.iterdir())
    names = sorted({unquote(match[1]) for match in matches if match})
    left = {name: find_interrupted_session(library, name, world, opened) for name in names}
    return {name: each for name, each in left.items() if each is not None}


def finish_journal(path: Path, library: Path, name: str) -> Path:
    """Mark the journal of a session as ended, and delete the oldest ended ones."""
    ended = path.with_suffix(ENDED)
    with convert_os_errors(path, "marking the journal as ended"):
        path.rename(ended)
        for old in _of(library, name, ENDED)[:-KEPT]:
            old.unlink(missing_ok=True)
    return ended


def reopen_journal(ended: Path) -> None:
    """Mark an ended session as interrupted again."""
    with convert_os_errors(ended, "marking the journal as cut off"):
        ended.rename(ended.with_suffix(RUNNING))


def is_same_lesson(first: Lesson, second: Lesson) -> bool:
    """Return whether two lessons have the same examples, design and options, apart from their records."""
    one, other = (
        (each.properties, each.goal, identify_teaching(each, with_watched=True)) for each in (first, second)
    )
    return one == other


def _of(library: Path, name: str, ending: str) -> list[Path]:
    pattern = re.compile(
        re.escape(make_file_stem(name)) + r"-\d{4}-\d\d-\d\d-\d\d\.\d\d\.\d\d(-\d+)?" + re.escape(ending)
    )
    folder = library / FOLDER
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if pattern.fullmatch(path.name))


def _date(path: Path) -> datetime:
    match = re.search(r"\d{4}-\d\d-\d\d-\d\d\.\d\d\.\d\d", path.name)
    return datetime.strptime(match[0], "%Y-%m-%d-%H.%M.%S") if match else datetime.fromtimestamp(0)
