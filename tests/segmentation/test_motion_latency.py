"""Latency between commands and motion: known delays are found from readings that follow the commands."""

from __future__ import annotations

from math import tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.segmentation.drives import TICK_S, make_drive

from understudy.addons.recordings.motion_latency import estimate_motion_latencies
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Categorical, Column, Continuous, Toroidal
from understudy.runtime.body import Channel, Reading

DRIVE = (Channel("drive"),)


def make_commands(seed: int, ticks: int = 400) -> Column:
    """A stick that holds a random position for half a second at a time."""
    return np.repeat(np.random.default_rng(seed).uniform(-1, 1, -(-ticks // 5)), 5)[:ticks]


def move(commands: Column, late: int) -> Column:
    """The place of a robot that moves at a tick as it was commanded so many ticks before."""
    delayed = np.concatenate([np.zeros(late), commands[: len(commands) - late]])
    return np.concatenate([[0.0], np.cumsum(delayed[:-1]) * TICK_S])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 12), st.integers(0, 99), st.sampled_from([1.0, -2.0]))
def test_a_known_delay_is_found(late: int, seed: int, factor: float) -> None:
    commands = make_commands(seed)
    place = factor * move(commands, late) + 1e-3 * np.random.default_rng(seed).standard_normal(400)
    drive = make_drive(commands[:, None], {("range", "wall"): place}, channels=DRIVE)
    (found,) = estimate_motion_latencies(drive)
    assert (found.channel, found.reading) == ("drive", "range(wall)")
    assert found.seconds == pytest.approx(late * TICK_S, abs=0.5 * TICK_S)
    assert np.sign(found.correlation) == np.sign(factor)


def test_the_reading_that_follows_most_closely_counts() -> None:
    """The turn is told by a heading that goes round, the drive by the place."""
    drive, turn = make_commands(1), make_commands(2)
    heading = move(3 * turn, 2)
    values: dict[ReadingKey, Column] = {
        ("x", None): np.cumsum(np.append(0.0, np.diff(move(drive, 3)) * np.cos(heading[:-1]))),
        ("y", None): np.cumsum(np.append(0.0, np.diff(move(drive, 3)) * np.sin(heading[:-1]))),
        ("heading", None): heading % tau,
        ("noise", None): np.random.default_rng(0).standard_normal(400),
        ("ready", None): (drive > 0).astype(float),
    }
    readings = (
        Reading("x", Continuous()),
        Reading("y", Continuous()),
        Reading("heading", Toroidal(tau)),
        Reading("noise", Continuous()),
        Reading("ready", Categorical(("no", "yes"))),
    )
    found = estimate_motion_latencies(
        make_drive(np.column_stack([drive, turn]), values, readings=readings, lengths=(150, 250))
    )
    assert [(each.channel, each.reading) for each in found] == [("drive", "place"), ("turn", "heading")]
    assert [each.seconds for each in found] == pytest.approx([0.3, 0.2], abs=0.05)


def test_a_speed_is_compared_as_it_is() -> None:
    """A reading in the unit of the channel is a speed already: it follows two ticks later."""
    commands = make_commands(4)
    speed = np.concatenate([[0.0, 0.0], commands[:-2]])
    drive = make_drive(
        commands[:, None],
        {("speed", None): speed},
        readings=[Reading("speed", Continuous(), unit="m/s")],
        channels=[Channel("drive", unit="m/s")],
    )
    (found,) = estimate_motion_latencies(drive)
    assert found.seconds == pytest.approx(0.2, abs=0.01)


def test_no_latency_without_a_reading_that_follows() -> None:
    noise = np.random.default_rng(5).standard_normal(400)
    assert (
        estimate_motion_latencies(make_drive(make_commands(5)[:, None], {("x", "a"): noise}, channels=DRIVE))
        == ()
    )
    short = make_drive(make_commands(5, 20)[:, None], {("x", "a"): noise[:20]}, channels=DRIVE)
    assert estimate_motion_latencies(short) == ()
