"""Tables for papers: what is in a cell, and that LaTeX gets no letter that it takes for a command."""

from __future__ import annotations

import csv
import re
from io import StringIO
from math import inf, nan

import pytest
from tests.analysis.test_comparison import FIRST, SECOND

from understudy.errors import SettingError
from understudy.judging.comparison import compare
from understudy.judging.result_table import (
    Cell,
    Limits,
    Probability,
    Share,
    escape_latex,
    format_cell,
    format_table,
)

CELLS: list[tuple[Cell, str]] = [
    (12345.6, "12346"),
    (41.26, "41.3"),
    (4.0, "4"),
    (0.1 + 0.2 - 1.3, "−1"),
    (-2.345, "−2.35"),
    (0.01234, "0.012"),
    (0.0001234, "1.23e-04"),
    (nan, "–"),
    (7, "7"),
    (Share(0.985), "98.5 %"),
    (Share(-0.5), "−50 %"),
    (Share(1.0), "100 %"),
    (Probability(0.0312), "0.031"),
    (Probability(0.0004), "< 0.001"),
    (Limits(-0.25, 0.5, percent=True), "[−25 %, 50 %]"),
    (Limits(-inf, inf), "–"),
    (True, "yes"),
]


@pytest.mark.parametrize(("cell", "text"), CELLS)
def test_cells_have_as_many_digits_as_people_read(cell: Cell, text: str) -> None:
    assert format_cell(cell) == text


ROWS: list[list[Cell]] = [["a|b_1", 1.5, Limits(-1.0, inf)], ["[c]", nan, Limits(2.0, 3.0)]]
TITLES = ["name", "value", "95 % interval"]


def test_markdown() -> None:
    assert format_table(TITLES, ROWS, "markdown", caption="Two rows.") == (
        "| name | value | 95 % interval |\n| --- | ---: | ---: |\n"
        "| a\\|b_1 | 1.50 | [−1, ∞] |\n| [c] | – | [2, 3] |\n\nTwo rows.\n"
    )


def test_latex() -> None:
    assert format_table(TITLES, ROWS, "latex", caption="Two\nrows.").splitlines() == [
        "% Two rows.",
        r"\begin{tabular}{lrr}",
        r"  \hline",
        r"  name & value & 95 \% interval \\",
        r"  \hline",
        r"  a$|$b\_1 & 1.50 & [$-$1, $\infty$] \\",
        r"  {}[c] & -- & [2, 3] \\",
        r"  \hline",
        r"\end{tabular}",
    ]


def test_csv_has_numbers_with_all_their_digits() -> None:
    text = format_table(TITLES, [*ROWS, ["d", Share(1 / 3), Limits(0.1, 0.2)]], "csv")
    assert list(csv.reader(StringIO(text))) == [
        ["name", "value", "low", "high"],
        ["a|b_1", "1.5", "-1.0", ""],
        ["[c]", "", "2.0", "3.0"],
        ["d", "0.3333333333333333", "0.1", "0.2"],
    ]


def test_letters_of_latex_are_escaped() -> None:
    assert escape_latex("50 % of a_b & {c} \\d #1 $2 ~x^y <z>") == (
        r"50 \% of a\_b \& \{c\} \textbackslash{}d \#1 \$2 \textasciitilde{}x\textasciicircum{}y $<$z$>$"
    )


def test_the_tables_of_results_are_plain_in_latex() -> None:
    """No letter beyond ASCII, as many cells in every row as columns, and all braces and dollars in pairs."""
    for text in (FIRST.to_table("latex"), compare(FIRST, SECOND).to_table("latex", names=("a_1", "b&c"))):
        begin, *lines = (line for line in text.splitlines() if not line.startswith("% "))
        assert text.isascii()
        columns = len(re.fullmatch(r"\\begin\{tabular\}\{(l(r*))\}", begin)[1])  # type: ignore[index]
        rows = [line for line in lines if line.endswith(r"\\")]
        assert {len(re.findall(r"(?<!\\)&", row)) for row in rows} == {columns - 1}
        for row in rows:
            assert len(re.findall(r"(?<!\\)\$", row)) % 2 == 0


def test_results_in_csv_can_be_computed_with() -> None:
    success, seconds, food = csv.DictReader(StringIO(FIRST.to_table("csv")))
    assert float(success["value"]) == FIRST.success
    assert (seconds["measure"], seconds["worlds"], seconds["low"]) == ("seconds", "4", "")
    assert (food["measure"], food["value"]) == ("food", "3.0")
    compared = list(csv.DictReader(StringIO(compare(FIRST, SECOND).to_table("csv"))))
    assert [row["measure"] for row in compared] == ["success", "seconds", "food"]
    assert float(compared[2]["p"]) == 0.125


def test_an_unknown_layout() -> None:
    with pytest.raises(SettingError, match="layout 'html' is unknown; give markdown, latex or csv"):
        FIRST.to_table("html")
