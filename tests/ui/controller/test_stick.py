"""Sticks: what they command in tables to check by hand, and within limits whatever they do."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import SettingError
from understudy.model.behaviors import Behavior, Command
from understudy.runtime.body import Channel
from understudy.ui.controller.stick import AT_REST, StickLayout, StickPosition, lay_out_stick

FORAGER = (Channel("drive"), Channel("turn"), Channel("load"), Channel("unload"))
BEHAVIORS = {
    each.name: each
    for each in (
        Behavior("forward", Command(drive=0.5)),
        Behavior("backward", Command(drive=-0.25)),
        Behavior("left", Command(turn=1)),
        Behavior("load_food", Command(load=1)),
        Behavior("unload_food", Command(unload=1)),
    )
}


def lay_out() -> StickLayout:
    return lay_out_stick(FORAGER, BEHAVIORS)


COMMANDS = [  # right, up, held, drive, turn, load, unload
    (0.0, 1.0, (), 0.5, 0, 0, 0),  # as far as the fastest behavior
    (0.0, -1.0, (), -0.25, 0, 0, 0),
    (1.0, 0.0, (), 0, 0, 0, 0),  # no behavior turns right, so nothing could explain that
    (-1.0, 0.0, (), 0, 1, 0, 0),
    (0.0, 0.56, (), 0.25, 0, 0, 0),  # half of the way beyond the dead zone of 0.12
    (0.08, 0.08, (), 0, 0, 0, 0),  # within the dead zone
    (0.12, 0.0, (), 0, 0, 0, 0),
    (-0.6, 0.8, (), 0.4, 0.6, 0, 0),  # on the rim
    (0.0, 0.0, (0,), 0, 0, 1, 0),
    (0.0, 0.0, (1,), 0, 0, 0, 1),
    (0.0, 1.0, (0, 7), 0.5, 0, 1, 0),  # there is no behavior 7
]


@pytest.mark.parametrize(("right", "up", "held", "drive", "turn", "load", "unload"), COMMANDS)
def test_commands(
    right: float, up: float, held: tuple[int, ...], drive: float, turn: float, load: float, unload: float
) -> None:
    found = lay_out().make_command(StickPosition(right, up, frozenset(held)))
    assert found == pytest.approx([drive, turn, load, unload])


def test_ways_of_the_stick() -> None:
    assert lay_out().list_ways() == ["up", "down", "left"]
    assert lay_out_stick((Channel("force"),), {}).list_ways() == ["right", "left"]


def test_buttons_are_the_behaviors_that_leave_the_stick_alone() -> None:
    assert [each.name for each in lay_out().held] == ["load_food", "unload_food"]
    claims = {**BEHAVIORS, "claim_forward": Behavior("claim_forward", Command(drive=1, signal=2))}
    layout = lay_out_stick((*FORAGER, Channel("signal")), claims)
    assert [(each.name, dict(each.command)) for each in layout.held] == [
        ("load_food", {"load": 1}), ("unload_food", {"unload": 1}), ("signal 2", {"signal": 2}),
    ]  # fmt: skip


def test_channels_of_a_body_of_ones_own() -> None:
    """Without drive and turn, right is more of the first channel, and up of the second, to their limits."""
    force, action = (
        Channel("force", least=-10, most=20),
        Channel("action", rest=1, least=0, most=2, whole=True),
    )
    layout = lay_out_stick((force, action), {})
    assert layout.make_command(StickPosition(1, 0)) == [20, 1]
    assert layout.make_command(StickPosition(-1, 0)) == [-10, 1]
    assert layout.make_command(StickPosition(0, 1)) == [0, 2]
    assert layout.make_command(StickPosition(0, -0.8)) == [0, 0]
    assert layout.make_command(StickPosition(0, 0.4)) == [0, 1], "whole numbers only"
    assert lay_out_stick((force,), {}).up is None


def test_a_body_without_channels() -> None:
    with pytest.raises(SettingError, match="no channel that a stick can command"):
        lay_out_stick((Channel("skill"), Channel("issued")), {})


LEANS = st.floats(-1, 1)


@given(LEANS, LEANS)
def test_commands_stay_within_limits_and_point_where_the_stick_does(right: float, up: float) -> None:
    drive, turn, load, unload = lay_out().make_command(StickPosition(right, up))
    assert abs(drive) <= 0.5 + 1e-12
    assert abs(turn) <= 1 + 1e-12
    assert (load, unload) == (0, 0)
    assert drive * up >= 0
    assert turn * right <= 0


def test_at_rest() -> None:
    assert AT_REST.is_resting
    assert not StickPosition(held=frozenset({0})).is_resting
    assert lay_out().make_command(AT_REST) == [0, 0, 0, 0]
