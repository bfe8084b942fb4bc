"""Tables of results for papers and spreadsheets: Markdown, LaTeX and CSV."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from math import isfinite, isnan
from textwrap import fill, wrap
from typing import TypeAlias

from understudy.errors import SettingError

MARKDOWN, LATEX, CSV = "markdown", "latex", "csv"
LAYOUTS = (MARKDOWN, LATEX, CSV)
WIDTH = 110
"""The number of letters in a line of a caption."""

Value: TypeAlias = str | int | float


@dataclass(frozen=True, slots=True)
class Share:
    """A share or a difference of shares, as a number from -1 to 1, to be shown in percent."""

    value: float


@dataclass(frozen=True, slots=True)
class Probability:
    """A p-value."""

    value: float


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of an interval; infinite where there is no limit."""

    low: float
    high: float
    percent: bool = False


Cell: TypeAlias = Value | Share | Probability | Limits


def format_table(
    titles: Sequence[str], rows: Sequence[Sequence[Cell]], layout: str, *, caption: str = ""
) -> str:
    """Format a table, one row after the other.

    Parameters
    ----------
    titles
        The title of each column. The first column is text, the others are numbers.
    rows
        The cells of each row. In CSV, numbers have all their digits, shares are from 0 to 1, an absent value is empty,
        and limits take two columns.
    layout
        "markdown", "latex" (a tabular that needs no package) or "csv".
    caption
        A sentence about the table: below it in Markdown, a comment in LaTeX, nowhere in CSV.

    Returns
    -------
    str
        The lines of the table, each with its end.

    Raises
    ------
    SettingError
        If there is no such layout.
    """
    if layout == CSV:
        return _format_csv(titles, rows)
    if layout == MARKDOWN:
        return _format_markdown(titles, rows, caption)
    if layout == LATEX:
        return _format_latex(titles, rows, caption)
    raise SettingError(
        where="table",
        setting=f"layout {layout!r}",
        problem="is unknown",
        remedy="give markdown, latex or csv",
    )


def _format_csv(titles: Sequence[str], rows: Sequence[Sequence[Cell]]) -> str:
    out = StringIO()
    table = csv.writer(out, lineterminator="\n")
    wide = [column for column in range(len(titles)) if any(isinstance(row[column], Limits) for row in rows)]
    table.writerow(
        name
        for column, title in enumerate(titles)
        for name in (["low", "high"] if column in wide else [title])
    )
    for row in rows:
        table.writerow(value for cell in row for value in _list_values(cell))
    return out.getvalue()


def _list_values(cell: Cell) -> list[Value]:
    if isinstance(cell, Limits):
        return [_list_values(limit)[0] for limit in (cell.low, cell.high)]
    value = cell.value if isinstance(cell, Share | Probability) else cell
    return ["" if isinstance(value, float) and not isfinite(value) else value]


def _format_markdown(titles: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str) -> str:
    lines = [[str(title) for title in titles], ["---", *["---:"] * (len(titles) - 1)]]
    lines += [[format_cell(cell).replace("|", "\\|") for cell in row] for row in rows]
    text = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    return f"{text}\n{fill(caption, WIDTH)}\n" if caption else text


LATEX_LETTERS: Mapping[str, str] = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$", "|": "$|$", "−": "$-$", "–": "--",
    "∞": r"$\infty$", "\n": " ",
}  # fmt: skip
"""Letters that LaTeX would take for a command, or does not have in every font."""


def escape_latex(text: str) -> str:
    """Return a text as LaTeX prints it."""
    return "".join(LATEX_LETTERS.get(letter, letter) for letter in text)


def _format_latex(titles: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str) -> str:
    def join(cells: Sequence[str]) -> str:
        texts = [escape_latex(cell) for cell in cells]
        if texts[0].startswith(("[", "*")):  # the end of the row before would take it for its own
            texts[0] = f"{{}}{texts[0]}"
        return f"  {' & '.join(texts)} \\\\"

    lines = [f"% {line}" for line in wrap(caption, WIDTH)]
    lines += [f"\\begin{{tabular}}{{l{'r' * (len(titles) - 1)}}}", r"  \hline", join(titles), r"  \hline"]
    lines += [join([format_cell(cell) for cell in row]) for row in rows]
    return "".join(f"{line}\n" for line in [*lines, r"  \hline", r"\end{tabular}"])


def format_cell(cell: Cell) -> str:
    """Format a cell with as many digits as people read; "–" for an absent value."""
    if isinstance(cell, str):
        return cell
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, int):
        return _sign(str(cell))
    if isinstance(cell, Probability):
        return "–" if isnan(cell.value) else "< 0.001" if cell.value < 0.001 else f"{cell.value:.3f}"
    if isinstance(cell, Share):
        return format_percent(cell.value)
    if isinstance(cell, Limits):
        if not (isfinite(cell.low) or isfinite(cell.high)):
            return "–"
        show = format_percent if cell.percent else format_number
        return f"[{show(cell.low)}, {show(cell.high)}]"
    return format_number(cell)


def format_percent(share: float) -> str:
    """Format a share in percent, with one decimal unless it is whole."""
    if not isfinite(share):
        return format_number(share)
    text = f"{100 * share:.1f}".removesuffix(".0")
    return _sign(f"{text} %")


def format_number(value: float) -> str:
    """Format a number with three digits or so: "123", "12.3", "1.23", "0.012"; "–" for NaN."""
    if isnan(value):
        return "–"
    if not isfinite(value):
        return _sign("∞" if value > 0 else "-∞")
    value = float(f"{value:.9g}")  # 0.1 + 0.2 is 0.3
    size = abs(value)
    digits = 0 if size >= 100 or value == int(value) else 1 if size >= 10 else 2 if size >= 1 else 3
    text = f"{value:.{digits}f}"
    return f"{value:.2e}" if float(text) == 0 and value != 0 else _sign(text)


def _sign(text: str) -> str:
    """Replace a hyphen before a number by a minus sign."""
    return text.replace("-", "−", 1) if text.startswith("-") else text
