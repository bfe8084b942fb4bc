"""Agreement of automata with drivers, at ticks that they were not learned from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.segmentation.drives import follow, make_drive

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.rerun_drive import (
    LeftOut,
    count_repeated,
    measure_agreement,
    run_over_drive,
)
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.learning.fit import learn_automaton
from understudy.model.library import Library, TrainedAutomaton

MOVES = {"forward": {"drive": 0.8}, "back": {"drive": -0.4}}
TICKS = 60


def show(ranges: list[list[float]], meant: list[list[str]], *, target: str | None = None) -> Segmentation:
    """Label drives, each given as the range and what the driver meant at each tick."""
    aims = [(MOVES[name]["drive"], 0.0) for names in meant for name in names]
    lengths = [len(each) for each in ranges]
    drive = make_drive(
        follow(aims, gain=1.0), {("range", target): np.array([each for row in ranges for each in row])},
        lengths=lengths,
    )  # fmt: skip
    episodes = tuple(replace(each, source=f"{number}.csv") for number, each in enumerate(drive.episodes))
    drive = replace(drive, times=np.concatenate([drive.times[:each] for each in lengths]), episodes=episodes)
    return segment(drive, make_candidates(Library(make_drive_kit(drive, MOVES)), drive))


def drive_by_range(seed: int, ticks: int = TICKS) -> tuple[list[float], list[str]]:
    """A driver who turns back where the range is below 1."""
    random = np.random.default_rng(seed)
    ranges = (np.tile([0.5, 2.0], ticks // 20).repeat(10) + 0.3 * random.uniform(-1, 1, ticks)).tolist()
    return ranges, ["back" if each < 1.0 else "forward" for each in ranges]


def drive_by_chance(seed: int, ticks: int = TICKS) -> tuple[list[float], list[str]]:
    """A driver whose switches no reading tells; the range only counts the ticks, of which each occurs once."""
    random = np.random.default_rng(seed)
    names = random.permutation(["back", "forward"] * (ticks // 20)).repeat(10)
    return (1000.0 * seed + np.arange(ticks)).tolist(), names.tolist()


def teach(found: Segmentation) -> DriveLesson:
    return to_lesson(found, reaction_s=0.0)


@pytest.mark.parametrize(
    ("drives", "ticks", "left_out"),
    [(4, TICKS, LeftOut.DRIVES), (12, 20, LeftOut.DRIVES), (1, 200, LeftOut.BLOCKS)],
)
def test_a_rule_is_repeated_where_it_was_not_shown(drives: int, ticks: int, left_out: LeftOut) -> None:
    found = show(*map(list, zip(*[drive_by_range(seed, ticks) for seed in range(drives)], strict=True)))
    agreement = measure_agreement(found, teach(found))
    assert agreement.left_out == left_out
    assert [(each.source, each.ticks) for each in agreement.episodes] == [
        (f"{number}.csv", ticks) for number in range(drives)
    ]
    assert agreement.ticks == drives * ticks
    assert agreement.same_ticks == sum(each.repeated for each in agreement.episodes)
    assert agreement.share > 0.95


@pytest.mark.parametrize(("drives", "ticks"), [(6, TICKS), (1, 400)])
def test_what_no_reading_tells_is_not_repeated(drives: int, ticks: int) -> None:
    """Run over what it was learned from, the automaton knows each switch by heart."""
    found = show(*map(list, zip(*[drive_by_chance(seed, ticks) for seed in range(drives)], strict=True)))
    made = teach(found)
    trained = TrainedAutomaton(learn_automaton(made.lesson), made.lesson)
    names = tuple(each.name for each in found.candidates)
    states = run_over_drive(made.library.with_automaton(trained), made.lesson.name, found.drive, names)
    assert count_repeated(found, states).share > 0.9
    assert measure_agreement(found, made).share < 0.8


def test_ticks_that_nothing_explains_do_not_count() -> None:
    found = show(*map(list, zip(*[drive_by_range(seed) for seed in range(3)], strict=True)))
    labels = found.labels.copy()
    labels[:15] = len(found.candidates)
    agreement = measure_agreement(replace(found, labels=labels), teach(found))
    assert [each.ticks for each in agreement.episodes] == [TICKS - 15, TICKS, TICKS]


def test_a_block_begins_in_the_state_of_the_driver() -> None:
    """A driver who goes on to 3 m, then back to 1 m, so that between them only the state tells what comes next."""
    ranges, names, ahead, state = list[float](), list[str](), 2.0, "forward"
    for _ in range(400):
        state = "back" if ahead > 3.0 else "forward" if ahead < 1.0 else state
        names.append(state)
        ranges.append(ahead)
        ahead += 0.1 if state == "forward" else -0.1
    found = show([ranges], [names])
    assert measure_agreement(found, teach(found)).share > 0.97


def test_parameters_are_bound() -> None:
    shown = [drive_by_range(seed) for seed in range(3)]
    found = show(*map(list, zip(*shown, strict=True)), target="ball")
    made = to_lesson(found, reaction_s=0.0, targets={"A": "ball"})
    assert measure_agreement(found, made, targets={"A": "ball"}).share > 0.95
