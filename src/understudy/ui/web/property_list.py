"""The properties of the library's file on the page, and their tests with what is in training."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Literal, TypeAlias

from understudy.analysis.rollout import Progress
from understudy.errors import UnderstudyError, UnknownName
from understudy.model.property import Property
from understudy.properties.library_properties import try_property
from understudy.properties.property_file import FILE, load_tables, parse_property
from understudy.properties.run_property import PropertyResult, describe_result
from understudy.ui.controller.failing_worlds import Draft, LibrarySource, make_draft
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.background import BackgroundRun, LessonIdentity
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.property_requests import PropertyFieldsData
from understudy.ui.web.property_form import read_fields

VerdictName: TypeAlias = Literal["not tested", "holds", "fails", "undecided"]


class LibraryPropertyData(Data, frozen=True, kw_only=True):
    """A property of the library's file, and what its test proved."""

    name: str
    claim: str
    """The property in words; empty if its table is not valid."""
    problem: str
    """Why its table is not valid; empty if it is."""
    fields: PropertyFieldsData | None
    """The form to change it; null if only a person can, in the file."""
    verdict: VerdictName
    sentences: list[str]
    """The results of the test in sentences."""
    stale: bool
    """True if the lesson changed after the test."""


class LibraryPropertiesData(Data, frozen=True, kw_only=True):
    """The properties of the library's file."""

    problem: str
    """Why the file cannot be read; empty if it can."""
    rows: list[LibraryPropertyData]
    testing: str | None
    """The name of the property that is being tested."""
    finished: int
    """The number of worlds of that test that have been run, of `total`."""
    total: int


class RunningTests(BackgroundRun[list[PropertyResult]]):
    """Properties that are tested one after the other."""

    def __init__(self, subjects: Sequence[Property], library: LibrarySource, draft: Draft | None) -> None:
        self.testing: str | None = subjects[0].name if subjects else None
        self.results = list[PropertyResult]()
        super().__init__(partial(self._test, subjects, library, draft))

    def _test(
        self, subjects: Sequence[Property], library: LibrarySource, draft: Draft | None, progress: Progress
    ) -> list[PropertyResult]:
        for subject in subjects:
            self.testing, self.finished = subject.name, 0
            open_world = partial(library.open_world, draft=draft)
            self.results.append(try_property(subject, open_world, progress=progress))
        return self.results


class LibraryPropertyList:
    """The properties of the file in a library's folder, and the results of their tests."""

    def __init__(self) -> None:
        self.path = Path(FILE)
        self._problem = ""
        self.tables: dict[str, object] = {}
        self._subjects: dict[str, Property | str] = {}  # or why it is not valid
        self._results: dict[str, PropertyResult] = {}
        self._outdated: set[str] = set()  # the lesson has changed since
        self._lesson = LessonIdentity()
        self._running: RunningTests | None = None
        self._taken = 0

    def use_folder(self, folder: Path) -> None:
        """Read the file in a library's folder; results are kept if it is the same one."""
        if folder / FILE != self.path:
            self.cancel()
            self._results, self._outdated = {}, set()
        self.path = folder / FILE
        self.read()

    def read(self) -> None:
        """Read the file again, and drop the results of properties that are no longer the same."""
        self._problem, self.tables, self._subjects = "", {}, {}
        try:
            self.tables = load_tables(self.path) if self.path.exists() else {}
        except UnderstudyError as error:
            self._problem = str(error)
        for name, table in self.tables.items():
            try:
                self._subjects[name] = parse_property(self.path, name, table)
            except UnderstudyError as error:
                self._subjects[name] = str(error)
        results = self._results.items()
        self._results = {name: each for name, each in results if each.tested == self._subjects.get(name)}

    def begin_tests(self, name: str | None, library: LibrarySource, trainer: Trainer | None) -> int:
        """Begin to test one property, or all; return their number. Tests that have not ended are cancelled."""
        if name is not None and name not in self.tables:
            raise UnknownName(what="property", name=name, where=str(self.path), known=list(self.tables))
        self.cancel()
        chosen = [
            each for key, each in self._subjects.items() if isinstance(each, Property) and name in (None, key)
        ]
        if self._lesson.has_changed(trainer):
            self._outdated |= set(self._results)
        self._lesson.note_run(trainer)
        self._running, self._taken = RunningTests(chosen, library, make_draft(trainer)), 0
        return len(chosen)

    def cancel(self) -> None:
        """Cancel the tests."""
        if self._running is not None:
            self._running.cancel()
            self._running = None

    def advance(self) -> None:
        """Take over the results of tests that have ended."""
        running = self._running
        if running is None:
            return
        ended = not running.is_running
        new = running.results[self._taken :]
        self._taken += len(new)
        self._take(new)
        if ended:
            self._running = None

    def take_rerun(self, results: Iterable[PropertyResult], trainer: Trainer | None, *, stale: bool) -> None:
        """Take over results of tests that were run elsewhere; with `stale`, before the lesson changed."""
        rerun = list(results)
        if not stale:
            if self._lesson.has_changed(trainer):
                self._outdated |= set(self._results)
            self._lesson.note_run(trainer)
        self._take(rerun)
        if stale:
            self._outdated |= {each.tested.name for each in rerun}

    def _take(self, results: Iterable[PropertyResult]) -> None:
        for each in results:
            name = each.tested.name
            if self._subjects.get(name) == each.tested:
                self._results[name] = each
                self._outdated.discard(name)

    def data(self, trainer: Trainer | None) -> LibraryPropertiesData:
        """Return the properties as the page shows them."""
        running = self._running
        changed = bool(self._results) and self._lesson.has_changed(trainer)
        return LibraryPropertiesData(
            problem=self._problem,
            rows=[self._describe(name, changed=changed) for name in self._subjects],
            testing=None if running is None else running.testing,
            finished=0 if running is None else running.finished,
            total=1 if running is None else running.total,
        )

    def _describe(self, name: str, *, changed: bool) -> LibraryPropertyData:
        subject, result = self._subjects[name], self._results.get(name)
        verdict: VerdictName = "not tested"
        if result is not None:
            verdict = result.verdict.value
        return LibraryPropertyData(
            name=name,
            claim="" if isinstance(subject, str) else subject.claim,
            problem=subject if isinstance(subject, str) else "",
            fields=read_fields(self.tables[name]),
            verdict=verdict,
            sentences=[] if result is None else list(describe_result(result)),
            stale=result is not None and (changed or name in self._outdated),
        )
