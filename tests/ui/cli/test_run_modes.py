"""The modes of `understudy run`: one table says which options mean something in which, and none is left out."""

from __future__ import annotations

from dataclasses import fields
from inspect import signature

import pytest

from understudy.ui.cli.commands.run import OPTION_MODES, RunMode, run_behavior
from understudy.ui.cli.commands.run_replay import ReplayOptions
from understudy.ui.cli.commands.run_robot import RobotRunOptions
from understudy.ui.cli.commands.run_simulated import SimulatedRunOptions

OPTIONS_OF = {
    RunMode.SIMULATED: SimulatedRunOptions,
    RunMode.REPLAY: ReplayOptions,
    RunMode.ROBOTS: RobotRunOptions,
}


def test_the_table_has_every_option() -> None:
    assert set(OPTION_MODES) == set(signature(run_behavior).parameters) - {"context"}


@pytest.mark.parametrize("mode", RunMode)
def test_a_mode_is_given_what_means_something_in_it(mode: RunMode) -> None:
    meant = {option for option, modes in OPTION_MODES.items() if mode in modes}
    assert {field.name for field in fields(OPTIONS_OF[mode])} == meant
