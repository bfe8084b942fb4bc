"""A library's folder for the page: the automata that open, the errors of the others, and the trash.

library/.trash/goto.json        a removed automaton; library/.trash/goto~2.json, removed after that
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote

from msgspec import field

from understudy.errors import FileError, SessionError, UnderstudyError, UnknownName
from understudy.learning.fit import learn
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.runtime.link import link
from understudy.storage.atomic_write import convert_os_errors, lock_folder, sync_folder
from understudy.storage.library_folder import (
    list_versions,
    make_file_stem,
    normalize_name,
    open_each_automaton,
    save_automaton,
)
from understudy.ui.controller.training_plan import check_new_name
from understudy.ui.web.messages.base import Data

TRASH = ".trash"
NOT_IN_NAMES = "(),="
_TRASHED = re.compile(r"([^~]+)(?:~(\d+))?\.json")


class TrainedBehaviorData(Data, frozen=True, kw_only=True):
    """An automaton of the library."""

    name: str
    parameters: list[str] = field(default_factory=list)
    runs: list[str] = field(default_factory=list)
    """The behaviors that its states run."""
    flags: list[str] = field(default_factory=list)
    """The flags that it can raise: done, failed, or any name."""
    examples: int = 0
    versions: int = 0
    """The number of former versions."""
    complete: bool
    """Whether it can be run."""
    problem: str | None
    """Why it cannot be run; null if it can."""


class InterruptedSessionData(Data, frozen=True, kw_only=True):
    """A session that was interrupted before it was saved; opening it resumes it."""

    name: str
    examples: int
    began: str


class LibraryData(Data, frozen=True, kw_only=True):
    """The library's folder."""

    folder: str
    basic: list[str]
    trained: list[TrainedBehaviorData]
    trash: list[str]
    interrupted: list[InterruptedSessionData]


@dataclass(frozen=True)
class LibraryView:
    """The content of a library's folder, read file by file so that one invalid file does not hide the others."""

    folder: Path
    library: Library
    problems: dict[str, str]
    """Why a document cannot be opened, by the name of its file."""
    trash: tuple[str, ...]

    def refuse_new(self, name: str, *, remedy: str) -> None:
        """Raise SessionError if a new automaton may not have this name."""
        if any(each in NOT_IN_NAMES for each in name):
            problem = "goto(A) binds a target, and a=b names a state"
            raise SessionError(f"{name!r} cannot be the name of a state: {problem}; leave out ( ) , and =")
        check_new_name(name, "an automaton")
        self.refuse_taken(name, remedy=remedy)

    def refuse_taken(self, name: str, *, remedy: str) -> None:
        """Raise SessionError if the folder has a document of this or a similar name."""
        for other in [*self.library.taught, *self.problems]:
            if normalize_name(other) == normalize_name(name):
                raise SessionError(f"the library has {other} already: {remedy}")

    def find_automaton(self, name: str) -> TrainedAutomaton:
        """Return the automaton of this name as it is in the library."""
        if name in self.problems:
            raise SessionError(self.problems[name])
        if name not in self.library.taught:
            raise UnknownName(
                what="automaton", name=name, where="the library", known=list(self.library.taught)
            )
        return self.library.taught[name]

    def data(self, cut_off: list[InterruptedSessionData]) -> LibraryData:
        """Return the library as the page shows it, with the interrupted sessions."""
        return LibraryData(
            folder=str(self.folder),
            basic=list(self.library.kit.behaviors),
            trained=[
                *(self._row(name) for name in self.library.taught),
                *(
                    TrainedBehaviorData(name=name, complete=False, problem=problem)
                    for name, problem in self.problems.items()
                ),
            ],
            trash=list(self.trash),
            interrupted=cut_off,
        )

    def _row(self, name: str) -> TrainedBehaviorData:
        taught = self.library.taught[name]
        states = taught.automaton.states
        runs = dict.fromkeys(
            self.library.format_call(each.behavior, each.binding) for each in states if each.behavior
        )
        why_not = self._why_not(name)
        lesson = taught.lesson
        return TrainedBehaviorData.of(
            taught.automaton,
            runs=list(runs),
            examples=0 if lesson is None else sum(example.is_from_press for example in lesson.examples),
            versions=len(list_versions(self.folder, name)),
            complete=why_not is None,
            problem=why_not,
        )

    def _why_not(self, name: str) -> str | None:
        """Return why an automaton cannot be run; None if it can."""
        targets = self.library.kit.targets
        bound = {parameter: next(iter(targets), "") for parameter in self.library.parameters(name)}
        try:
            link(self.library, name, bound)
        except UnderstudyError as error:
            return str(error)
        return None


def check_folder(folder: Path) -> None:
    """Raise FileError if a path is not a folder and cannot become one."""
    with convert_os_errors(folder, "opening the library"):
        there = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not there.is_dir():
        remedy = "give a folder; it is created if it does not exist"
        raise FileError(path=there, place="", problem="it is a file, not a folder", remedy=remedy)
    if there != folder and not os.access(there, os.W_OK):
        remedy = "give another, or make it writable"
        raise FileError(path=folder, place="", problem=f"it cannot be created in {there}", remedy=remedy)


def read_library_folder(folder: Path, kit: Kit) -> LibraryView:
    """Read a library's folder; the result is empty if the folder does not exist yet."""
    trash = tuple(sorted({name for name, _, _ in _trashed(folder)}))
    if not folder.exists():
        return LibraryView(folder, Library(kit), {}, trash)
    opened = open_each_automaton(folder, kit, learn)
    problems = {unquote(Path(file).stem): str(error) for file, error in opened.problems.items()}
    return LibraryView(folder, opened.library, problems, trash)


def save_copy(library_view: LibraryView, taught: TrainedAutomaton, name: str) -> None:
    """Save an automaton under another name."""
    save_automaton(library_view.folder, make_renamed_copy(library_view, taught, name))


def make_renamed_copy(library_view: LibraryView, taught: TrainedAutomaton, name: str) -> TrainedAutomaton:
    """Return a copy of an automaton under another name; refuse a name that the library cannot accept."""
    automaton, lesson = replace(taught.automaton, name=name), taught.lesson
    if lesson is not None:
        lesson = replace(lesson, automaton=replace(lesson.automaton, name=name))
    copy = TrainedAutomaton(automaton, lesson)
    library_view.library.with_automaton(copy)
    return copy


def move_to_trash(library_view: LibraryView, name: str) -> None:
    """Move an automaton to the trash."""
    path = library_view.folder / f"{make_file_stem(name)}.json"
    if not path.is_file():
        names = [*library_view.library.taught, *library_view.problems]
        raise UnknownName(what="automaton", name=name, where="the library", known=names)
    users = [user for user in library_view.library.find_users(name) if user != name]
    if users:
        raise SessionError(f"{name} is used by {', '.join(users)}: remove that first")
    trash = library_view.folder / TRASH
    numbers = [number for names, number, _ in _trashed(library_view.folder) if names == name]
    number = max(numbers, default=0) + 1
    ending = "" if number == 1 else f"~{number}"
    with convert_os_errors(path, "removing"):
        trash.mkdir(exist_ok=True)
        with lock_folder(library_view.folder):
            path.rename(trash / f"{make_file_stem(name)}{ending}.json")
            sync_folder(trash)
            sync_folder(library_view.folder)


def restore_from_trash(library_view: LibraryView, name: str) -> None:
    """Restore the document that was trashed last under a name."""
    trashed = [(number, path) for former, number, path in _trashed(library_view.folder) if former == name]
    if not trashed:
        raise UnknownName(what="automaton", name=name, where="the trash", known=list(library_view.trash))
    library_view.refuse_taken(name, remedy="remove that first")
    path = library_view.folder / f"{make_file_stem(name)}.json"
    with convert_os_errors(path, "restoring"), lock_folder(library_view.folder):
        max(trashed)[1].rename(path)
        sync_folder(library_view.folder)


def _trashed(folder: Path) -> list[tuple[str, int, Path]]:
    """Return the name, number and path of each file in the trash."""
    trash = folder / TRASH
    if not trash.is_dir():
        return []
    matches = [(_TRASHED.fullmatch(path.name), path) for path in sorted(trash.iterdir())]
    return [(unquote(match[1]), int(match[2] or 1), path) for match, path in matches if match]
