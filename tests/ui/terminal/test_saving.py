"""Saving: what worked and no longer does is said, and a promise is kept with the lesson."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.ui.terminal.desks import GOTO, Wall, make_plan

from understudy.errors import SessionError
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.library_folder import list_versions, load_version, open_library
from understudy.ui.controller.formatting import format_saved_message
from understudy.ui.controller.lesson_actions import add_property_here
from understudy.ui.controller.open_session import begin_session
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices, make_session_start


@contextmanager
def open_trainer(folder: Path, name: str = "goto", choices: LessonChoices = GOTO) -> Iterator[Trainer]:
    made = make_plan(folder, name, choices)
    start = make_session_start(made)
    assert start is not None
    opened = begin_session(made, start, Wall())
    try:
        yield opened.trainer
    finally:
        opened.close()


def press(trainer: Trainer, state: str) -> None:
    trainer.press(state)
    trainer.tick()


def test_what_is_lost_is_said(tmp_path: Path) -> None:
    """The press that made it drive off is outvoted by two that contradict it."""
    with open_trainer(tmp_path) as here:
        press(here, "forward")
        here.save()
        assert here.status.text == f"Saved in {tmp_path / 'goto.json'}"
        first = here.session.examples[0]
        for _ in range(2):
            here.reset_world()
            here.restart()
            press(here, "rotate_left")
        assert here.session.examples[-2].values == first.values
        here.save()
    assert here.status.tone == "error"
    assert here.status.text.endswith(
        "but something that worked no longer does: where it went from start to forward as shown (example 1), it now "
        "goes to rotate_left"
    )
    assert not here.has_unsaved_changes, "it is saved all the same"


def test_a_promise_that_is_broken_is_said(tmp_path: Path) -> None:
    with open_trainer(tmp_path) as here:
        press(here, "done")
        here.reset_world()
        here.save()
        add_property_here(here, "done", 1.0)
        assert here.status.text.startswith(
            "Property from here: done is raised within 1 s in forage, A = station"
        )
        assert here.has_unsaved_changes
        here.save()
        saved = here.status
        assert saved.tone == "recorded"
        here.session.quarantine({1: "meant for later"})
        assert here.has_unsaved_changes
        here.save()
        assert here.status.tone == "error"
        assert (
            "goto no longer has the property: done is raised within 1 s in forage, A = station"
            in here.status.text
        )
        with pytest.raises(SessionError, match="its flags are done"):
            add_property_here(here, "failed", 1.0)
    taught = open_library(tmp_path, FORAGE_KIT).library.taught["goto"]
    assert taught.lesson is not None
    assert len(taught.lesson.properties) == 1


def test_only_some_is_said() -> None:
    said = format_saved_message(Path("goto.json"), ("a", "b", "c", "d"))
    assert said == (
        "Saved in goto.json, but something that worked no longer does: a; b; and 2 more, which `understudy test` lists"
    )


def test_what_others_saved_meanwhile_is_said_and_kept(tmp_path: Path) -> None:
    """Two teach the same automaton at once: whoever saves last is told once, and no lesson is lost."""
    with open_trainer(tmp_path) as here, open_trainer(tmp_path) as there:
        press(here, "forward")
        press(there, "rotate_left")
        tones = []
        for saving in (there, here, here):
            saving.save()
            tones.append(saving.status.tone)
            if saving is here and len(tones) == 2:
                assert here.status.text.endswith(
                    "; others had saved another version of goto meanwhile, which is kept as a former version"
                )
    assert tones == ["recorded", "error", "recorded"]
    (former,) = list_versions(tmp_path, "goto")
    kept = load_version(tmp_path, "goto", former.number, FORAGE_KIT).taught.lesson
    assert kept is not None
    assert kept.examples[0].next == "rotate_left"


def test_a_part_that_others_changed_meanwhile_is_said(tmp_path: Path) -> None:
    with open_trainer(tmp_path) as first:
        press(first, "forward")
        first.save()
    fetch = LessonChoices(live=False, states=["goto=goto(station)"], features=["done"])
    with open_trainer(tmp_path, "fetch", fetch) as here, open_trainer(tmp_path) as there:
        press(here, "goto")
        press(there, "rotate_left")
        there.save()
        here.save()
    assert here.status.text == (
        f"Saved in {tmp_path / 'fetch.json'}; goto was changed meanwhile, and is taught here as it was: open fetch "
        "again to use it"
    )
