"""What the cells of a table mean: numbers, truth values, labels, or nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Continuous, Kind

ABSENT = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "nat", "#n/a"})
"""How programs write that a cell has nothing, in lower case."""
TRUTHS: Mapping[str, float] = {"true": 1.0, "false": 0.0, "yes": 1.0, "no": 0.0}
MINUS = "\N{MINUS SIGN}"
"""The sign that some programs write in place of the one on keyboards."""
MOST_LABELS = 20
"""The largest number of different texts in a column that count as labels."""


class CellValues(NamedTuple):
    """A column as numbers, NaN where absent, with its kind and the rows whose cells are neither absent nor of it.

    `kind` is None if the cells are texts of no use. `remark` says why, or what is odd about the labels.
    """

    values: Column
    kind: Kind | None
    wrong: list[int]
    remark: str = ""


def parse_number(cell: Any) -> float | None:
    """Parse a cell: a number, NaN if it has none, or None if it is something else.

    Infinite numbers are absent: no reading and no command is infinite.
    """
    if cell is None:
        return nan
    if isinstance(cell, str):
        text = cell.strip().replace(MINUS, "-")
        if text.lower() in ABSENT:
            return nan
        if "_" in text:  # Python would read 1_000 as a number
            return None
        try:
            value = float(text)
        except ValueError:
            return None
    else:
        try:
            value = float(cell)
        except OverflowError:
            return nan
        except (TypeError, ValueError):
            return None
    return value if isfinite(value) else nan


def is_number(cell: Any) -> bool:
    """Return whether a cell is a number."""
    value = parse_number(cell)
    return value is not None and not isnan(value)


def read_cells(cells: Sequence[Any] | Column, kind: Kind | None = None) -> CellValues:
    """Read a column of cells.

    Parameters
    ----------
    cells
        The cells: numbers, texts, truth values or None.
    kind
        The kind that the values have. None: numbers are continuous, truth values are Boolean, and a few different texts
        are labels, in the order of the alphabet.

    Returns
    -------
    CellValues
        The values and their kind. A label is the index of its text in the kind's labels.
    """
    if isinstance(cells, np.ndarray) and cells.dtype.kind == "f":
        return CellValues(np.where(np.isfinite(cells), cells, nan), kind or Continuous(), [])
    return _read_any(list(cells), kind)


def _read_any(cells: Sequence[Any], kind: Kind | None) -> CellValues:
    """Read a column of cells of any type."""
    if isinstance(kind, Categorical):
        return _read_labels(cells, kind)
    if kind is None and (guessed := _guess_kind(cells)) is not None:
        labels, remark = guessed
        if labels is None:
            return CellValues(np.full(len(cells), nan), None, [], remark)
        return _read_labels(cells, labels)._replace(remark=remark)
    values, wrong = np.empty(len(cells)), []
    for row, cell in enumerate(cells):
        number = parse_number(cell)
        values[row] = nan if number is None else number
        if number is None or (isnan(number) and not _is_absent(cell)):
            wrong.append(row)
    return CellValues(values, kind or Continuous(), wrong)


def _is_absent(cell: Any) -> bool:
    """Return whether a cell has nothing; an infinite number is something that is no number."""
    if cell is None or isinstance(cell, str):
        return cell is None or cell.strip().lower() in ABSENT
    try:
        return isnan(float(cell))
    except OverflowError:
        return False


def _guess_kind(cells: Sequence[Any]) -> tuple[Categorical | None, str] | None:
    """Guess the labels of a column of texts, and what is odd about them; None for a column of numbers."""
    texts, numbers = dict[str, int](), set[str]()
    count = 0
    for cell in cells:
        if isinstance(cell, (bool, np.bool_)):
            text = str(bool(cell)).lower()
        elif isinstance(cell, str) and parse_number(cell) is None:
            text = format_label(cell)
        else:
            if is_number(cell):
                count += 1
                numbers.add(format_label(cell))
            continue
        texts[text] = texts.get(text, 0) + 1
    if texts and all(each.lower() in TRUTHS for each in texts) and numbers <= {"0", "1"}:
        return BOOLEAN, ""
    if not texts or count * 2 > sum(texts.values()):
        return None
    labels = sorted({*texts, *numbers})
    example = repr(max(texts, key=lambda text: texts[text]))[:40]
    if len(labels) > MOST_LABELS:
        return None, f"{len(labels)} different texts, such as {example}"
    if any("|" in each for each in labels):
        return None, f"texts with | in them, such as {example}"
    if len(labels) == 1:
        remark = f"{example} in all rows, which tells nothing"
    elif any(each.lstrip("+-.")[:1].isdigit() for each in labels):
        remark = f"texts, such as {example}, are taken as labels and not as numbers"
    else:
        remark = ""
    return Categorical(tuple(labels)), remark


def format_label(cell: Any) -> str:
    """Format a cell as the text of a label: 2 for 2.0, and in one line."""
    if isinstance(cell, (float, np.floating)) and cell == int(cell):
        return str(int(cell))
    return " ".join(str(cell).split())


def _read_labels(cells: Sequence[Any], kind: Categorical) -> CellValues:
    """Read labels by their texts; where no cell is one of them, by their numbers from 0."""
    index = {label: float(number) for number, label in enumerate(kind.labels)}
    if kind == BOOLEAN:
        index |= {**TRUTHS, "True": 1.0, "False": 0.0, "1": 1.0, "0": 0.0}
    texts = [None if cell is None or _is_nan(cell) else format_label(cell) for cell in cells]
    named = any(text in index for text in texts)
    values, wrong = np.full(len(texts), nan), []
    for row, text in enumerate(texts):
        if text is None or (text not in index and text.lower() in ABSENT):
            continue
        if named or kind == BOOLEAN:
            value = index.get(text, index.get(text.lower(), nan) if kind == BOOLEAN else nan)
        else:
            number = parse_number(text)
            valid = number is not None and number in range(len(kind.labels))
            value = float(number) if valid and number is not None else nan
        values[row] = value
        if isnan(value):
            wrong.append(row)
    return CellValues(values, kind, wrong)


def _is_nan(cell: Any) -> bool:
    return isinstance(cell, (float, np.floating)) and isnan(cell)
