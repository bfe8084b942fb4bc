"""The page on checking: its lesson, and what the check prints on it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.docs.pages import ROOT, blocks


def test_the_lesson_of_the_page_is_checked_as_shown(tmp_path: Path) -> None:
    lesson, shown = (
        next(block for block in blocks(ROOT / "docs" / "checking.md") if block.language == language)
        for language in ("csv", "text")
    )
    (tmp_path / "lesson.csv").write_text(lesson.text, encoding="utf-8")
    command = [sys.executable, "-m", "understudy.ui.cli"]
    learn = [*command, "learn", "lesson.csv", "--name", "approach", "--library", "library"]
    subprocess.run(learn, capture_output=True, check=True, cwd=tmp_path)
    check = [*command, "check", "library"]
    done = subprocess.run(check, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.split() == shown.text.split()
