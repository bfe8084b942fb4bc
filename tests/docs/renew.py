"""What the documents show of results: the tables of docs/foraging.md, the demo's excerpt and pictures of the README.

After the teacher or the published results changed, bring all of it up to date with: python -m tests.docs.renew
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).parents[2]
README, FORAGING, PICTURES = ROOT / "README.md", ROOT / "docs" / "foraging.md", ROOT / "docs" / "pictures"
PUBLISHED = ROOT / "src" / "understudy" / "experiments" / "forage" / "expected.json"
DEMO = "<!-- demo: python -m tests.docs.renew puts here what it prints -->\n", "<!-- end of demo -->"
RESULTS = (
    "<!-- results: python -m tests.docs.renew puts here what expected.json says -->\n",
    "<!-- end of results -->",
)
METHODS = ("watched", "plain")
PATH_SEED = 8
"""The teaching whose path is the README's picture: one that shows much of the arena."""


def between(page: Path, marks: tuple[str, str]) -> str:
    """What a page has between two marks."""
    _, begin, rest = page.read_text(encoding="utf-8").partition(marks[0])
    inside, end, _ = rest.partition(marks[1])
    assert begin, f"{page.name} has lost its marks"
    assert end, f"{page.name} has lost its marks"
    return inside


def put_between(page: Path, marks: tuple[str, str], inside: str) -> None:
    """Replace what a page has between two marks."""
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace(marks[0] + between(page, marks), marks[0] + inside), encoding="utf-8")


def demo(out: Path, *, seed: int = 0) -> str:
    """What the demo prints."""
    command = [sys.executable, "-m", "understudy.cli", "demo", "--seed", str(seed), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout


def excerpt(printed: str) -> str:
    """The README's excerpt of what the demo prints: without Harvest and GoTo, the files and the advice."""
    lines = [line.rstrip() for line in printed.splitlines()]
    heading = next(index for index, line in enumerate(lines) if line.startswith(" lesson"))
    learned = next(index for index, line in enumerate(lines) if line.startswith("What it learned"))
    deposit = lines.index("  deposit")
    judged = lines.index("How well it forages")
    taught = [line for line in lines[heading:learned] if line and "─" not in line]
    shown = ["```text", *taught, "", lines[learned], *lines[deposit : judged + 5], "```"]
    return "\n" + "\n".join(shown) + "\n\n"


def tables(published: Mapping[str, Any]) -> str:
    """The tables of results."""
    found = [published["methods"][method] for method in METHODS]
    rows = [
        ("teachings that reach 95 % success", [f"{f['teachings_reaching_95']} of {f['of']}" for f in found]),
        ("success of the worst teaching", [f"{f['success']['min']:.0%}" for f in found]),
        (
            "food per second, of the hand-coded forager's",
            [_spread(f["relative_to_expert"], 2) for f in found],
        ),
        ("press-made examples, all four lessons", [_spread(f["examples"], 0) for f in found]),
        ("presses", [_spread(f["presses"], 0) for f in found]),
        ("teaching, simulated seconds", [_spread(f["teaching_seconds"], 0) for f in found]),
    ]
    names = found[0]["corner_cases"]
    corners = [(name, [f"{f['corner_cases'][name]['min']:.0%}" for f in found]) for name in names]
    first, stop = published["seeds"]
    return (
        f"\nTeaching seeds {first} to {stop - 1}:\n\n{_table('', rows)}\n"
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
    """Bring the documents up to date."""
    from PIL import Image

    put_between(FORAGING, RESULTS, tables(published()))
    with TemporaryDirectory() as folder:
        put_between(README, DEMO, excerpt(demo(Path(folder))))
        graph = Path(folder, "pictures", "goto.svg")
        (PICTURES / "goto.svg").write_text(graph.read_text(encoding="utf-8"), encoding="utf-8")
        demo(Path(folder), seed=PATH_SEED)
        path = Image.open(Path(folder, "pictures", "path.png")).convert("RGB").quantize(64)
        path.save(PICTURES / "foraging.png", optimize=True)


if __name__ == "__main__":
    main()
