"""Lessons from recordings: a session's presses over its recording give the session's examples, every one."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from tests.make.sessions import make_session as scripted

from understudy.addons.recordings.teach_from_recording import (
    list_recorded_presses,
    read_presses,
    teach_from_recording,
)
from understudy.errors import FileError, SessionError, UnderstudyError
from understudy.model.learner_options import LearnerOptions
from understudy.records.reader import Recording, read_recording
from understudy.records.record import RecordedPress
from understudy.records.recorder import RunRecorder
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

Steps = Sequence[tuple[int, str]]
"""Before which tick, what: a state's name, or confirm, test, train, restart."""


def record_session(session: Session, path: Path, steps: Steps, ticks: int) -> Recording:
    """A session that goes on for so many ticks, recorded, with its presses."""
    waiting = list(steps)
    with RunRecorder(path, clock=lambda: session.body.time_s) as recorder:
        recorder.begin(session.body)
        for tick in range(ticks):
            while waiting and waiting[0][0] == tick:
                do(session, waiting.pop(0)[1], recorder)
            time_s, percept = session.body.time_s, session.percept
            session.tick()
            recorder.write_tick(time_s, percept, [session.trainee.path], at_s=time_s)
    return read_recording(path)


def do(session: Session, step: str, recorder: RunRecorder) -> None:
    if step in session.automaton.state_names:
        recorder.write_press(step)
        session.direct(step)
    elif step == "confirm":
        recorder.write_press(None)
        session.confirm()
    else:
        recorder.write_step(step)
        getattr(session, step)()


def table(path: Path, recording: Recording, steps: Steps) -> Path:
    """The same as a table, rounded as tables are."""
    with path.open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file)
        lines.writerow(["time_s", "state", "does"])
        for tick, step in steps:
            other = step in ("test", "train", "restart")
            state = "" if other or step == "confirm" else step
            lines.writerow([f"{recording.times[tick]:.3f}", state, step if other else ""])
    return path


PLAIN: Steps = [(0, "forward"), (7, "left"), (7, "right"), (15, "confirm"), (22, "right"), (30, "forward")]
CORRECTED: Steps = [
    *PLAIN,
    (40, "test"),
    (45, "left"),
    (50, "test"),
    (60, "restart"),
    (66, "forward"),
    (70, "train"),
]


@pytest.mark.parametrize(
    "options",
    [LearnerOptions(), LearnerOptions(reaction_s=0.3), LearnerOptions(watched=True, reaction_s=0.2)],
)
def test_presses_that_were_recorded_give_the_lesson(options: LearnerOptions, tmp_path: Path) -> None:
    session = scripted(features=["range_of(ball)", "bearing_of(goal)", "load"], options=options)
    empty = session.lesson
    recording = record_session(session, tmp_path / "s.mcap", PLAIN, 80)
    again = teach_from_recording(recording, session.library, empty, list_recorded_presses(recording))
    assert len(session.examples) >= 8
    assert again.examples == session.examples
    assert (again.lesson.record.values == session.lesson.record.values).all()


def test_a_table_of_presses_gives_the_lesson(tmp_path: Path) -> None:
    """With corrections and restarts, from a table or as they were recorded."""
    session = scripted(features=["range_of(ball)", "load"], options=LearnerOptions(reaction_s=0.2))
    empty = session.lesson
    recording = record_session(session, tmp_path / "s.mcap", CORRECTED, 80)
    presses = read_presses(table(tmp_path / "p.csv", recording, CORRECTED), recording)
    again = teach_from_recording(recording, session.library, empty, presses)
    assert any(each.correction for each in session.examples)
    assert again.examples == session.examples
    live = teach_from_recording(recording, session.library, empty, list_recorded_presses(recording))
    assert live.examples == session.examples


def test_a_session_in_a_world_is_learned_from_its_recording(tmp_path: Path) -> None:
    """In the 2-D world the readings are floats of all sorts, and absent now and then."""
    from understudy.model.library import Library
    from understudy.sim.forage import FORAGE_KIT, Forage

    library = Library(FORAGE_KIT)
    lesson = new_lesson(
        library,
        "fetch",
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(nearest_food)", "angle_to(nearest_food)"],
        options=LearnerOptions(reaction_s=0.2),
        live=False,
    )
    session = Session(Forage([3]), library, lesson)
    steps = [(0, "rotate_left"), (9, "forward"), (40, "rotate_right"), (55, "forward"), (90, "done")]
    recording = record_session(session, tmp_path / "s.mcap", steps, 100)
    presses = read_presses(table(tmp_path / "p.csv", recording, steps), recording)
    again = teach_from_recording(recording, library, lesson, presses)
    assert len(session.examples) == 9
    assert again.examples == session.examples
    assert again.make_trained_automaton().automaton == session.make_trained_automaton().automaton


WRONG = [
    ("", "line 1: its columns are none; begin with time_s,state"),
    ("time_s,button\n0,forward\n", "its columns are time_s, button"),
    ("time_s,state\n0\n", "line 2: it has 1 cells; give 2"),
    ("time_s,state\nsoon,forward\n", "line 2: time_s is 'soon'; give one of the recording, from 0 to 0.9"),
    ("time_s,state\n\n5,forward\n", "line 3: time_s is '5'"),
    ("time_s,state\n-1,forward\n", "line 2: time_s is '-1'"),
    (
        "time_s,state,does\n0,forward,jump\n",
        "line 2: does is 'jump'; give press, test, train, teach, restart",
    ),
    ('time_s,state\n0,"forward\n', "it cannot be read"),
]


@pytest.mark.parametrize(("content", "problem"), WRONG)
def test_a_table_that_cannot_be_is_refused(content: str, problem: str, tmp_path: Path) -> None:
    recording = record_session(scripted(), tmp_path / "s.mcap", [], 10)
    presses = tmp_path / "p.csv"
    presses.write_text(content, encoding="utf-8")
    with pytest.raises(FileError) as refusal:
        read_presses(presses, recording)
    assert problem in str(refusal.value)


def test_presses_that_cannot_be_are_refused(tmp_path: Path) -> None:
    session = scripted()
    empty = session.lesson
    recording = record_session(session, tmp_path / "s.mcap", [], 10)
    with pytest.raises(SessionError, match="holds no presses; give --presses"):
        list_recorded_presses(recording)
    with pytest.raises(UnderstudyError, match="no state 'backward'"):
        teach_from_recording(recording, session.library, empty, [RecordedPress(3, "backward")])
    with pytest.raises(
        SessionError, match="has a step 'jump'; sessions have press, test, train, teach, restart"
    ):
        teach_from_recording(recording, session.library, empty, [RecordedPress(3, None, does="jump")])


def test_a_press_between_ticks_acts_at_the_next(tmp_path: Path) -> None:
    recording = record_session(scripted(), tmp_path / "s.mcap", [], 10)
    presses = tmp_path / "p.csv"
    presses.write_text("time_s,state\n0.31,left\n0.3,right\n0.9,\n", encoding="utf-8")
    assert read_presses(presses, recording) == [
        RecordedPress(4, "left"),
        RecordedPress(3, "right"),
        RecordedPress(9, None),
    ]
    assert np.allclose(recording.times, np.arange(10) / 10)
