"""The hierarchy experiment: what a curve needs, who forages in one piece, and a teaching beside the published."""

from __future__ import annotations

from itertools import pairwise

import pytest

from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT
from understudy.training.trainee import Mode, SessionView
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.hierarchy import study
from understudy_lab.hierarchy.forage_variants import OneLayer, should_go_home, show_two_layers
from understudy_lab.hierarchy.teach import (
    MOST_LOOKS,
    LearningCurve,
    PartwiseTeacher,
    choose_unseen_worlds,
    find_first_success,
    success_at,
    topics,
)
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.tasks.soccer import kit as soccer_kit
from understudy_lab.teachers.teacher import FIRST_SEED, Patience, ScriptedTeacher


@pytest.mark.retrains
@pytest.mark.parametrize("way", ["two automata", "three layers"])
def test_a_teaching_is_as_published(way: str) -> None:
    known = load_published("hierarchy")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"way": way, "seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


NEEDS = [
    ([0.0, 0.9, 1.0, 0.95, 0.9, 0.2], 1),
    ([0.9, 0.9, 0.9, 0.89, 1.0, 1.0, 1.0, 1.0], 4),
    ([0.0, 1.0, 1.0, 1.0], None),  # three are not four
    ([1.0, 1.0, 0.8], None),
    ([], None),
]


@pytest.mark.parametrize(("successes", "first"), NEEDS)
def test_four_looks_in_a_row(successes: list[float], first: int | None) -> None:
    assert find_first_success(successes) == first


LOOKS = [  # what is seen at each look, how many are taken, whether four in a row went well
    ([0.9, 1.0, 1.0, 1.0, 0.0], 4, True),
    ([1.0, 1.0, 1.0, 0.8, 1.0], 4, False),
    ([0.0, 1.0], 1, False),
]


@pytest.mark.parametrize(("seen", "taken", "held"), LOOKS)
def test_looks_go_on_until_four_or_failure(seen: list[float], taken: int, held: bool) -> None:
    curve = LearningCurve("forage", lambda library, look: seen[look])
    curve.teacher = ScriptedTeacher(Library(FORAGE_KIT), make_practice, 0, options={})
    assert curve.held("goto")
    assert curve.points == []
    assert curve.held("forage") is held
    assert curve.successes == seen[:taken]


def test_no_world_is_looked_at_twice_or_judged_in_the_end() -> None:
    seed = study.SEEDS[0]
    looks = [choose_unseen_worlds(seed, look) for look in (0, 1, MOST_LOOKS - 1)] + [
        choose_unseen_worlds(seed + 1, 0)
    ]
    assert sorted(looks, key=lambda look: look.start) == looks
    assert all(before.stop <= after.start for before, after in pairwise(looks))
    assert looks[-1].stop < FIRST_SEED
    assert worlds_of(seed).stop < looks[0].start


def test_who_is_told_that_it_does_not_hold_goes_on_with_tries() -> None:
    answers = iter([False, True])
    told: list[float] = []

    def next_answer(name: str) -> bool:
        told.append(teacher.accounts[name].seconds)
        return next(answers)

    teacher = PartwiseTeacher(
        Library(soccer_kit),
        lambda _, world: Soccer([world]),
        1,
        held=next_answer,
        options={},
        patience=Patience(99),
    )
    teacher.teach(*topics("left")["one automaton"])
    assert len(told) == 2
    assert told[0] < told[1]


def test_success_is_that_of_the_last_look() -> None:
    points = [(4, 10.0, 0.0), (8, 20.0, 0.5)]
    assert [success_at(points, upto, 0) for upto in (3, 4, 7, 8, 99)] == [0.0, 0.0, 0.0, 0.5, 0.5]
    assert success_at(points, 19.0, 1) == 0.0


def test_a_teaching_that_never_gets_there_counts_with_all_its_examples() -> None:
    row = {"points": [(4, 10.0, 1.0), (8, 20.0, 0.5)]}
    assert not study.has_reached_goal(row)
    assert (study.count_needed(row, 0), study.count_needed(row, 1)) == (8, 20.0)


def screen(state: str, **features: float) -> SessionView:
    usual = {
        "food_left": 1.0,
        "food_stored": 0.0,
        "food_below_me": 0.0,
        "at_station": 0.0,
        "done": 0.0,
        "angle_to(nearest_food)": 0.0,
        "angle_to(station)": 3.0,
    }
    return SessionView(
        0.0, Mode.TRAINING, state, (state,), None, usual | features, (), {}, None, 0, None, None
    )


WISHES = [
    ("start", {}, "forward_food"),
    ("start", {"angle_to(nearest_food)": 1.0}, "left_food"),
    ("forward_food", {"angle_to(nearest_food)": 0.5}, None),
    ("forward_food", {"angle_to(nearest_food)": 5.5}, "right_food"),
    ("left_food", {"angle_to(nearest_food)": 0.5}, None),
    ("left_food", {"angle_to(nearest_food)": 0.3}, "forward_food"),
    ("forward_food", {"food_below_me": 3.0}, "load_food"),
    ("load_food", {"food_below_me": 1.0, "food_stored": 12.0}, "left_home"),
    ("forward_home", {"food_stored": 5.0, "angle_to(station)": 0.0}, None),
    ("forward_home", {"food_stored": 5.0, "at_station": 1.0}, "unload_food"),
    ("unload_food", {"food_stored": 0.0, "at_station": 1.0}, "forward_food"),
    ("unload_food", {"food_left": 0.0}, None),
]


@pytest.mark.parametrize(("state", "features", "wish"), WISHES)
def test_what_a_teacher_of_one_layer_wishes(state: str, features: dict[str, float], wish: str | None) -> None:
    assert OneLayer()(screen(state, **features)) == wish


SHARED = [
    ("start", {}, "forward"),
    ("forward", {"angle_to(nearest_food)": 1.0}, "left"),
    ("left", {"angle_to(nearest_food)": 0.3}, "forward"),
    ("load_food", {"food_below_me": 1.0, "food_stored": 12.0}, "left"),
    ("unload_food", {"food_stored": 3.0, "at_station": 1.0}, None),
    ("unload_food", {"food_stored": 0.0, "at_station": 1.0}, "forward"),
]


@pytest.mark.parametrize(("state", "features", "wish"), SHARED)
def test_what_a_teacher_wishes_whose_states_are_shared(
    state: str, features: dict[str, float], wish: str | None
) -> None:
    assert OneLayer(shared=True)(screen(state, **features)) == wish


def test_what_a_teacher_of_two_layers_wishes() -> None:
    assert show_two_layers(screen("start")) == "go_to_food"
    assert show_two_layers(screen("go_to_food", done=1.0)) == "load_food"
    assert show_two_layers(screen("load_food", food_stored=12.0)) == "go_home"
    assert show_two_layers(screen("go_home", food_stored=12.0, done=1.0)) == "unload_food"


def test_whoever_is_on_the_way_home_goes_on() -> None:
    assert should_go_home(screen("go_home", food_stored=3.0))
    assert not should_go_home(screen("start", food_stored=3.0))
