"""Random sessions: their journal, cut off after any step, gives the lesson as it was then."""

from __future__ import annotations

from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import Scripted
from tests.training.lessons import WITH_GO, session
from tests.training.steps import do, drawn, told

from understudy.model.lesson import LearnerOptions
from understudy.training.session import Session


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32), count=st.integers(1, 60))
def test_every_prefix(seed: int, count: int) -> None:
    random = Random(seed)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal"
        taught = session(
            features=["range_of(ball)", "seen"],
            flags=["done"],
            library=WITH_GO,
            options=LearnerOptions(watched=True, reaction_s=0.2),
            journal=path,
        )
        moments = []
        for _ in range(count):
            do(taught, drawn(random))
            view = taught.view()
            seen = (taught.mode, view.waiting is not None, view.undoable, view.redoable, view.targets)
            moments.append((path.stat().st_size, told(taught), seen))
        taught.close()
        whole = path.read_bytes()
        cut = Path(folder) / "cut"
        for size, lesson, seen in moments:
            cut.write_bytes(whole[:size])
            again = Session.resume(cut, Scripted(), WITH_GO)
            again.close()
            view = again.view()
            assert told(again) == lesson
            found = (again.mode, view.waiting is not None, view.undoable, view.redoable, view.targets)
            assert found == seen
