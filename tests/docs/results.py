"""The results tables of docs/foraging.md, made from what was published.

After a new `understudy experiment forage --out src/understudy/experiments/forage/expected.json`, bring the page up
to date with: python -m tests.docs.results
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "foraging.md"
PUBLISHED = ROOT / "src" / "understudy" / "experiments" / "forage" / "expected.json"
BEGIN, END = "by tests/docs -->\n", "<!-- end of results -->"
METHODS = ("watched", "plain")


def tables(published: Mapping[str, Any]) -> str:
    """What belongs between the two marks."""
    found = [published["methods"][method] for method in METHODS]
    rows = [
        ("teachings that reach 95 % success", [f"{f['teachings_reaching_95']} of {f['of']}" for f in found]),
        ("success of the worst teaching", [f"{f['success']['min']:.0%}" for f in found]),
        ("food per second, of the hand-coded forager's", [_spread(f["relative_to_expert"], 2) for f in found]),
        ("press-made examples, all four lessons", [_spread(f["examples"], 0) for f in found]),
        ("presses", [_spread(f["presses"], 0) for f in found]),
        ("teaching, simulated seconds", [_spread(f["teaching_seconds"], 0) for f in found]),
    ]
    corners = [
        (name, [f"{f['corner_cases'][name]['min']:.0%}" for f in found]) for name in found[0]["corner_cases"]
    ]
    first, stop = published["seeds"]
    return (
        f"\nTeaching seeds {first} to {stop - 1}:\n\n"
        f"{_table('', rows)}\n"
        f"The paper's corner cases, success of the worst teaching:\n\n{_table('corner case', corners)}\n"
        f"The hand-coded forager takes {_spread(published['yardstick'], 2)} times its lower bound.\n\n"
    )


def _table(title: str, rows: list[tuple[str, list[str]]]) -> str:
    lines = [f"| {title} | {' | '.join(METHODS)} |", f"|---|{'---|' * len(METHODS)}"]
    return "\n".join(lines + [f"| {name} | {' | '.join(cells)} |" for name, cells in rows]) + "\n"


def _spread(values: Mapping[str, float], digits: int) -> str:
    return f"{values['median']:.{digits}f} ({values['min']:.{digits}f} to {values['max']:.{digits}f})"


def published() -> Any:
    """The published results."""
    return json.loads(PUBLISHED.read_text(encoding="utf-8"))


def main() -> None:
    """Write the tables into the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, mark, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    PAGE.write_text(before + mark + tables(published()) + end + after, encoding="utf-8")


if __name__ == "__main__":
    main()
