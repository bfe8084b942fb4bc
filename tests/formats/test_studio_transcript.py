"""What pages said to the studio of 0.1.0, said again, is answered as it was, but for the wording."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from tests.formats.made import FOLDER, transcript
from tests.formats.reworded import reword
from tests.ui.web.pages import studio

pytest.importorskip("sklearn", reason="needs the extra sklearn")


MENDED = {"forage": {66: ('"happened": "edited"', '"happened": "shown anew"')}}
"""Answers of 0.1.0 that were wrong, by line: examples of a lesson begun anew were called edited."""


@pytest.mark.parametrize(
    ("name", "world", "library"), [("forage", "forage", "library"), ("squad", "patrol", "squad")]
)
def test_the_same_messages_are_answered_the_same(
    name: str, world: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("understudy.ui.web.actions.coach.PATIENCE_S", 60.0)  # on a busy machine, too
    folder = tmp_path / name
    shutil.copytree(FOLDER / library, folder)
    lines = (FOLDER / f"studio/{name}.jsonl").read_text(encoding="utf-8").splitlines()
    said = [as_then(json.loads(line)["say"]) for line in lines[1:]]
    again = transcript(studio(folder, world=world, seed=3), folder, said).splitlines()
    assert len(again) == len(lines)
    for number, (wrong, right) in MENDED.get(name, {}).items():
        assert wrong in lines[number]
        lines[number] = lines[number].replace(wrong, right)
    shown_now: dict[str, object] = {}
    shown_then: dict[str, object] = {}
    for line, line_then in zip(again, lines, strict=True):
        now, then = json.loads(line), reword(json.loads(line_then))
        take_new(now)
        undoable, undoable_then = take_undoable(now, shown_now), take_undoable(then, shown_then)
        assert now == then  # the order of keys means nothing
        if shown_then.get("waiting") is None:
            assert undoable == undoable_then


def as_then(said: str) -> str:
    """Return a message of 0.1.0, which knew no live teaching."""
    return said.replace('"do": "new",', '"do": "new", "live": false,')


def take_new(exchange: dict[str, Any]) -> None:
    """Take out of an exchange what there was not in 0.1.0.

    These are: whether a lesson is taught live, worlds and libraries to choose from, targets of exports, whether control
    can be taken, numbers that tell a sentence from the same one said again, how the world is drawn, what a check finds,
    failing worlds, the properties of the library's file, the recordings that examples were made from, what
    changed, the score in new worlds, how often advice is about what went wrong there, and how many examples are decided
    otherwise.
    """
    if exchange.get("say") is not None:
        exchange["say"] = exchange["say"].replace(' "live": false,', "")
    for answer in exchange["hear"]:
        for key in ("live", "changed", "score"):
            (answer.get("desk") or {}).pop(key, None)
        for example in (answer.get("desk") or {}).get("examples") or ():
            example.pop("source", None)
        for advice in answer.get("advice") or ():
            advice.pop("evidence", None)
        (answer.get("scene") or {}).pop("drawing", None)
        (answer.get("tested") or {}).pop("otherwise", None)
        for key in ("places", "can_take", "said_number", "exports", "findings", "failures", "properties"):
            answer.pop(key, None)


def take_undoable(exchange: dict[str, Any], shown: dict[str, object]) -> object:
    """Take what can be undone out of the answers, and return what the page shows of it after them.

    A press that waits for the next tick can be undone since 0.2.0, so this is said a message earlier than by 0.1.0.
    """
    for answer in exchange["hear"]:
        desk = answer.get("desk") or {}
        shown.update(desk)
        desk.pop("undoable", None)
    return shown.get("undoable")
