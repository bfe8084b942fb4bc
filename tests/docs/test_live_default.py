"""The figures by which live teaching is the default are those of the experiments."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
REASONS = (DOCS / "semantics.md").read_text().split("**Why it is the default.**")[1].split("\n## ")[0]


def find_section(name: str) -> str:
    """Return the text of an experiment."""
    found: str = (
        (DOCS / "experiments.md").read_text().split(f"\n## {name.capitalize()}\n")[1].split("\n## ")[0]
    )
    return found


def test_each_figure_stands_in_its_experiment() -> None:
    rows = [line for line in REASONS.splitlines() if "experiments.md#" in line]
    assert len(rows) == 5
    for row in rows:
        name = re.search(r"experiments\.md#(\w+)", row)
        assert name is not None
        section = find_section(name[1])
        for cell in row.strip("| ").split(" | ")[1:]:
            wanted = cell.strip(" |")
            assert re.search(rf"(?<![\d.]){re.escape(wanted)}(?![\d])", section), (row, wanted)


def test_the_shares_in_its_text() -> None:
    for share, name, goal in [
        ("0.57", "repertoire", "presses as a share of those above, median behavior"),
        ("0.60", "patrol", "examples, relative to the paper's training"),
        ("0.60", "swarm", "examples, relative to the paper's training"),
    ]:
        assert share in REASONS
        assert re.search(rf"{re.escape(goal)} \|[^|]*\| {re.escape(share)}", find_section(name)), name
