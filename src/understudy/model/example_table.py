"""Tables of examples: one row per example, one column per feature with its kind in the title.

CSV files (`learning/csv_table.py`) and data frames (`example_frame.py`) are such tables. The columns are `state`,
`next`, `kind`, and one FEATURE:KIND for each feature, such as distance:continuous or ready:categorical(no|yes).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from understudy.errors import DefinitionError, KindError, UnderstudyError, UnknownName, join_names
from understudy.model.automaton import START, USUAL_FLAGS, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.value_kinds import KIND_SPELLED, Kind, parse_kind, parse_value

KINDS = tuple(kind.value for kind in ExampleKind)
NAMED = ("state", "next", "kind")
"""The titles of the columns that are no features."""


@dataclass(frozen=True)
class ExampleTable:
    """The titles and cells of a table of examples, as text; an empty cell is an absent value.

    Attributes
    ----------
    header
        The titles of the columns.
    rows
        The place of each row, such as "line 2", and its cells.
    head
        The place of the header, such as "line 1"; empty if it has none.
    make_error
        Makes an error of a place in the table, a problem and a remedy.
    """

    header: Sequence[str]
    rows: Sequence[tuple[str, Sequence[str]]]
    head: str
    make_error: Callable[[str, str, str], UnderstudyError]

    def locate(self, title: str) -> str:
        """Return the place of a column's title."""
        return self._at(self.head, f"column {title!r}")

    def _at(self, *places: str) -> str:
        return ", ".join(each for each in places if each)

    def column(self, title: str) -> int:
        """Return the position of the column with this title; refuse a title that is not there."""
        if title not in self.header:
            raise self.make_error(
                self.head,
                f"there is no column {title!r}; the columns are {join_names(self.header)}",
                f"add the column {title!r}" if len(self.header) > 1 else "put commas between the columns",
            )
        return self.header.index(title)

    def features(self) -> list[tuple[int, str, Kind]]:
        """List the position, name and kind of each column that is a feature."""
        columns: list[tuple[int, str, Kind]] = []
        for column, title in enumerate(self.header):
            place = self.locate(title)
            if self.header.count(title) > 1:
                raise self.make_error(place, "there are two of this name", "rename or remove one of the two")
            if title in NAMED:
                continue
            name, spelled = split_title(title)
            if not spelled or not name:
                raise self.make_error(
                    place,
                    "a feature's column names its kind",
                    f"write {name or 'NAME'}:continuous, or another kind",
                )
            if name in [other for _, other, _ in columns]:
                raise self.make_error(
                    place, f"feature {name!r} has two columns", "rename or remove one of the two"
                )
            try:
                columns.append((column, name, parse_kind(spelled, where=place)))
            except KindError as error:
                raise self.make_error(place, error.problem, error.remedy) from None
        return columns

    def values(
        self, place: str, row: Sequence[str], columns: Sequence[tuple[int, Kind]]
    ) -> tuple[float, ...]:
        """Parse the cells of a row's features."""
        values = []
        for column, kind in columns:
            where = self._at(place, f"column {self.header[column]!r}")
            try:
                values.append(parse_value(row[column], kind, where=where))
            except KindError as error:
                raise self.make_error(where, error.problem, error.remedy) from None
        return tuple(values)

    def name(self, place: str, row: Sequence[str], title: str) -> str:
        """Return the cell of a column that must not be empty."""
        cell = row[self.column(title)]
        if not cell:
            raise self.make_error(self._at(place, f"column {title!r}"), "it is empty", "name a state")
        return cell

    def match_features(self, features: Sequence[BoundFeature]) -> list[tuple[int, Kind]]:
        """Return the position and kind of the column of each of a lesson's features; refuse other columns."""
        there = {name: (column, kind) for column, name, kind in self.features()}
        wanted = {str(bound): bound.kind for bound in features}
        columns = []
        for name, kind in wanted.items():
            if name not in there:
                self.column(f"{name}:{kind}")
            column, spelled = there[name]
            if spelled != kind:
                raise self.make_error(
                    self.locate(self.header[column]),
                    f"feature {name!r} is {kind} in the lesson",
                    f"write {name}:{kind}",
                )
            columns.append((column, kind))
        for name, (column, _) in there.items():
            if name not in wanted:
                raise self.make_error(
                    self.locate(self.header[column]),
                    f"the lesson has no feature {name!r}",
                    f"remove it; the features are {join_names(wanted)}",
                )
        return columns

    def check_state(self, place: str, state: str, automaton: Automaton, *, title: str) -> None:
        """Refuse a state that an automaton does not have."""
        try:
            automaton.index(state)
        except UnknownName as error:
            raise self.make_error(
                self._at(place, f"column {title!r}"),
                f"the lesson has no state {state!r}",
                f"write one of {join_names(error.known)}",
            ) from None

    def examples(self, columns: Sequence[tuple[int, Kind]]) -> Iterator[Example]:
        """Parse the examples, one per row, with the features of these columns."""
        for number, (place, row) in enumerate(self.rows):
            spelled = row[self.column("kind")]
            if spelled not in KINDS:
                raise self.make_error(
                    self._at(place, "column 'kind'"),
                    f"{spelled!r} is not a kind of example",
                    f"write {' or '.join(KINDS)}",
                )
            yield Example(
                number,
                self.name(place, row, "state"),
                self.values(place, row, columns),
                self.name(place, row, "next"),
                ExampleKind(spelled),
            )


def parse_lesson(table: ExampleTable, *, name: str, flags: Sequence[str] | None = None) -> Lesson:
    """Make the lesson of a table. Its states are `start` and all that the table names, in alphabetical order.

    Each state runs the behavior of its own name, and each feature is the body's reading of its own name. `flags` are
    the states in which it stops and raises a flag; None: *done* and *failed*, if they have no examples of their own.
    """
    _check_columns(table)
    features = table.features()
    examples = tuple(table.examples([(column, kind) for column, _, kind in features]))
    named = sorted({name for example in examples for name in (example.state, example.next)} - {START.name})
    raised = _find_flags(table, examples, flags)
    try:
        automaton = Automaton(
            name,
            (START, *(State(each, flag=each) if each in raised else State(each, each) for each in named)),
            tuple(BoundFeature(Feature(title, kind, reading=title)) for _, title, kind in features),
        )
    except DefinitionError as error:
        raise table.make_error("", error.problem, error.remedy) from None
    return Lesson(automaton, examples)


def _find_flags(
    table: ExampleTable, examples: Sequence[Example], flags: Sequence[str] | None
) -> Sequence[str]:
    """Return the next states that are flags; refuse those that are left, or that no example leads to."""
    left = {example.state: place for (place, _), example in zip(table.rows, examples, strict=True)}
    if flags is None:
        return [each for each in USUAL_FLAGS if each not in left]
    following = {example.next for example in examples}
    for flag in flags:
        if flag == START.name:
            raise table.make_error("", f"{flag!r} is the first state, which idles", "name another flag")
        if flag in left:
            problem, remedy = f"{flag!r} is a flag, which is never left", "leave the row out, or the flag"
            raise table.make_error(left[flag], problem, remedy)
        if flag not in following:
            problem = f"no example leads to the flag {flag!r}"
            raise table.make_error("", problem, f"name one of {join_names(sorted(following - set(left)))}")
    return flags


def parse_examples(table: ExampleTable, automaton: Automaton) -> tuple[Example, ...]:
    """Parse the examples of a table for an automaton, whose states and features must be those of the table."""
    _check_columns(table)
    examples = tuple(table.examples(table.match_features(automaton.features)))
    for (place, _), example in zip(table.rows, examples, strict=True):
        table.check_state(place, example.state, automaton, title="state")
        table.check_state(place, example.next, automaton, title="next")
    return examples


def _check_columns(table: ExampleTable) -> None:
    for title in NAMED:
        table.column(title)
    if not table.rows:
        raise table.make_error("", "it has no examples", "add a row for each of them")


def list_titles(features: Sequence[BoundFeature]) -> Mapping[str, Kind]:
    """Return the title of the column of each feature, such as "distance(station):continuous", with its kind."""
    return {f"{bound}:{bound.kind}": bound.kind for bound in features}


def split_title(title: str) -> tuple[str, str]:
    """Split a column's title into a feature's name and kind, both of which may contain colons."""
    names = [title[:end].strip() for end, letter in enumerate(title) if letter == ":"]
    kinds = [title[end + 1 :].strip() for end, letter in enumerate(title) if letter == ":"]
    for name, spelled in zip(names, kinds, strict=True):
        if KIND_SPELLED.fullmatch(spelled):
            return name, spelled
    return (names[-1], kinds[-1]) if names else (title, "")
