"""Lessons as CSV tables: one row per example, one column per feature with its kind in the header.

    state,next,kind,distance:continuous,bearing:toroidal(6.283185307179586),ready:categorical(no|yes)
    forward,done,directive,0.31,,yes

An empty cell is an absent reading. The automaton's states are `start`, then all states that the table names in
alphabetical order, so that the order of rows makes no difference. Each runs the behavior of its own name.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from understudy.errors import DefinitionError, FileError, KindError, UnknownName, join_names
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import KIND_SPELLED, Kind, parse_kind, parse_value
from understudy.model.lesson import Example, ExampleKind, Lesson

KINDS = tuple(kind.value for kind in ExampleKind)
NAMED = ("state", "next", "kind")


class QueryRow(NamedTuple):
    """A row whose next state is to be predicted: a state and a feature vector."""

    state: str
    values: tuple[float, ...]


class _CsvTable:
    """The header and rows of a CSV table; its errors name file, line and column."""

    def __init__(self, path: Path) -> None:
        self.path = path
        lines = csv.reader(io.StringIO(_text(path), newline=""), strict=True)
        try:
            rows = [(lines.line_num, [cell.strip() for cell in row]) for row in lines]
        except csv.Error as error:
            raise self.make_error(
                f"line {lines.line_num}", f"it is not a table: {error}", "mind the quotes"
            ) from None
        rows = [(line, row) for line, row in rows if any(row)]
        if not rows:
            raise self.make_error("", "it is empty", "begin with a line of columns: state,next,kind,…")
        (self.line, self.header), *self.rows = rows
        for column, title in enumerate(self.header):
            if not title:
                raise self.make_error(
                    f"line {self.line}, column {column + 1}", "it has no name", "name it, or remove it"
                )
        for line, row in self.rows:
            if len(row) != len(self.header):
                raise self.make_error(
                    f"line {line}",
                    f"it has {len(row)} cells",
                    f"give one for each of the {len(self.header)} columns",
                )

    def make_error(self, place: str, problem: str, remedy: str) -> FileError:
        return FileError(path=self.path, place=place, problem=problem, remedy=remedy)

    def column(self, title: str) -> int:
        """Return the position of the column with this title; refuse a title that is not there."""
        if title not in self.header:
            raise self.make_error(
                f"line {self.line}",
                f"there is no column {title!r}; the columns are {join_names(self.header)}",
                f"add the column {title!r}" if len(self.header) > 1 else "put commas between the columns",
            )
        return self.header.index(title)

    def features(self) -> list[tuple[int, str, Kind]]:
        """List the position, name and kind of each column that is a feature."""
        found: list[tuple[int, str, Kind]] = []
        for column, title in enumerate(self.header):
            place = f"line {self.line}, column {title!r}"
            if self.header.count(title) > 1:
                raise self.make_error(place, "there are two of this name", "rename or remove one of the two")
            if title in NAMED:
                continue
            name, spelled = _name_and_kind(title)
            if not spelled or not name:
                raise self.make_error(
                    place,
                    "a feature's column names its kind",
                    f"write {name or 'NAME'}:continuous, or another kind",
                )
            if name in [other for _, other, _ in found]:
                raise self.make_error(
                    place, f"feature {name!r} has two columns", "rename or remove one of the two"
                )
            try:
                found.append((column, name, parse_kind(spelled, where=place)))
            except KindError as error:
                raise self.make_error(place, error.problem, error.remedy) from None
        return found

    def values(self, line: int, row: Sequence[str], columns: Iterable[tuple[int, Kind]]) -> tuple[float, ...]:
        """Parse the cells of a row's features."""
        found = []
        for column, kind in columns:
            place = f"line {line}, column {self.header[column]!r}"
            try:
                found.append(parse_value(row[column], kind, where=place))
            except KindError as error:
                raise self.make_error(place, error.problem, error.remedy) from None
        return tuple(found)

    def name(self, line: int, row: Sequence[str], title: str) -> str:
        """Return the cell of a column that must not be empty."""
        cell = row[self.column(title)]
        if not cell:
            raise self.make_error(f"line {line}, column {title!r}", "it is empty", "name a state")
        return cell


def _name_and_kind(title: str) -> tuple[str, str]:
    """Split a column's title into a feature's name and kind, both of which may contain colons."""
    names = [title[:end].strip() for end, letter in enumerate(title) if letter == ":"]
    kinds = [title[end + 1 :].strip() for end, letter in enumerate(title) if letter == ":"]
    for name, spelled in zip(names, kinds, strict=True):
        if KIND_SPELLED.fullmatch(spelled):
            return name, spelled
    return (names[-1], kinds[-1]) if names else (title, "")


def _text(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        problem = error.strerror or str(error)
        raise FileError(
            path=path, place="", problem=problem, remedy="name a CSV file that can be read"
        ) from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FileError(
            path=path, place=f"line {line}", problem="it is not UTF-8 text", remedy="save it as UTF-8"
        ) from None


def read_lesson_table(path: Path | str, *, name: str | None = None) -> Lesson:
    """Read a lesson from a CSV file; its automaton is named after the file unless `name` is given."""
    table = _CsvTable(Path(path))
    for title in NAMED:
        table.column(title)
    features = table.features()
    if not table.rows:
        raise table.make_error("", "it has no examples", "add a row for each of them")
    examples = tuple(_examples(table, [(column, kind) for column, _, kind in features]))
    named = sorted({name for example in examples for name in (example.state, example.next)} - {START.name})
    try:
        automaton = Automaton(
            table.path.stem if name is None else name,
            (START, *(State(state, state) for state in named)),
            tuple(BoundFeature(Feature(title, kind, reading=title)) for _, title, kind in features),
        )
    except DefinitionError as error:
        raise table.make_error("", error.problem, error.remedy) from None
    return Lesson(automaton, examples)


def _examples(table: _CsvTable, columns: Sequence[tuple[int, Kind]]) -> Iterator[Example]:
    for number, (line, row) in enumerate(table.rows):
        spelled = row[table.column("kind")]
        if spelled not in KINDS:
            raise table.make_error(
                f"line {line}, column 'kind'",
                f"{spelled!r} is not a kind of example",
                f"write {' or '.join(KINDS)}",
            )
        yield Example(
            number,
            table.name(line, row, "state"),
            table.values(line, row, columns),
            table.name(line, row, "next"),
            ExampleKind(spelled),
        )


def read_query_rows(path: Path | str, lesson: Lesson) -> tuple[QueryRow, ...]:
    """Read the rows to predict from a CSV file with a column `state` and one for each feature of the lesson.

    Columns may come in any order. `next` and `kind` are allowed and ignored; other columns are refused.
    """
    table = _CsvTable(Path(path))
    table.column("state")
    there = {name: (column, kind) for column, name, kind in table.features()}
    wanted = {str(bound): bound.kind for bound in lesson.automaton.features}
    columns = []
    for name, kind in wanted.items():
        if name not in there:
            table.column(f"{name}:{kind}")
        column, spelled = there[name]
        if spelled != kind:
            raise table.make_error(
                f"line {table.line}, column {table.header[column]!r}",
                f"feature {name!r} is {kind} in the lesson",
                f"write {name}:{kind}",
            )
        columns.append((column, kind))
    for name, (column, _) in there.items():
        if name not in wanted:
            raise table.make_error(
                f"line {table.line}, column {table.header[column]!r}",
                f"the lesson has no feature {name!r}",
                f"remove it; the features are {join_names(wanted)}",
            )
    rows = []
    for line, row in table.rows:
        state = table.name(line, row, "state")
        try:
            lesson.automaton.index(state)
        except UnknownName as error:
            raise table.make_error(
                f"line {line}, column 'state'",
                f"the lesson has no state {state!r}",
                f"write one of {join_names(error.known)}",
            ) from None
        rows.append(QueryRow(state, table.values(line, row, columns)))
    return tuple(rows)
