"""The journal: whatever a session did before it was killed, resuming gives the identical lesson."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from tests.bodies import Scripted, kit
from tests.make.sessions import WITH_GO, list_rows, make_session, play

from understudy.errors import FileError
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Continuous
from understudy.runtime.body import Reading, list_reading_keys
from understudy.storage.append_log import AppendLog, JournalLock
from understudy.training.journal import MAGIC, TicksLogged, read_journal, unpack_rows
from understudy.training.journal_replay import ReplayedSession
from understudy.training.session import Session
from understudy.training.trainee import Mode

LOGS: list[AppendLog] = []


@pytest.fixture(autouse=True)
def killed_processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a killed process held is closed for it, and nothing is flushed that was not: writing flushes."""
    begin = AppendLog.__init__

    def remember_log(self: AppendLog, path: Path, lock: JournalLock | None = None) -> None:
        begin(self, path, lock)
        LOGS.append(self)

    monkeypatch.setattr(AppendLog, "__init__", remember_log)
    yield
    for log in LOGS:
        log._file.close()
        log._lock.release()
    LOGS.clear()


BOTH = LearnerOptions(watched=True, reaction_s=0.2)
FEATURES = ["range_of(ball)", "seen", "done", "time_in_state", "watch"]


def in_a_test(taught: Session) -> Session:
    """Taught a little, and in a test, at a flag it has raised."""
    play(taught, "forward", 5, "go", 6, "left", 5, "done", 2)
    taught.reset(0)
    taught.test()
    return play(taught, 25)


def stop_watching(taught: Session) -> Session:
    taught.is_watching = False
    return play(taught, "left", 9)


def driven(taught: Session) -> None:
    play(taught, "forward", 5, "left", 2)
    taught.drive("left")
    play(taught, 3)
    taught.drive(None)
    play(taught, 2)


def chosen(taught: Session) -> None:
    play(taught, "forward", 5)
    taught.change_design(
        features=["load"], options=LearnerOptions(reaction_s=0.5), states=["forward", "left"]
    )
    play(taught, "left", 3)


def with_a_parameter(taught: Session) -> None:
    play(taught, "forward", 5)
    taught.change_design(parameters=["A"], features=["range_of(A)"], targets={"A": "goal"})
    taught.bind_targets(A="ball")
    play(taught, "left", 3)


def chosen_back(taught: Session) -> None:
    play(taught, "forward", 5, "left", 2)
    taught.change_design(states=["left"])
    taught.undo()


def chosen_while_a_press_waits(taught: Session) -> None:
    play(taught, "forward", 5, "left")
    taught.change_design(states=["forward"])
    taught.change_design(states=["forward", "left"])


def edit(taught: Session) -> None:
    play(taught, "forward", 5)
    taught.edit(1, values={"range_of(ball)": 3.0})


def delete(taught: Session) -> None:
    play(taught, "forward", 5, "left", 5)
    taught.delete(2, 4)
    play(taught, "right", 2)


def doubt(taught: Session) -> None:
    play(taught, "forward", 5, "left", 5)
    taught.quarantine({1: "too early", 3: "too late"})
    taught.quarantine({3: ""})


Before = Callable[[Session], object]
BEFORE: dict[str, Before] = {
    "nothing": lambda taught: taught,
    "ticks": lambda taught: play(taught, 120),
    "presses": lambda taught: play(taught, 3, "forward", 70, "left", 2, "confirm", 3),
    "a press that waits": lambda taught: play(taught, 3, "forward", 7, "left"),
    "a press that waits while testing": lambda taught: play(in_a_test(taught), "restart", 3, "left"),
    "undo": lambda taught: play(taught, "forward", 5, "left", 5, "undo"),
    "undo of a press that waits": lambda taught: play(taught, "forward", 5, "left", 5, "go", "undo"),
    "redo": lambda taught: play(taught, "forward", 5, "left", 5, "undo", "undo", "redo"),
    "a new step after undo": lambda taught: play(taught, "forward", 5, "left", 5, "undo", "right", 2),
    "restart of a press that waits": lambda taught: play(taught, "forward", 5, "left", "restart"),
    "driving": driven,
    "choose": chosen,
    "a parameter": with_a_parameter,
    "choosing back": chosen_back,
    "choosing while a press waits": chosen_while_a_press_waits,
    "edit": edit,
    "delete": delete,
    "quarantine": doubt,
    "watched": lambda taught: play(taught, "forward", 30, "left", 30, "restart", 5),
    "not watched": stop_watching,
    "testing": in_a_test,
    "a corrected flag": lambda taught: play(in_a_test(taught), "right", 4),
    "a corrected flag, undone": lambda taught: play(in_a_test(taught), "right", 4, "undo"),
    "train": lambda taught: play(in_a_test(taught), "train", 2),
}


def begin_journal(folder: Path, body: Scripted | None = None) -> Session:
    return make_session(
        ["forward", "left", "right", "go", "click"],
        FEATURES,
        flags=["done"],
        library=WITH_GO,
        options=BOTH,
        journal=folder / "journal",
        body=body,
    )


def resume(folder: Path, body: Scripted | None = None) -> Session:
    """Go on as after a kill: what the former process held is released."""
    for log in LOGS:
        log._lock.release()
    return Session.resume(folder / "journal", body or Scripted(), WITH_GO)


def describe_examples(examples: Sequence[Example]) -> list[str]:
    """Examples to compare: absent equals absent."""
    return [repr(example) for example in examples]


def describe_acknowledged(taught: Session) -> Any:
    """What must outlast a kill: everything acknowledged. What was only seen in silence may be lost."""
    view = taught.view()
    log = taught._log
    return (
        taught.automaton,
        describe_examples(taught.examples),
        log.lesson.options,
        view.targets,
        taught.mode,
        view.undoable,
        view.redoable,
        log.presses,
    )


@pytest.mark.parametrize("before", BEFORE.values(), ids=BEFORE)
def test_resuming_gives_the_identical_lesson(tmp_path: Path, before: Before) -> None:
    taught = begin_journal(tmp_path)
    before(taught)
    again = resume(tmp_path)
    assert describe_acknowledged(again) == describe_acknowledged(taught)
    assert again.view().waiting == taught.view().waiting
    taught.is_watching = False  # compared without what was seen in silence since
    taught._log._watched.clear()
    assert describe_examples(again.lesson.examples) == describe_examples(taught.lesson.examples)
    assert again.lesson.record == taught.lesson.record
    play(again, "confirm", 1, "left", 3, "undo", "undo", "redo")
    once_more = resume(tmp_path)  # a journal that was gone on with is as good
    assert describe_acknowledged(once_more) == describe_acknowledged(again)
    while again.view().undoable:
        assert again.undo() == once_more.undo()
        assert describe_examples(again.examples) == describe_examples(once_more.examples)


@pytest.mark.parametrize("before", BEFORE.values(), ids=BEFORE)
def test_undoing_everything_after_resuming(tmp_path: Path, before: Before) -> None:
    taught = begin_journal(tmp_path)
    before(taught)
    again = resume(tmp_path)
    while taught.view().undoable:
        assert again.undo() == taught.undo()
        assert describe_acknowledged(again)[:3] == describe_acknowledged(taught)[:3]


def test_a_press_that_waits_acts_after_resuming_as_it_would_have(tmp_path: Path) -> None:
    """The body goes on from the snapshot at the press, and the readings before it are there to shift to."""
    taught = begin_journal(tmp_path)
    taught.is_watching = False
    play(taught, 3, "forward", 7, "left")
    again = resume(tmp_path)
    assert again.body.time_s == taught.body.time_s
    play(taught, 1)
    play(again, 1)
    assert describe_examples(again.examples) == describe_examples(taught.examples)
    assert list_rows(again)[2][:2] == ("forward", 92)  # pressed at 90 m
    assert describe_acknowledged(again) == describe_acknowledged(taught)


def test_no_reading_is_taken_from_before_the_kill(tmp_path: Path) -> None:
    """The body is back at its last snapshot: what was sensed since then is not its past."""
    play(begin_journal(tmp_path, Slow()), "forward", 30)
    again = resume(tmp_path, Slow())
    assert again.body.time_s == 5.0
    here = again.view().features["range_of(ball)"]
    play(again, "left", 1)
    assert list_rows(again)[2][1] == here


def test_a_body_that_cannot_be_rewound_goes_on_from_where_it_is(tmp_path: Path) -> None:
    play(begin_journal(tmp_path, Real()), 3, "forward", 7)
    body = Real()
    body.tick = 500
    again = resume(tmp_path, body)
    assert again.view().path == ("forward",)
    assert again.view().features["time_in_state"] == 0.0
    play(again, 2)
    assert again.view().features["time_in_state"] == 0.2


class Slow(Scripted):
    """Snapshots every 25 ticks, chunks of 50."""

    tick_s = 0.2


class Real(Scripted):
    """No snapshots: not Rewindable."""

    snapshot = None  # type: ignore[assignment]
    restore = None  # type: ignore[assignment]


def test_body_and_automaton_go_back_to_the_last_snapshot(tmp_path: Path) -> None:
    taught = play(begin_journal(tmp_path), "go", 60)
    again = resume(tmp_path)
    assert again.body.time_s == 5.0  # every 5 s
    assert again.view().path == taught.view().path == ("go", "done")
    taught.reset(0)
    play(taught, 3)
    assert resume(tmp_path).body.time_s == 0.0  # and whenever the robot was moved


def test_a_journal_may_be_named_by_a_text(tmp_path: Path) -> None:
    path = str(tmp_path / "journal")
    taught = play(make_session(["forward", "left"], ["done"], journal=path), "forward", 3)
    taught.close()
    resumed = Session.resume(path, Scripted(), Library(kit))
    assert resumed.lesson == taught.lesson


def test_about_is_kept(tmp_path: Path) -> None:
    body, first = Scripted(), make_session()
    Session(body, first.library, first.lesson, journal=tmp_path / "j", about={"world": "forage", "seed": 7})
    assert ReplayedSession.from_journal(tmp_path / "j", first.library, list_reading_keys(body)).about == {
        "world": "forage",
        "seed": 7,
    }


def test_every_tick_is_in_the_journal(tmp_path: Path) -> None:
    taught = play(begin_journal(tmp_path), 3, "forward", 120)
    taught.close()
    ticks = [entry for entry in read_journal(tmp_path / "journal") if isinstance(entry, TicksLogged)]
    keys = 7
    values = [row for entry in ticks for row in unpack_rows(entry.rows, keys).tolist()]
    assert [row[0] for row in values] == [100.0 - tick for tick in range(123)]
    assert [state for entry in ticks for state in entry.states] == ["start"] * 4 + ["forward"] * 119


# Cut off anywhere


def test_cut_off_anywhere_it_is_the_lesson_of_some_moment(tmp_path: Path) -> None:
    taught = begin_journal(tmp_path)
    steps: list[str | int] = ["forward", 4, "left", 4, "undo", "right", 2, "test", 3, "left", 1]
    moments = [describe_acknowledged(taught)[:3]]
    for step in steps:
        for each in [step] if isinstance(step, str) else [1] * step:
            play(taught, each)
            moments.append(describe_acknowledged(taught)[:3])
    whole = (tmp_path / "journal").read_bytes()
    readable = refused = 0
    for cut in range(0, len(whole), 11):
        (tmp_path / "cut").write_bytes(whole[:cut])
        try:
            again = Session.resume(tmp_path / "cut", Scripted(), WITH_GO)
        except FileError:
            refused = cut
            continue
        assert not refused or cut > refused
        assert describe_acknowledged(again)[:3] in moments
        again.close()
        readable += 1
    assert readable > 100


# What is refused


def test_a_journal_that_a_session_is_writing(tmp_path: Path) -> None:
    """Two writers would mix a lesson that nobody showed; the body is left as it is."""
    taught = play(begin_journal(tmp_path), "forward", 5)
    before, body = (tmp_path / "journal").read_bytes(), Scripted()
    for _ in range(2):
        with pytest.raises(FileError, match="another session is writing it; end that"):
            Session.resume(tmp_path / "journal", body, WITH_GO)
    assert (tmp_path / "journal").read_bytes() == before
    assert body.tick == 0
    taught.close()
    without = Library(Kit.from_parts(*list(kit.parts)[4:]))
    with pytest.raises(FileError, match="journal"):  # one that fails leaves the journal to others
        Session.resume(tmp_path / "journal", Scripted(), without)
    again = Session.resume(tmp_path / "journal", body, WITH_GO)
    assert describe_acknowledged(again) == describe_acknowledged(taught)
    with pytest.raises(FileError, match="another session"):
        Session.resume(tmp_path / "journal", Scripted(), WITH_GO)


def test_refused(tmp_path: Path) -> None:
    taught = begin_journal(tmp_path)
    path = tmp_path / "journal"
    with pytest.raises(FileError, match=r"journal.*exists already"):
        begin_journal(tmp_path)
    taught.close()
    with pytest.raises(FileError, match="cannot be read"):
        Session.resume(tmp_path / "none", Scripted(), WITH_GO)
    other = Scripted()
    other.readings = (*other.readings, Reading("more", Continuous()))  # type: ignore[assignment]
    with pytest.raises(FileError, match="other readings"):
        Session.resume(path, other, WITH_GO)
    with pytest.raises(FileError, match="journal"):
        Session.resume(path, Scripted(), Library(Kit.from_parts(*list(kit.parts)[4:])))
    (tmp_path / "empty").write_bytes(MAGIC)
    with pytest.raises(FileError, match="no session begins"):
        Session.resume(tmp_path / "empty", Scripted(), WITH_GO)
    assert taught.mode is Mode.TRAINING


@pytest.mark.parametrize(
    ("entry", "problem"),
    [
        (b"\x81\xa4more" + b"\x91" * 3000 + b"\x90", "it is nested too deeply"),
        (b"\x81\xa4type\xa1\xff", "it is not UTF-8"),
    ],
)
def test_a_damaged_entry_is_refused(entry: bytes, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "journal"
    log = AppendLog.create(path, MAGIC)
    log.write(entry)
    log.close()
    with pytest.raises(FileError, match=f"entry 1: it cannot be understood .{problem}"):
        list(read_journal(path))
