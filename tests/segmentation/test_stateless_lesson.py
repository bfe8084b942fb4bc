"""Stateless lessons from drives, which are chosen where left-out drives say that one tree serves all states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.segmentation.drives import follow, make_drive

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.rerun_drive import count_repeated, leave_out, run_over_drive
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.addons.recordings.stateless_lesson import PRUNING, choose_stateless, make_stateless
from understudy.learning.fit import learn_automaton
from understudy.model.learner_options import SklearnOptions, TreeOptions
from understudy.model.lesson import ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Tree
from understudy.model.value_kinds import Column

MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.4}, "left": {"turn": 0.7}}
AIMS = {name: (each.get("drive", 0.0), each.get("turn", 0.0)) for name, each in MOVES.items()}
TICKS, DRIVES = 60, 6


def show(drives: list[tuple[list[str], list[float]]]) -> tuple[Segmentation, DriveLesson]:
    """Label drives, each given as what the driver meant and the range ahead at each tick, and make a lesson."""
    meant = [each for names, _ in drives for each in names]
    commands = np.concatenate(
        [
            follow([AIMS[each] for each in names], gain=1.0, seed=seed)
            for seed, (names, _) in enumerate(drives)
        ]
    )
    ranges = np.array([each for _, values in drives for each in values])
    drive = make_drive(commands, {("range", None): ranges}, lengths=[len(names) for names, _ in drives])
    # As in recordings of several files, in each of which time begins anew.
    episodes = tuple(replace(each, source=f"{number}.csv") for number, each in enumerate(drive.episodes))
    times = np.concatenate([drive.times[: len(names)] for names, _ in drives])
    drive = replace(drive, times=times, episodes=episodes)
    library = Library(make_drive_kit(drive, MOVES))
    found = segment(drive, make_candidates(library, drive))
    names = [each.name for each in found.candidates]
    assert np.mean(found.labels == [names.index(each) for each in meant]) > 0.98
    return found, to_lesson(found, library=library, features=["range"], reaction_s=0.0)


def choose_by_range(ahead: float) -> str:
    return "back" if ahead < 1.0 else "left" if ahead < 2.0 else "forward"


def drive_by_range(seed: int) -> tuple[list[str], list[float]]:
    """A driver whose every decision depends on the range alone, which jumps now and then."""
    random = np.random.default_rng(seed)
    levels = random.permutation([0.4, 1.5, 3.0]).repeat(TICKS // 3)
    ranges = (levels + 0.3 * random.uniform(-1, 1, TICKS)).tolist()
    return [choose_by_range(each) for each in ranges], ranges


def drive_by_turns(seed: int) -> tuple[list[str], list[float]]:
    """A driver who goes on to 3 m, then back to 1 m: between them, the range alone does not tell which."""
    random = np.random.default_rng(seed)
    state, ahead, names, ranges = "forward", float(random.uniform(1.5, 2.5)), list[str](), list[float]()
    for _ in range(2 * TICKS):
        if ahead > 3.0:
            state = "back"
        elif ahead < 1.0:
            state = "forward"
        names.append(state)
        ranges.append(ahead)
        ahead += 0.1 if state == "forward" else -0.1
    return names, ranges


def agree(found: Segmentation, made: DriveLesson, unseen: Segmentation) -> float:
    """Learn the lesson, and measure its agreement with the labels of other drives."""
    trained = TrainedAutomaton(learn_automaton(made.lesson), made.lesson)
    names = tuple(each.name for each in unseen.candidates)
    states = run_over_drive(made.library.with_automaton(trained), made.lesson.name, unseen.drive, names)
    return count_repeated(unseen, states).share


def test_decisions_by_readings_alone_become_one_tree() -> None:
    found, made = show([drive_by_range(seed) for seed in range(DRIVES)])
    unseen, _ = show([drive_by_range(seed) for seed in range(100, 110)])
    chosen = choose_stateless(found, made)
    assert chosen.lesson.automaton.stateless
    assert agree(found, chosen, unseen) > agree(found, made, unseen)
    assert agree(found, chosen, unseen) > 0.97
    (tree,) = set(learn_automaton(chosen.lesson).transitions.values())
    assert isinstance(tree, Tree)
    assert len(tree.nodes) == 5


def test_decisions_that_depend_on_the_state_keep_a_tree_for_each() -> None:
    found, made = show([drive_by_turns(seed) for seed in range(DRIVES)])
    assert choose_stateless(found, made) is made


def test_examples_are_left_out_by_file_where_times_are_the_same() -> None:
    found, made = show([drive_by_range(seed) for seed in range(DRIVES)])
    rest = leave_out(made.lesson, found.drive, found.drive.episodes[1::3])
    files = [each.source.file for each in rest.examples if each.source]
    assert set(files) == {"0.csv", "2.csv", "3.csv", "5.csv"}
    out = [each for each in made.sources.values() if each.file in ("1.csv", "4.csv")]
    assert len(files) == len(made.lesson.examples) - len(out)


def test_examples_are_left_out_by_time_within_a_file() -> None:
    found, made = show([drive_by_range(seed) for seed in range(2)])
    one = [replace(each, source="one.csv") for each in found.drive.episodes]
    times: Column = np.arange(found.drive.ticks, dtype=np.float64) * found.drive.tick_s
    found = replace(found, drive=replace(found.drive, episodes=tuple(one), times=times))
    made = to_lesson(found, library=made.library, features=["range"], reaction_s=0.0)
    rest = leave_out(made.lesson, found.drive, one[:1])
    assert 0 < len(rest.examples) < len(made.lesson.examples)
    assert min(each.source.time_s for each in rest.examples if each.source) >= times[one[1].first]


def test_a_stateless_lesson_confirms_what_went_on() -> None:
    _, made = show([drive_by_range(seed) for seed in range(DRIVES)])
    shared = make_stateless(made.lesson)
    kinds = [each.kind for each in made.lesson.examples]
    expected = [ExampleKind.CONFIRMATION if each is ExampleKind.WATCHED else each for each in kinds]
    assert ExampleKind.WATCHED in kinds
    assert [each.kind for each in shared.examples] == expected
    assert shared.options.learner == TreeOptions(pruning=PRUNING)
    strong = replace(made.lesson, options=replace(made.lesson.options, learner=TreeOptions(pruning=3.0)))
    assert make_stateless(strong).options.learner == TreeOptions(pruning=3.0)


@pytest.mark.parametrize("why", ["one episode", "stateless", "classifier"])
def test_lessons_that_stay_as_they_are(why: str) -> None:
    found, made = show([drive_by_range(seed) for seed in range(1 if why == "one episode" else DRIVES)])
    if why == "stateless":
        made = replace(made, lesson=make_stateless(made.lesson))
    elif why == "classifier":
        options = replace(made.lesson.options, learner=SklearnOptions("SVC"))
        made = replace(made, lesson=replace(made.lesson, options=options))
    assert choose_stateless(found, made) is made
