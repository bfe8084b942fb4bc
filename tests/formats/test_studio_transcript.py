"""What pages said to the studio of 0.1 and 0.2, said again, is answered as it was, but for names and wording."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from tests.formats.old_names import rename_exchange, rename_request
from tests.formats.reworded import reword
from tests.make.studios import make_studio
from tests.make.transcripts import FOLDER, record_transcript

pytest.importorskip("sklearn", reason="needs the extra sklearn")


STUDIO_0_2 = FOLDER.parent / "v0_2_0/studio"
"""What the studio of 0.2 was told and said; its libraries are those of 0.1."""
PLACE = ("offers", "storage_note", "closed")
"""What `hello` says of the place in which the studio runs."""
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
    said = [rename_request(as_then(json.loads(line)["say"])) for line in lines[1:]]
    again = record_transcript(make_studio(folder, world=world, seed=3), folder, said).splitlines()
    assert len(again) == len(lines)
    for number, (wrong, right) in MENDED.get(name, {}).items():
        assert wrong in lines[number]
        lines[number] = lines[number].replace(wrong, right)
    shown_now: dict[str, object] = {}
    shown_then: dict[str, object] = {}
    for line, line_then in zip(again, lines, strict=True):
        now, then = json.loads(line), reword(rename_exchange(json.loads(line_then)))
        take_new(now)
        undoable, undoable_then = take_undoable(now, shown_now), take_undoable(then, shown_then)
        assert now == then  # the order of keys means nothing
        if shown_then.get("pending") is None:
            assert undoable == undoable_then


@pytest.mark.parametrize(
    ("name", "world", "library"), [("forage", "forage", "library"), ("squad", "patrol", "squad")]
)
def test_the_messages_of_0_2_are_answered_the_same(
    name: str, world: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("understudy.ui.web.actions.coach.PATIENCE_S", 60.0)  # on a busy machine, too
    folder = tmp_path / name
    shutil.copytree(FOLDER / library, folder)
    lines = (STUDIO_0_2 / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    then = [rename_exchange(json.loads(line)) for line in lines]
    messages = [each["say"] for each in then[1:]]
    again = record_transcript(make_studio(folder, world=world, seed=3), folder, messages).splitlines()
    for now, before in zip(map(json.loads, again), then, strict=True):
        take_unstable(now)
        take_unstable(before)
        assert now == before


def take_unstable(exchange: dict[str, Any]) -> None:
    """Take out of an exchange what comes of runs in the background, and what there was not in 0.2.

    Those are scores and how often advice is about them, how many examples are decided otherwise in a test, which
    targets of exports take single precision, and what the place offers in which the studio runs.
    """
    for answer in exchange["hear"]:
        for key in PLACE:
            answer.pop(key, None)
        if "exports" in answer:
            answer["exports"] = [
                each if isinstance(each, str) else each["name"] for each in answer["exports"]
            ]
        (answer.get("test") or {}).pop("otherwise", None)
        (answer.get("session") or {}).pop("score", None)
        for advice in answer.get("advice") or ():
            advice.pop("evidence", None)


def as_then(said: str) -> str:
    """Return a message of 0.1.0, which knew no live teaching."""
    return said.replace('"do": "new",', '"do": "new", "live": false,')


def take_new(exchange: dict[str, Any]) -> None:
    """Take out of an exchange what there was not in 0.1.0.

    These are: whether a lesson is taught live, worlds and libraries to choose from, targets of exports, whether control
    can be taken, numbers that tell a sentence from the same one said again, how the world is drawn, what a check finds,
    failing worlds, the properties of the library's file, the recordings that examples were made from, what
    changed, the score in new worlds, how often advice is about what went wrong there, how many examples are decided
    otherwise, and what the place offers in which the studio runs.
    """
    if exchange.get("say") is not None:
        exchange["say"] = exchange["say"].replace(' "live": false,', "")
    for answer in exchange["hear"]:
        for key in ("live", "changed", "score"):
            (answer.get("session") or {}).pop(key, None)
        for example in (answer.get("session") or {}).get("examples") or ():
            example.pop("source", None)
        for advice in answer.get("advice") or ():
            advice.pop("evidence", None)
        (answer.get("scene") or {}).pop("drawing", None)
        (answer.get("test") or {}).pop("otherwise", None)
        for key in (
            "places",
            "can_take_control",
            "message_number",
            "exports",
            "findings",
            "failures",
            "properties",
            *PLACE,
        ):
            answer.pop(key, None)


def take_undoable(exchange: dict[str, Any], shown: dict[str, object]) -> object:
    """Take what can be undone out of the answers, and return what the page shows of it after them.

    A press that waits for the next tick can be undone since 0.2.0, so this is said a message earlier than by 0.1.0.
    """
    for answer in exchange["hear"]:
        session = answer.get("session") or {}
        shown.update(session)
        session.pop("undoable", None)
    return shown.get("undoable")
