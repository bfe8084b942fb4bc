"""What success means after its feature was removed from the lesson: it is said, and measured as it is said."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from tests.learning.test_shown_ranges import read
from tests.ui.cli.commands import run
from tests.ui.controller.test_keep_going import show
from tests.ui.terminal.desks import GOTO, Wall, make_plan

from understudy.errors import UnknownName
from understudy.model.lesson import Lesson
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.ui.controller.open_session import begin_session
from understudy.ui.controller.score_keeper import LessonScoreKeeper, is_success_same
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import make_session_start

ANYWHERE = "done counts wherever it is raised"


@pytest.fixture
def trainer(tmp_path: Path) -> Iterator[Trainer]:
    """GoTo, shown in four worlds, with scores that are taken at once."""
    chosen = make_plan(tmp_path / "library")
    start = make_session_start(chosen)
    assert start is not None
    opened = begin_session(chosen, start, Wall())
    opened.trainer.score = LessonScoreKeeper(opened.trainer.session, begin=lambda work: work(), worlds=20)
    show(opened.trainer, range(3, 7))
    yield opened.trainer
    opened.close()


def test_a_flag_without_its_feature_counts_anywhere_and_that_is_said(
    trainer: Trainer, tmp_path: Path
) -> None:
    assert trainer.score.describe() == "goto works in 20 of 20 new worlds"
    said = trainer.change_design(replace(GOTO, features=["angle_to(A)"])).text
    assert said.endswith(" undo reverts this. Success is now: done is raised, wherever that is")
    assert trainer.score.goal == "done is raised, wherever that is"
    last = ", and before the last change in 20 (distance_to(A) was 0.36 to 0.39 m where it was pressed)"
    assert trainer.score.describe() == f"goto works in 2 of 20 new worlds{last}"
    caution = f"{ANYWHERE}: nothing shown says where it is right"
    held = trainer.keep_going().text
    assert held == f"goto holds, as it is: in at least 95 % of worlds (121 of 121 new worlds; {caution})"
    trainer.score.note_change()  # as after the next press: both versions are without it
    assert trainer.score.describe().endswith(f" new worlds ({ANYWHERE})")
    trainer.save()
    shown = run("eval", "forage", "-l", tmp_path / "library", "--behavior", "goto", "--bind", "A=station")
    assert caution in " ".join(shown.stdout.split())


def test_what_is_measured_as_before_is_said_where_success_is_now_another_thing(trainer: Trainer) -> None:
    """The robot only drives ahead, with the distance and without it: the score falls no further."""
    for features in (["distance_to(A)"], []):
        trainer.change_design(replace(GOTO, features=features))
    said = trainer.score.describe()
    assert said == "goto works in 0 of 20 new worlds (distance_to(A) was 0.36 to 0.39 m where it was pressed)"
    trainer.undo()
    assert trainer.score.goal == "done is raised and distance_to(A) is below 0.42 m"
    assert trainer.score.describe() == "goto works in 0 of 20 new worlds"


BOTH_TELL = [  # distance, m, and time, s, at which was pressed: "done" up to 0.4 m and 2 s
    (0.2, 1.0, "done"), (0.3, 2.0, "done"), (0.4, 1.5, "done"),
    (5.0, 40.0, "turn"), (6.0, 50.0, "turn"), (7.0, 60.0, "turn"),
]  # fmt: skip


def test_by_other_features_success_is_not_the_same(tmp_path: Path) -> None:
    """Where both tell, the first one counts."""

    def make(*columns: int) -> Lesson:
        names = [["distance:continuous", "time:continuous"][column] for column in columns]
        rows = [["go", row[2], "directive", *(str(row[column]) for column in columns)] for row in BOTH_TELL]
        lines = [["state", "next", "kind", *names], *rows]
        return read(tmp_path, "\n".join(map(",".join, lines)) + "\n")

    assert is_success_same(make(0, 1), make(0))
    assert not is_success_same(make(0, 1), make(1))
    assert is_success_same(make(1), make(1))


def choose(trainer: Trainer, what: str) -> None:
    start = SeededWorlds("forage", (), 60.0)
    goal = Property(kind=PropertyKind.ALWAYS, what=what, seconds=60.0, start=start, name="comes near")
    trainer.session.change_design(goal=goal)
    trainer.note_lesson_change()


def test_a_chosen_goal_is_measured_without_its_feature(trainer: Trainer) -> None:
    """The robot reads the distance, whether the lesson uses it or not."""
    choose(trainer, "distance_to(A) is below 0.5 m")
    assert trainer.score.describe() == "goto works in 10 of 10 new worlds"
    said = trainer.change_design(replace(GOTO, features=["angle_to(A)"])).text
    assert said.endswith("undo reverts this")
    assert trainer.score.goal == "comes near"
    assert trainer.score.describe().endswith("and before the last change in 10")


def test_a_goal_that_nothing_reads_is_an_error_that_names_it(trainer: Trainer, tmp_path: Path) -> None:
    choose(trainer, "sonar_north is below 0.5 m")
    problem = "the body has no feature or reading 'sonar_north'"
    assert trainer.score.describe().startswith(f"not measured: {problem}; it has distance_to, ")
    with pytest.raises(UnknownName, match=problem):
        trainer.keep_going()
    trainer.save()
    shown = run("eval", "forage", "-l", tmp_path / "library", "--behavior", "goto", "--bind", "A=station")
    assert shown.exit_code == 2
    assert problem in " ".join(shown.output.split())
