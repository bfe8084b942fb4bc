"""Lessons as CSV tables: one row per example, one column per feature with its kind in the header.

    state,next,kind,distance:continuous,bearing:toroidal(6.283185307179586),ready:categorical(no|yes)
    forward,done,directive,0.31,,yes

An empty cell is an absent reading. The automaton's states are `start`, then all states that the table names in
alphabetical order, so that the order of rows makes no difference. Each runs the behavior of its own name, or raises a
flag.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from understudy.errors import FileError
from understudy.model.example_table import ExampleTable, parse_lesson
from understudy.model.lesson import Lesson


class QueryRow(NamedTuple):
    """A row whose next state is to be predicted: a state and a feature vector."""

    state: str
    values: tuple[float, ...]


def _read_table(path: Path) -> ExampleTable:
    """Read the header and rows of a CSV table; errors name file, line and column."""

    def make_error(place: str, problem: str, remedy: str) -> FileError:
        return FileError(path=path, place=place, problem=problem, remedy=remedy)

    lines = csv.reader(io.StringIO(_text(path), newline=""), strict=True)
    try:
        rows = [(lines.line_num, [cell.strip() for cell in row]) for row in lines]
    except csv.Error as error:
        raise make_error(f"line {lines.line_num}", f"it is not a table: {error}", "mind the quotes") from None
    rows = [(line, row) for line, row in rows if any(row)]
    if not rows:
        raise make_error("", "it is empty", "begin with a line of columns: state,next,kind,…")
    (first, header), *rows = rows
    for column, title in enumerate(header):
        if not title:
            raise make_error(f"line {first}, column {column + 1}", "it has no name", "name it, or remove it")
    for line, row in rows:
        if len(row) != len(header):
            problem, remedy = f"it has {len(row)} cells", f"give one for each of the {len(header)} columns"
            raise make_error(f"line {line}", problem, remedy)
    return ExampleTable(header, [(f"line {line}", row) for line, row in rows], f"line {first}", make_error)


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


def read_lesson_table(
    path: Path | str, *, name: str | None = None, flags: Sequence[str] | None = None
) -> Lesson:
    """Read a lesson from a CSV file; its automaton is named after the file unless `name` is given.

    `flags` are the states in which it stops and raises a flag; None: *done* and *failed*, if they have no examples of
    their own.
    """
    return read_lesson_and_lines(path, name=name, flags=flags)[0]


def read_lesson_and_lines(
    path: Path | str, *, name: str | None = None, flags: Sequence[str] | None = None
) -> tuple[Lesson, Mapping[int, str]]:
    """Read a lesson as `read_lesson_table` does; return it with the line of each example, such as "line 2"."""
    path = Path(path)
    table = _read_table(path)
    lesson = parse_lesson(table, name=path.stem if name is None else name, flags=flags)
    return lesson, {number: place for number, (place, _) in enumerate(table.rows)}


def read_query_rows(path: Path | str, lesson: Lesson) -> tuple[QueryRow, ...]:
    """Read the rows to predict from a CSV file with a column `state` and one for each feature of the lesson.

    Columns may come in any order. `next` and `kind` are allowed and ignored; other columns are refused.
    """
    table = _read_table(Path(path))
    table.column("state")
    columns = table.match_features(lesson.automaton.features)
    rows = []
    for place, row in table.rows:
        state = table.name(place, row, "state")
        table.check_state(place, state, lesson.automaton, title="state")
        rows.append(QueryRow(state, table.values(place, row, columns)))
    return tuple(rows)
