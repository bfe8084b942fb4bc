"""Journals of 0.1.0 are resumed with the lesson they had, and the same session writes the same journal."""

from __future__ import annotations

import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import pytest
from tests.make.transcripts import FOLDER, TAUGHT, play, resume_copy

from understudy.storage.append_log import read_log
from understudy.storage.document import encode_document
from understudy.training.journal import MAGIC, read_journal

JOURNALS = FOLDER / "journals"
TAGS = [
    "Accepted", "Acted", "Attended", "Began", "Occupied", "Placed", "Pressed", "Raised", "Snapshot", "Stepped",
    "Ticks", "Turned", "Went",
]  # fmt: skip
"""Sorts of entries: part of the format, whatever their classes are called."""
LATER = ("reaction_s", "source")
"""Keys of examples that 0.1.0 did not write; they are null unless an example was made from a recording."""


def plain(path: Path) -> list[Any]:
    """The entries of a journal as plain data, unpacked, so that another zlib may have packed them."""
    return [unpack(msgspec.msgpack.decode(payload)) for payload in read_log(path, MAGIC)]


def unpack(value: Any) -> Any:
    if isinstance(value, bytes):
        with suppress(zlib.error):
            return zlib.decompress(value)
    if isinstance(value, dict):
        kept = {key: each for key, each in value.items() if key not in LATER or each is not None}
        return {key: unpack(each) for key, each in kept.items()}
    return [unpack(each) for each in value] if isinstance(value, list) else value


@pytest.mark.parametrize("name", TAUGHT)
def test_a_journal_is_resumed_with_its_lesson(name: str, tmp_path: Path) -> None:
    if name == "fetch":
        pytest.importorskip("sklearn", reason="needs the extra sklearn")
    again = resume_copy(JOURNALS / f"{name}.journal", tmp_path, library=FOLDER / "library")
    assert encode_document(again.make_trained_automaton()) == (JOURNALS / f"{name}.json").read_bytes()
    again.tick()
    again.close()
    copied = tmp_path / f"{name}.journal"
    assert len(list(read_journal(copied))) > len(list(read_journal(JOURNALS / f"{name}.journal")))


def test_a_killed_session_goes_on_where_it_was(tmp_path: Path) -> None:
    """Its last press waits, unless that was cut off."""
    for name, waiting in (("steps", "right"), ("killed", None)):
        again = resume_copy(JOURNALS / f"{name}.journal", tmp_path, library=FOLDER / "library")
        view = again.view()
        assert (view.waiting, view.state, str(view.mode)) == (waiting, "left", "training")
        assert (round(view.time_s, 6), dict(view.targets)) == (1.7, {"A": "goal"})
        again.close()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_same_session_writes_the_same_journal(seed: int, tmp_path: Path) -> None:
    play(tmp_path / "again.journal", seed)
    pairs = zip(plain(tmp_path / "again.journal"), plain(JOURNALS / f"random-{seed}.journal"), strict=True)
    for now, then in pairs:
        now.pop("kinds", None)  # which 0.1.0 did not write
        assert repr(now) == repr(then)  # absent is NaN, which equals nothing


def test_all_sorts_of_entries_are_in_them() -> None:
    found = {entry["type"] for name in TAUGHT for entry in plain(JOURNALS / f"{name}.journal")}
    assert sorted(found) == TAGS
