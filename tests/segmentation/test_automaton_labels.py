"""Drives explained by automata, whose switches drivers need not share, and lessons with parameters made of them."""

from __future__ import annotations

import json
from math import log
from pathlib import Path

import numpy as np
import pytest
from tests.segmentation.driven import ANNA, MAP, make_lesson, read
from typer.testing import CliRunner

from understudy import learn_automaton, make_candidates, segment
from understudy.addons.recordings.alternation import MISTIMED, allow_mistimed, find_answered_states
from understudy.addons.recordings.lesson_from_drive import parametrize_lesson, to_lesson
from understudy.errors import DefinitionError, UnknownName
from understudy.model.binding import Binding
from understudy.ui.cli.main import make_command_line

LABELS = np.array([0, 0, 1, 2])  # an automaton with two states, a behavior, and none of them


def test_a_driver_may_do_what_another_state_of_the_label_does() -> None:
    fit = np.array([[-1.0, -9.0, -2.0, -5.0]])
    rare = log(0.95 * np.exp(-9.0) + 0.05 * np.exp(-1.0))
    assert MISTIMED == 0.05
    assert allow_mistimed(fit, LABELS)[0] == pytest.approx([-1.0, rare, -2.0, -5.0])


ANSWERED = [  # fit of the two states of the automaton, present state, state that the command answers to
    ((-1.0, -9.0), 0, 0),
    ((-1.0, -9.0), 1, 0),
    ((-1.0, -1.5), 1, 1),  # only a little better: no sign of a switch at another time
    ((-9.0, -1.0), 2, 2),  # another label
]


@pytest.mark.parametrize(("fits", "state", "answered"), ANSWERED)
def test_the_state_that_a_command_answers_to(fits: tuple[float, float], state: int, answered: int) -> None:
    fit = allow_mistimed(np.array([[*fits, -2.0, -5.0]]), LABELS)
    assert find_answered_states(fit, LABELS, np.array([state])).tolist() == [answered]


def test_a_drive_to_a_target_teaches_to_drive_to_any(tmp_path: Path) -> None:
    drive, library = read(ANNA.write(tmp_path / "anna.csv"))
    made = to_lesson(segment(drive, make_candidates(library, drive)), library=library, targets={"A": "ball"})
    automaton = learn_automaton(made.lesson)
    assert automaton.parameters == ("A",)
    assert "range(A)" in [str(each) for each in automaton.features]
    assert {each.binding for each in made.lesson.examples} == {Binding(A="ball")}
    plain = learn_automaton(make_lesson(tmp_path / "anna.csv", "").lesson)
    assert repr(automaton.transitions).replace("(A)", "(ball)") == repr(plain.transitions)


def test_parameters_that_stand_for_nothing_are_refused(tmp_path: Path) -> None:
    lesson = make_lesson(ANNA.write(tmp_path / "anna.csv"), "").lesson
    assert parametrize_lesson(lesson, {}) is lesson
    with pytest.raises(UnknownName, match=r"door.*ball"):
        parametrize_lesson(lesson, {"A": "door"})
    with pytest.raises(DefinitionError, match="A, B stand for one target"):
        parametrize_lesson(lesson, {"A": "ball", "B": "ball"})
    with pytest.raises(DefinitionError, match="'ball' has the name of a target"):
        parametrize_lesson(lesson, {"ball": "ball"})


def test_a_recording_teaches_an_automaton_with_a_parameter(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(MAP)
    arguments = [
        "learn",
        "--recording",
        str(ANNA.write(tmp_path / "anna.csv")),
        "--map",
        str(tmp_path / "map.toml"),
    ]
    done = CliRunner().invoke(make_command_line(), [*arguments, "--targets", "A=ball", "--json"])
    assert done.exit_code == 0, done.output
    assert any("range(A)" in line for line in json.loads(done.stdout)["states"]["forward"]["conditions"])
    refused = CliRunner().invoke(make_command_line(), [*arguments, "--targets", "A=door"])
    assert refused.exit_code == 2
    assert "door" in refused.output
    assert "ball" in refused.output


def write_drive_by_count(path: Path, late: int) -> Path:
    """A drive that goes back once three are counted, and forward at none, each some ticks later than it was seen."""
    random, rows, commands, count = (
        np.random.default_rng(0),
        ["time_s,count,command.drive"],
        [0.8] * (late + 1),
        0,
    )
    for tick in range(600):
        if tick % 10 == 9:
            count += 1 if commands[-1] > 0 else -1
        commands.append(-0.5 if count >= 3 else 0.8 if count <= 0 else commands[-1])
        rows.append(f"{tick / 10:.1f},{count},{commands[-1 - late] + 0.02 * random.normal():.4f}")
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("late", [0, 1, 2])
def test_a_driver_answers_late_to_an_event(tmp_path: Path, late: int) -> None:
    """The ticks between an event and the answer to it do not count as ticks in which the driver would go on."""
    drive, library = read(write_drive_by_count(tmp_path / "drive.csv", late))
    made = to_lesson(segment(drive, make_candidates(library, drive)), library=library)
    stays = [each for each in made.lesson.examples if each.state == each.next == "forward"]
    assert max(each.values[0] for each in stays) == 2.0
    learned = learn_automaton(made.lesson)
    decide = learned.transitions["forward"].decide
    back = learned.state_names.index("back")
    assert [decide([count]) == back for count in (0.0, 1.0, 2.0, 3.0)] == [False, False, False, True]


def test_a_rare_switch_goes_into_quarantine_with_its_default(tmp_path: Path) -> None:
    """In one of many turns, the stick is a tick early: at two, as which the driver goes on at all others."""
    path = write_drive_by_count(tmp_path / "drive.csv", 0)
    rows = path.read_text().splitlines()
    turn = next(
        at
        for at in range(2, len(rows))
        if float(rows[at].split(",")[2]) < 0 < float(rows[at - 1].split(",")[2])
    )
    time_s, count, _ = rows[turn - 1].split(",")
    rows[turn - 1] = f"{time_s},{count},-0.5"
    path.write_text("\n".join(rows) + "\n")
    drive, library = read(path)
    lesson = to_lesson(segment(drive, make_candidates(library, drive)), library=library).lesson
    doubted = [
        (str(each.kind), each.state, each.next, each.values[0])
        for each in lesson.examples
        if each.quarantined
    ]
    assert sorted(doubted) == [("default", "back", "back", 2.0), ("directive", "forward", "back", 2.0)]
