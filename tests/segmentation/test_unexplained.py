"""What nothing explains on one of several channels, and drives that begin with a rest that nothing explains."""

from __future__ import annotations

import numpy as np
import pytest
from tests.segmentation.drives import follow, make_drive

from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.model.library import Library

MOVES = {"forward": {"drive": 1.0}, "left": {"turn": 1.0}, "right": {"turn": -1.0}}
AIMS = {
    "forward": (1.0, 0.0),
    "left": (0.0, 1.0),
    "right": (0.0, -1.0),
    "back": (-1.0, 0.0),
    "rest": (0.0, 0.0),
}


def segment_aims(*spans: tuple[str, int], lengths: tuple[int, ...] = ()) -> Segmentation:
    """The labels of a drive with these aims for so many ticks each; candidates turn and drive ahead."""
    aims = [AIMS[name] for name, ticks in spans for _ in range(ticks)]
    x = np.arange(len(aims), dtype=np.float64)
    drive = make_drive(follow(aims, gain=1.0, noise=0.01), {("x", None): x}, lengths=lengths)
    library = Library(make_drive_kit(drive, MOVES))
    return segment(drive, make_candidates(library, drive))


@pytest.mark.parametrize("unknown", ["back", "rest"])
def test_a_channel_that_nothing_explains_is_not_outweighed_by_one_at_rest(unknown: str) -> None:
    """Driving back fits `forward` on the turn, which rests, and rest fits it too; on the drive neither does."""
    found = segment_aims(*[("forward", 40), ("left", 20), (unknown, 30), ("right", 20)] * 3)
    for start in range(0, 330, 110):
        labels = [found.names[found.labels[start + tick]] for tick in (20, 50, 75, 100)]
        assert labels == ["forward", "left", "unexplained", "right"]


@pytest.mark.parametrize(("rest", "begins"), [(0, True), (3, True), (9, True), (30, False)])
def test_a_short_rest_before_a_drive_is_no_part_of_it(rest: int, begins: bool) -> None:
    """No candidate rests: up to a second of it is before the beginning, and the lesson begins with `forward`."""
    waits = [("rest", rest)] if rest else []
    found = segment_aims(*waits, ("forward", 40), ("left", 20), ("forward", 40), ("right", 20))
    lesson = to_lesson(found).lesson
    first = [(each.state, each.next) for each in lesson.examples if each.state == "start"]
    assert first == ([("start", "forward")] if begins else [])


@pytest.mark.parametrize(("rest", "begins"), [(1, True), (0, False)])
def test_the_first_ticks_of_a_stick_that_moves_are_no_part_of_it(rest: int, begins: bool) -> None:
    """From rest, the stick goes the wrong way for three ticks; without the rest, the drive may have begun before."""
    waits = [("rest", rest)] if rest else []
    found = segment_aims(*waits, ("back", 3), ("forward", 40), ("left", 20), ("forward", 40), ("right", 20))
    assert found.list_spans(found.drive.episodes[0])[0].label == "unexplained"
    lesson = to_lesson(found).lesson
    assert [each.next for each in lesson.examples if each.state == "start"] == (["forward"] if begins else [])


def test_a_stick_that_overshoots_is_explained() -> None:
    """For two ticks after each switch, a hand without noise is a tenth of its way too far."""
    aims = [
        AIMS[name] for name, ticks in [("forward", 20), ("left", 20), ("right", 20)] * 4 for _ in range(ticks)
    ]
    commands, before = np.array(aims), np.array(aims)
    for tick in np.flatnonzero((np.diff(before, axis=0) != 0).any(axis=1)).tolist():
        commands[tick + 1 : tick + 3] += 0.1 * (before[tick + 1] - before[tick])
    commands += 0.01 * np.random.default_rng(0).standard_normal(commands.shape)
    x = np.arange(len(aims), dtype=np.float64)
    drive = make_drive(commands, {("x", None): x})
    found = segment(drive, make_candidates(Library(make_drive_kit(drive, MOVES)), drive))
    assert (found.labels < len(found.candidates)).all()
