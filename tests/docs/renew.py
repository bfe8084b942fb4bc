"""What the documents show of results: the tables of docs/foraging.md, the demo's excerpt and pictures of the README.

After the teacher or the published results changed, bring all of it up to date with: python -m tests.docs.renew
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.docs.experiments import as_markdown, wrap
from tests.docs.pages import ROOT

from understudy_lab.results import load_published

README, FORAGING, PICTURES = ROOT / "README.md", ROOT / "docs" / "foraging.md", ROOT / "docs" / "pictures"
DEMO = "<!-- demo: python -m tests.docs.renew puts here what it prints -->\n", "<!-- end of demo -->"
RESULTS = (
    "<!-- results: python -m tests.docs.renew puts here what expected.json says -->\n",
    "<!-- end of results -->",
)
PATH_SEED = 8
"""The teaching whose path is the README's picture: one that shows much of the arena."""


def between(page: Path, marks: tuple[str, str]) -> str:
    """What a page has between two marks."""
    _, begin, rest = page.read_text(encoding="utf-8").partition(marks[0])
    inside, end, _ = rest.partition(marks[1])
    assert begin, f"{page.name} has lost its marks"
    assert end, f"{page.name} has lost its marks"
    return inside


def replace_between(page: Path, marks: tuple[str, str], inside: str) -> None:
    """Replace what a page has between two marks."""
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace(marks[0] + between(page, marks), marks[0] + inside), encoding="utf-8")


def demo(out: Path, *, seed: int = 0) -> str:
    """What the demo prints."""
    command = [sys.executable, "-m", "understudy.ui.cli", "demo", "--seed", str(seed), "--out", str(out)]
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


def tables() -> str:
    """The tables of what was published."""
    known = load_published("forage")
    assert known is not None
    findings = known.findings
    lines = [line for table in findings.tables for line in as_markdown(table)]
    notes = [line for note in findings.notes for line in wrap(note)]
    return "\n" + "\n".join([*lines, *notes, ""])


def main() -> None:
    """Bring the documents up to date."""
    from PIL import Image

    replace_between(FORAGING, RESULTS, tables())
    with TemporaryDirectory() as folder:
        replace_between(README, DEMO, excerpt(demo(Path(folder))))
        graph = Path(folder, "pictures", "goto.svg")
        (PICTURES / "goto.svg").write_text(graph.read_text(encoding="utf-8"), encoding="utf-8")
        demo(Path(folder), seed=PATH_SEED)
        path = Image.open(Path(folder, "pictures", "path.png")).convert("RGB").quantize(64)
        path.save(PICTURES / "foraging.png", optimize=True)


if __name__ == "__main__":
    main()
