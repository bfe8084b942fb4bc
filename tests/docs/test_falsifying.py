"""The page on falsifying: a lesson is corrected in five lines, with the results that are shown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.docs.pages import ROOT, blocks
from tests.falsification.idle_lesson import make_idle_library
from tests.falsification.kept import keep
from tests.falsification.planted import FORAGE

from understudy.addons.checks.falsification.joint_worlds import Trial

SEEDS = (2, 4, 26)


def test_a_lesson_is_corrected_as_shown(tmp_path: Path) -> None:
    found = blocks(ROOT / "docs" / "falsifying.md")
    index = next(row for row, block in enumerate(found) if block.language == "python")
    example, shown = found[index], found[index + 1]
    lines = [line for line in example.text.split("def correct")[1].splitlines()[1:] if line.strip()]
    assert len(lines) == 5
    names: dict[str, Any] = {}
    exec(compile(example.text, "falsifying.md", "exec"), names)
    for number, seed in enumerate(SEEDS, 1):
        keep(Trial(FORAGE, seed), tmp_path / f"forage-{number}", library=make_idle_library())
    results = names["correct"](tmp_path, make_idle_library(), "left")
    assert sorted(map(str, results)) == shown.text.splitlines()
