"""The properties of the library's file on the page: their forms, and their tests with what is in training."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeAlias

from understudy.errors import FileError, UnderstudyError, UnknownName
from understudy.judging.properties.library_properties import try_property
from understudy.judging.properties.property_file import (
    CLAIM_KEYS,
    CLAIMS,
    FILE,
    PropertyTable,
    load_tables,
    parse_property,
)
from understudy.judging.properties.run_property import PropertyResult, describe_result
from understudy.judging.rollout import Progress
from understudy.model.property import PROGRESS, Property, PropertyKind
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values
from understudy.sim.scenario.toml_writer import format_toml_value
from understudy.ui.controller.beside import Beside
from understudy.ui.controller.failing_worlds import Draft, LibrarySource, make_draft
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.background import BackgroundRun, LessonIdentity
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import PropertyFieldsData

VerdictName: TypeAlias = Literal["not tested", "holds", "fails", "undecided"]
FIELDS = {
    "": "name",
    "never": "condition",
    "always": "condition",
    "while": "condition",
    "without": "kind",
    "within_s": "seconds",
    "never_longer_than_s": "seconds",
}
"""By the key of a table, the field of the form, where it has another name."""


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
    testing: str | None = None
    """The name of the property that is being tested."""
    finished: int = 0
    """The number of worlds of that test that have been run, of `total`."""
    total: int = 1


class RunningTests(BackgroundRun[list[PropertyResult]]):
    """Properties that are tested one after the other."""

    def __init__(
        self, subjects: Sequence[Property], library: LibrarySource, draft: Draft | None, beside: Beside
    ) -> None:
        self.testing: str | None = subjects[0].name if subjects else None
        self.results = list[PropertyResult]()
        super().__init__(partial(self._test, subjects, library, draft), beside)

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

    def __init__(self, beside: Beside) -> None:
        self._beside = beside
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
        self._running, self._taken = RunningTests(chosen, library, make_draft(trainer), self._beside), 0
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
        running, changed = self._running, bool(self._results) and self._lesson.has_changed(trainer)
        rows = [self._describe(name, changed=changed) for name in self._subjects]
        return LibraryPropertiesData.of(running, problem=self._problem, rows=rows)

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


def make_property_table(path: Path | str, name: str, fields: PropertyFieldsData) -> dict[str, Any]:
    """Make the table of a property from the fields of its form; FileError if a field is empty that must not be."""
    table: dict[str, Any] = {"behavior": fields.behavior}
    if fields.targets:
        table["targets"] = dict(fields.targets)
    table |= {"world": fields.world, "seeds": _parse_seeds(path, name, fields.seeds)}
    for key in CLAIM_KEYS[fields.kind]:
        if FIELDS[key] != "seconds":
            table[key] = PROGRESS if fields.kind is PropertyKind.PROGRESS else fields.condition
        elif fields.seconds is None:
            raise _wrong(path, name, key, "is missing", "give the time in s")
        else:
            table[key] = _shorten(fields.seconds)
    if fields.limit_s is not None:
        table["limit_s"] = _shorten(fields.limit_s)
    if fields.at_least is not None:
        table["at_least"] = _shorten(fields.at_least)
    return table


def _parse_seeds(path: Path | str, name: str, text: str) -> Any:
    try:
        table = tomllib.loads(f"seeds = {text}")
    except ValueError:
        table = {}
    if list(table) != ["seeds"]:
        remedy = "give their number, as 200, or a list, as [1, 4], or { first = 1000, count = 200 }"
        raise _wrong(path, name, "seeds", f"are {text!r:.60}" if text.strip() else "are missing", remedy)
    return table["seeds"]


def _shorten(number: float) -> float:
    """Return a whole number as one, so that it is written without a point."""
    return int(number) if number.is_integer() else number


def _wrong(path: Path | str, name: str, key: str, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place=f"{name}.{key}", problem=problem, remedy=remedy)


def find_field(name: str, error: FileError) -> tuple[str, str]:
    """Return the field of a property's form that an error is about, and the error without its file and table."""
    key = error.place.removeprefix(name).removeprefix(".")
    of_table = error.place == name or error.place.startswith(f"{name}.")
    if not of_table:
        return "", str(error)
    field = FIELDS.get(key, key.partition(".")[0])
    return field, f"{key or name}: {error.problem}; {error.remedy}"


def read_fields(table: object) -> PropertyFieldsData | None:
    """Return the fields of a table's form; None if its keys are not those of a property."""
    if not isinstance(table, dict):
        return None
    decoded = decode_toml_values(table, PropertyTable)
    if isinstance(decoded, DecodeProblem) or sum(key in table for key in CLAIMS) != 1:
        return None
    kinds = (kind for kind, keys in CLAIM_KEYS.items() if all(key in table for key in keys))
    return PropertyFieldsData.of(
        decoded,
        kind=next(kinds, PropertyKind.PROGRESS),
        condition=next((table[key] for key in ("never", "always", "while") if key in table), ""),
        seconds=table.get("within_s", table.get("never_longer_than_s")),
        seeds=format_toml_value(table["seeds"]),
    )
