"""Proposals of behaviors: commands that recur and that nothing explains are found with their values and spans."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.segmentation.drives import TICK_S, follow, make_drive

from understudy.addons.recordings.candidates import BehaviorCandidate
from understudy.addons.recordings.propose_behaviors import (
    describe_command,
    discover_behaviors,
    make_constant_candidate,
    propose_behaviors,
)
from understudy.addons.recordings.segment import UNEXPLAINED, segment
from understudy.errors import DefinitionError
from understudy.records.record import Record

Aim = tuple[float, float]
FORWARD, ARC, BACK = (0.8, 0.0), (0.3, 0.6), (-0.5, 0.0)
NAMES = {FORWARD: "forward", ARC: "arc", BACK: "back"}


def drive_by(*spans: tuple[Aim, int], noise: float = 0.02, gain: float = 0.6) -> Record:
    """A drive with an aim for so many ticks, one after the other."""
    aims = [aim for aim, ticks in spans for _ in range(ticks)]
    return make_drive(follow(aims, noise=noise, gain=gain), {("x", None): np.zeros(len(aims))})


def candidate(aim: Aim) -> BehaviorCandidate:
    return make_constant_candidate(NAMES[aim], dict(zip(("drive", "turn"), aim, strict=True)))


THRICE = [(FORWARD, 40), (ARC, 30), (BACK, 40)] * 3


@pytest.mark.parametrize("unknown", [FORWARD, ARC, BACK])
def test_the_behavior_that_is_missing_is_proposed(unknown: Aim) -> None:
    """Of three aims two are candidates; the third one explains about three times its ticks."""
    drive = drive_by(*THRICE)
    found = segment(drive, [candidate(each) for each in NAMES if each != unknown])
    (proposal,) = propose_behaviors(found)
    values = [proposal.command.get(each, 0.0) for each in ("drive", "turn")]
    assert values == pytest.approx(unknown, abs=0.02)
    ticks = sum(count for aim, count in THRICE if aim == unknown)
    assert proposal.seconds == pytest.approx(ticks * TICK_S, abs=1.0)
    assert len(proposal.spans) == 3
    assert all(each.label == UNEXPLAINED for each in proposal.spans)
    again = segment(drive, [*found.candidates, make_constant_candidate("found", proposal.command)])
    assert (again.labels == len(again.candidates)).mean() < 0.02, "it explains what was unexplained"


def test_two_are_proposed_the_longer_one_first() -> None:
    found = segment(drive_by(*THRICE), [candidate(BACK)])
    first, second = propose_behaviors(found)
    assert (first.command["drive"], second.command["drive"]) == pytest.approx((0.8, 0.3), abs=0.02)
    assert first.seconds > second.seconds


def test_nothing_is_proposed_where_all_is_explained() -> None:
    found = segment(drive_by(*THRICE), [candidate(each) for each in NAMES])
    assert propose_behaviors(found) == ()


def test_a_stick_that_wanders_is_no_behavior() -> None:
    """Commands that never come twice are unexplained, and stay so."""
    random = np.random.default_rng(3)
    wander = np.cumsum(random.uniform(-0.3, 0.3, (80, 2)), axis=0) + np.array([2.0, 3.0])
    known = drive_by((FORWARD, 60), (BACK, 60)).commands
    drive = make_drive(np.concatenate([known, wander]), {("x", None): np.zeros(200)})
    found = segment(drive, [candidate(FORWARD), candidate(BACK)])
    assert (found.labels[130:] == 2).all()
    assert propose_behaviors(found) == ()


def test_short_spans_do_not_count() -> None:
    """0.4 s of an aim are less than the shortest span that counts, however often they come."""
    drive = drive_by(*[(FORWARD, 30), (ARC, 4), (BACK, 30)] * 8, gain=1.0)
    found = segment(drive, [candidate(FORWARD), candidate(BACK)])
    assert propose_behaviors(found) == ()


@settings(max_examples=25, deadline=None)
@given(
    st.builds(
        lambda x, y, aims: [(x + dx, y + dy) for dx, dy in aims],
        st.integers(-4, 0),
        st.integers(-4, 0),
        st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=2, max_size=4, unique=True),
    ).filter(lambda aims: (0, 0) not in aims),
    st.sampled_from([0.7, 1.0]),
)
def test_all_are_discovered_from_nothing(steps: list[tuple[int, int]], gain: float) -> None:
    """Aims on a grid of 0.25, at most 1 apart in each command, are found without any candidate, if the driver is fast.

    Of (1, 0.5) and (-1, 0.5) none is found: a fault that is still there.
    """
    assert discover(steps, gain) == set(steps)


@pytest.mark.parametrize(
    "steps", [[(4, 0), (0, 4)], [(-2, -1), (2, 3), (0, -4)], [(1, 1), (-1, 1), (3, -2), (0, 2)]]
)
def test_most_are_discovered_of_a_slow_driver(steps: list[tuple[int, int]]) -> None:
    """With a gain of 0.4, of two aims that are more than 1.2 apart in one command, one or both may be missed."""
    assert discover(steps, 0.4) == set(steps)


def discover(steps: list[tuple[int, int]], gain: float) -> set[tuple[int, ...]]:
    """The aims, in steps of 0.25, that are discovered where each lasts 4 s, three times in turn."""
    aims = [(0.25 * x, 0.25 * y) for x, y in steps]
    drive = drive_by(*[(aim, 40) for aim in aims] * 3, noise=0.01, gain=gain)
    return {
        tuple(round(4 * each.command.get(name, 0.0)) for name in ("drive", "turn"))
        for each in discover_behaviors(drive)
    }


def test_a_command_in_words() -> None:
    channels = drive_by((FORWARD, 2)).channels
    assert describe_command(channels, {"drive": 0.6, "turn": -0.2}) == "drive 0.6, turn -0.2"
    assert describe_command(channels, {}) == "at rest"


@pytest.mark.parametrize("name", ["unexplained", "two words", "", "goto(ball)"])
def test_what_cannot_be_a_name(name: str) -> None:
    with pytest.raises(DefinitionError, match="choose a name of letters"):
        make_constant_candidate(name, {"drive": 1.0})
