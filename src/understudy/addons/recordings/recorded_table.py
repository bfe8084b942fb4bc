"""A recording of another program as a table: rows of cells, and what was left out when it was read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.table_cells import CellValues, parse_number, read_cells
from understudy.errors import FileError, join_names, suggest_known_name
from understudy.model.value_kinds import Column, Kind

TIME = "time_s"
"""The column of times in a table that needs no mapping file, and in all tables of messages."""


class RecordedTable(NamedTuple):
    """A recording of another program as a table: a row for each moment, a column for each quantity.

    Parameters
    ----------
    path
        The file.
    header
        Names of the columns, each once.
    lines
        The number in the file of each row, for errors; it rises.
    cells
        The rows, each with a cell for each column: a number, a truth value or a text. None, NaN and empty texts are
        absent.
    omissions
        Sentences about what was left out or guessed, each with its place in the file.
    counted
        What `lines` counts: lines, or messages.
    mapping
        What the columns are, if the reader knows it better than the mapping that it was given, as that of messages,
        whose rows have the readings already; all values are in the units that it names. None: the mapping that was
        given, or names of columns like ours.
    """

    path: Path
    header: tuple[str, ...]
    lines: Sequence[int]
    cells: Sequence[Sequence[Any]]
    omissions: list[str]
    counted: str = "line"
    mapping: RecordingMap | None = None

    def format_place(self, row: int) -> str:
        """Return where a row stands in the file.

        Parameters
        ----------
        row
            Index of the row, from 0.

        Returns
        -------
        str
            A place such as "line 3".
        """
        return f"{self.counted} {self.lines[row]}"

    def refuse(self, place: str, problem: str, remedy: str) -> FileError:
        """Make the error that something at a place of the file cannot be used.

        Parameters
        ----------
        place
            The place, such as "line 3, column 'x'".
        problem
            What is wrong.
        remedy
            What would be right.

        Returns
        -------
        FileError
            The error, to be raised. It says what was left out before, which may be the reason.
        """
        if self.omissions:
            more = f" and {len(self.omissions) - 1} more" if len(self.omissions) > 1 else ""
            problem = f"{problem} (before that: {self.omissions[0]}{more})"
        return FileError(path=self.path, place=place, problem=problem, remedy=remedy)

    def list_cells(self, column: str, *, of: str) -> Sequence[Any] | Column:
        """List the cells of a column.

        Parameters
        ----------
        column
            Name of the column.
        of
            What it has, for the error.

        Returns
        -------
        sequence
            The cells of all rows.

        Raises
        ------
        FileError
            If there is no such column, or several have the name.
        """
        if column not in self.header:
            twins = [each for each in self.header if each.startswith(f"{column} (column ")]
            if twins:
                problem = f"{len(twins)} columns are called {column!r}"
                remedy = f"rename one, or name the one that is meant in a mapping file: {join_names(twins)}"
                raise self.refuse("line 1", problem, remedy)
            meant = suggest_known_name(column, self.header)
            raise self.refuse(
                self.format_place(0) if self.lines else "line 1",
                f"there is no column {column!r} for {of}",
                f"{meant}the columns are {join_names(self.header)}",
            )
        at = self.header.index(column)
        if isinstance(self.cells, np.ndarray):
            cells: Column = self.cells[:, at]
            return cells
        return [row[at] for row in self.cells]

    def read_values(self, column: str, kind: Kind | None = None, *, of: str) -> CellValues:
        """Read a column as numbers, with what cannot be understood noted among the omissions.

        Parameters
        ----------
        column
            Name of the column.
        kind
            The kind that the values have; None: the one that they look like.
        of
            What it has, for the error.

        Returns
        -------
        CellValues
            The values, shape [T] as float64, NaN where absent, and their kind.

        Raises
        ------
        FileError
            If there is no such column, or no cell of it can be understood.
        """
        cells = self.list_cells(column, of=of)
        read = read_cells(cells, kind)
        if read.wrong:
            first = self.format_place(read.wrong[0])
            more = f" and {len(read.wrong) - 1} more" if len(read.wrong) > 1 else ""
            wanted = "no number" if not hasattr(read.kind, "labels") else f"no label of {read.kind}"
            what = f"{str(cells[read.wrong[0]])!r:.40}{more} is {wanted}"
            is_infinite = wanted == "no number" and parse_number(cells[read.wrong[0]]) is not None
            if np.isnan(read.values).all() and not is_infinite:
                remedy = "map another column" if wanted == "no number" else "give the labels as they are"
                raise self.refuse(f"{first}, column {column!r}", what, remedy)
            self.omissions.append(f"{self.path} at {first}, column {column!r}: {what}; taken as absent")
        return read
