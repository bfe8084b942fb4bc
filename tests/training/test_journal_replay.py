"""Random sessions: their journal, cut off after any step, gives the session as it was then."""

from __future__ import annotations

from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import Scripted
from tests.make.sessions import WITH_GO, list_rows, make_session, play
from tests.training.steps import Step, describe_acknowledged, do, draw_step

from understudy.model.learner_options import LearnerOptions
from understudy.training.session import Session
from understudy.training.trainee import Mode


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32), count=st.integers(1, 60))
def test_every_prefix(seed: int, count: int) -> None:
    random = Random(seed)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal"
        taught = make_session(
            features=["range_of(ball)", "seen"],
            flags=["done"],
            library=WITH_GO,
            options=LearnerOptions(watched=True, reaction_s=0.2),
            journal=path,
        )
        moments = []
        for _ in range(count):
            do(taught, draw_step(random, more=(("teach",),) * 3))
            view = taught.view()
            seen = (taught.mode, view.waiting is not None, view.undoable, view.redoable, view.targets)
            moments.append((path.stat().st_size, describe_acknowledged(taught), seen))
        taught.close()
        whole = path.read_bytes()
        cut = Path(folder) / "cut"
        for size, lesson, seen in moments:
            cut.write_bytes(whole[:size])
            again = Session.resume(cut, Scripted(), WITH_GO)
            again.close()
            view = again.view()
            assert describe_acknowledged(again) == lesson
            found = (again.mode, view.waiting is not None, view.undoable, view.redoable, view.targets)
            assert found == seen


ACTIONS: list[Step] = [
    *(("direct", state) for state in ("forward", "left", "done", "failed", "start")),
    ("confirm",),
    *(("tick", count) for count in (1, 2, 12)),
    *[("undo",)] * 2,
    ("redo",),
    ("test",),
    ("go on testing",),
    ("train",),
    ("teach",),
    ("pause", True),
    ("pause", False),
    ("restart",),
    ("reset", 0),
    *(("delete", number) for number in (1, 2, 3)),
    ("choose", {"states": ["forward"]}),
    ("choose", {"states": ["forward", "left"]}),
    ("choose", {"flags": ["done"]}),
    ("choose", {"flags": ["failed", "done"]}),
    *[("kill",)] * 2,
]


def act(taught: Session, step: Step) -> None:
    if step[0] == "pause":
        taught.paused = step[1]
    elif step[0] == "go on testing":
        taught.test(afresh=False)
    else:
        do(taught, step)


def resume_after_kill(taught: Session, path: Path) -> Session:
    """The session as it goes on after a kill, in the tick in which it was killed."""
    taught._log.journal.flush()
    taught._log.journal._snapshot_tick = None
    taught._keep_snapshot()
    path.with_name("cut").write_bytes(path.read_bytes())
    taught.close()
    path.write_bytes(path.with_name("cut").read_bytes())
    again = Session.resume(path, Scripted(), WITH_GO)
    again.paused = taught.paused
    return again


def describe_session(taught: Session) -> Any:
    """What a demonstrator sees of a session, and where its flag was raised."""
    view, entry = taught.view(), taught.trainee.entry
    raised = (
        None
        if entry is None
        else (entry.state, dict(entry.own), taught._log._recorder.record.values[entry.moment, 0])
    )
    learned = taught.trainee.taught.automaton.transitions if taught.mode is Mode.LIVE else {}
    return repr((describe_acknowledged(taught), view, raised, learned))


@settings(max_examples=40)
@given(st.sampled_from(["test", "teach"]), st.lists(st.sampled_from(ACTIONS), min_size=1, max_size=25))
def test_a_session_that_is_killed_is_as_one_that_is_not(mode: str, steps: list[Step]) -> None:
    """From a flag on that what was learned has raised."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal"
        both = [
            make_session(
                ["forward", "left"],
                ["range_of(ball)"],
                flags=["done", "failed"],
                library=WITH_GO,
                journal=journal,
            )
            for journal in (None, path)
        ]
        for each in both:
            play(each, "forward", 10, "left", 3, "done", 1)
            each.reset(0)
            play(each, mode, 20)
            assert each.view().flag == "done"
        for step in steps:
            if step == ("kill",):
                both[1] = resume_after_kill(both[1], path)
            else:
                for each in both:
                    act(each, step)
            assert describe_session(both[0]) == describe_session(both[1])
        both[1].close()


def test_a_press_after_a_kill_still_judges_the_switch_before_it(tmp_path: Path) -> None:
    taught = make_session(["forward", "left"], flags=["done"], library=WITH_GO, journal=tmp_path / "journal")
    play(taught, "teach", "forward", 5, "left", 2)
    taught.reset(0)
    play(taught, 7)
    assert taught.view().state == "left"
    again = resume_after_kill(taught, tmp_path / "journal")
    again.direct("forward")
    again = resume_after_kill(again, tmp_path / "journal")  # the press waits, and still knows what it judges
    play(again, 1)
    assert list_rows(again)[-1] == ("forward", 95, "forward", "confirmation")
    again.close()
