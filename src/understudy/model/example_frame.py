"""Lessons as data frames: the table of examples that `understudy learn table` reads from CSV."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from math import isnan
from typing import Any

from understudy.errors import DefinitionError, KindError
from understudy.model.automaton import Automaton
from understudy.model.data_frames import WHAT, Cell, make_frame, read_frame
from understudy.model.example_table import (
    NAMED,
    ExampleTable,
    list_titles,
    parse_examples,
    parse_lesson,
    split_title,
)
from understudy.model.lesson import Lesson
from understudy.model.value_kinds import BOOLEAN, Categorical, Kind, parse_kind


def list_example_columns(lesson: Lesson) -> tuple[dict[str, list[Cell]], dict[str, type]]:
    """List the columns of a lesson's table of examples, and the type of each."""
    titles = list_titles(lesson.automaton.features)
    examples = lesson.examples
    columns: dict[str, list[Cell]] = {
        "state": [example.state for example in examples],
        "next": [example.next for example in examples],
        "kind": [example.kind.value for example in examples],
    }
    for index, (title, kind) in enumerate(titles.items()):
        columns[title] = [_format_cell(example.values[index], kind) for example in examples]
    kinds = {title: str if isinstance(kind, Categorical) else float for title, kind in titles.items()}
    return columns, {**dict.fromkeys(NAMED, str), **kinds}


def _format_cell(value: float, kind: Kind) -> Cell:
    """Return a feature value as a table has it: a number, a label, or None if it is absent."""
    if isnan(value):
        return None
    return kind.labels[int(value)] if isinstance(kind, Categorical) else float(value)


def make_example_frame(lesson: Lesson, *, backend: str | None = None) -> Any:
    """Make the table of a lesson's examples; see `Lesson.to_frame`."""
    columns, types = list_example_columns(lesson)
    return make_frame(columns, types, backend=backend)


def parse_example_frame(
    frame: object, *, name: str | None, automaton: Automaton | None, flags: Sequence[str] | None = None
) -> Lesson:
    """Make the lesson of a table of examples; see `Lesson.from_frame`."""
    columns = read_frame(frame)
    kinds = {title: _find_labels(title) for title in columns}
    cells = [[_spell(value, kinds[title]) for value in values] for title, values in columns.items()]
    rows = [(f"row {number}", row) for number, row in enumerate(zip(*cells, strict=True))]
    table = ExampleTable(tuple(columns), rows, "", _make_error)
    if automaton is None:
        return parse_lesson(table, name="lesson" if name is None else name, flags=flags)
    design = replace(automaton, transitions={}, name=automaton.name if name is None else name)
    return Lesson(design, parse_examples(table, design))


def _make_error(place: str, problem: str, remedy: str) -> DefinitionError:
    what = f"{WHAT}, {place}" if place else WHAT
    remedy = remedy.replace("put commas between the columns", "give a frame with these columns")
    return DefinitionError(what=what, problem=problem, remedy=remedy)


def _find_labels(title: str) -> tuple[str, ...]:
    """Return the labels of a categorical column, by its title; () for other columns."""
    with suppress(KindError):  # reported, with its place, when the table is parsed
        kind = parse_kind(split_title(title)[1], where=title)
        return kind.labels if isinstance(kind, Categorical) else ()
    return ()


def _spell(value: Any, labels: tuple[str, ...]) -> str:
    """Write a cell as CSV would: a number or a truth value of a frame may stand for the label that looks like it."""
    if value is None:
        return ""
    if isinstance(value, bool) and labels == BOOLEAN.labels:
        return BOOLEAN.labels[value]
    if labels and isinstance(value, float) and value.is_integer() and str(value) not in labels:
        return str(int(value))  # pandas makes floats of whole numbers beside absent ones
    return str(value)
