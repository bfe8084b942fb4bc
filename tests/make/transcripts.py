"""What the tests of files written by 0.1.0 share: where they are, and how sessions and transcripts are made again."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from random import Random
from typing import Any

from tests.bodies import Scripted
from tests.make.sessions import WITH_GO, make_session
from tests.make.studios import Frame
from tests.training.steps import AS_IN_0_1, do, draw_step
from tests.training.test_squad_session import SQUAD, coordinator_body

from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import open_library
from understudy.training.session import Session
from understudy.ui.web.server import StudioServer

FOLDER = Path(__file__).parents[1] / "fixtures/v0_1_0"

TAUGHT: Mapping[str, Callable[[], Body]] = {
    "fetch": lambda: Forage([9]),
    "killed": lambda: Scripted(3),
    "random-1": lambda: Scripted(2),
    "random-2": lambda: Scripted(2),
    "random-3": lambda: Scripted(2),
    "squad": coordinator_body,
    "steps": lambda: Scripted(3),
}
"""The body of each journal's session."""


def resume_copy(journal: Path, scratch: Path, *, library: Path) -> Session:
    """The session of a copy of a journal, which goes on; `library` is where its robots forage from."""
    known = {"fetch": lambda: open_library(library, FORAGE_KIT, learn).library, "squad": lambda: SQUAD}
    shutil.copy(journal, scratch / journal.name)
    with_library: Library = known.get(journal.stem, lambda: WITH_GO)()
    return Session.resume(scratch / journal.name, TAUGHT[journal.stem](), with_library)


def play(path: Path, seed: int) -> None:
    """Hold a random session and keep its journal."""
    random = Random(seed)
    made = make_session(
        features=["range_of(ball)", "seen"],
        flags=["done"],
        library=WITH_GO,
        options=LearnerOptions(watched=True, reaction_s=0.2, learner=AS_IN_0_1),
        body=Scripted(2),
        journal=path,
    )
    for _ in range(90):
        step = draw_step(random)
        if step != ("undo",) or made.trainee.press is None:
            do(made, step)
        elif (
            made._log.undoable
        ):  # 0.1.0 took back the last step with a press that waited, now only the press is
            made.trainee.press = None
            made.undo()
    made.close()


def record_transcript(made: StudioServer, folder: Path, messages: Sequence[str]) -> str:
    """What a page said to a studio of this folder and what it then was sent, a line a message.

    Frames are plain values, so that their layout may change; of a session there is what differs from the last one.
    """
    place = str(folder).encode()
    viewer, steps, former = made.connect(None), list[dict[str, Any]](), dict[str, Any]()

    def heard() -> list[dict[str, Any]]:
        found = []
        while (waiting := viewer.next()) is not None:
            sent, binary = waiting
            told = (
                {"is": "frame", **asdict(Frame.read(sent))}
                if binary
                else json.loads(sent.replace(place, b"library"))
            )
            found.append(keep_changes(drop_times(told), former))
        return found

    steps.append({"say": None, "hear": heard()})
    for text in messages:
        made.handle_text(viewer, text)
        steps.append({"say": text, "hear": heard()})
    made.disconnect(viewer)
    made.host.close()
    return "".join(json.dumps(step, ensure_ascii=False) + "\n" for step in steps)


def drop_times(told: dict[str, Any]) -> dict[str, Any]:
    """Without what is another each time."""
    return {key: value for key, value in told.items() if key not in ("key", "version", "ms")}


def keep_changes(told: dict[str, Any], former: dict[str, Any]) -> dict[str, Any]:
    """Of a session, what is another than in the last, two levels deep."""
    if told.get("is") != "session":
        return told
    last = former.copy()
    former.clear()
    former.update(told)
    found = {
        key: value for key, value in told.items() if key == "is" or key not in last or last[key] != value
    }
    inner, before = found.get("session"), last.get("session")
    if isinstance(inner, dict) and isinstance(before, dict):
        found["session"] = {key: value for key, value in inner.items() if before.get(key) != value}
    return found
