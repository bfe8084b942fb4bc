"""What pages said to the studio of 0.1.0, said again, is answered as it was."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from tests.formats.made import FOLDER, transcript
from tests.ui.web.pages import studio

pytest.importorskip("sklearn", reason="needs the extra sklearn")


MENDED = {"forage": {66: ('"happened": "edited"', '"happened": "shown anew"')}}
"""Answers of 0.1.0 that were wrong, by line: examples of a lesson begun anew were called edited."""


@pytest.mark.parametrize(
    ("name", "world", "library"), [("forage", "forage", "library"), ("squad", "patrol", "squad")]
)
def test_the_same_messages_are_answered_the_same(name: str, world: str, library: str, tmp_path: Path) -> None:
    folder = tmp_path / name
    shutil.copytree(FOLDER / library, folder)
    lines = (FOLDER / f"studio/{name}.jsonl").read_text(encoding="utf-8").splitlines()
    said = [json.loads(line)["say"] for line in lines[1:]]
    again = transcript(studio(folder, world=world, seed=3), folder, said).splitlines()
    assert len(again) == len(lines)
    for number, (wrong, right) in MENDED.get(name, {}).items():
        assert wrong in lines[number]
        lines[number] = lines[number].replace(wrong, right)
    for now, then in zip(again, lines, strict=True):
        assert json.loads(now) == json.loads(then)  # the order of keys means nothing
