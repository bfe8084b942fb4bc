"""Moments at which examples were shown: in the present run from the reel, before that from the journal's snapshots."""

from __future__ import annotations

import zlib
from pathlib import Path

from understudy.errors import SessionError
from understudy.training.journal import Pressed, Snapshot, Stepped, read_journal
from understudy.training.other_agents import Instant
from understudy.ui.web.session_host import Stage


def go_to_example(stage: Stage, number: int) -> None:
    """Go back to just before an example was shown; SessionError where that moment is not kept."""
    desk = stage.trained
    if all(example.number != number for example in desk.session.examples):
        raise SessionError(f"{desk.name} has no example {number}")
    frame = stage.reel.of(number)
    if frame is not None:
        stage.rewind(frame)
        return
    journal = stage.opened.journal if stage.opened else Path()
    snapshot = _before(journal, number)
    if snapshot is None:
        raise SessionError(f"example {number} was not shown in this session: its moment is not kept")
    others = desk.session.company.snapshot()  # what they did then is not kept: they go on
    stage.go_back(Instant(zlib.decompress(snapshot.body), tuple(snapshot.run), snapshot.mode, others))


def _before(journal: Path, number: int) -> Snapshot | None:
    """The snapshot before the press that showed an example; the last such, as undo lets numbers go."""
    snapshot = found = None
    before: dict[int, Snapshot | None] = {}
    for entry in read_journal(journal):
        match entry:
            case Snapshot():
                snapshot = entry
            case Pressed():
                before[entry.press.number] = snapshot
            case Stepped() if entry.press is not None and any(
                each.number == number for each in entry.changed
            ):
                found = before.get(entry.press)
    return found
