"""The modes of the old `understudy run`: every option applies in a mode or is refused there."""

from __future__ import annotations

from dataclasses import fields

import pytest

from understudy.ui.cli.old_spellings.old_running import NOT_OF_RECORDINGS, OF_WORLDS, OldRunOptions
from understudy.ui.cli.run_options import ReplayOptions, RobotRunOptions

BY_THEMSELVES = {"context", "replay", "recording", "robot", "team", "no_record", "file"}
"""Options that choose a mode, and what the new commands call them."""


@pytest.mark.parametrize(
    ("mode", "refused"),
    [
        (RobotRunOptions, {*OF_WORLDS, "scenario", "world"}),  # a world is refused beside a robot's file
        (ReplayOptions, {*NOT_OF_RECORDINGS}),
    ],
)
def test_every_option_applies_in_a_mode_or_is_refused(mode: type, refused: set[str]) -> None:
    every = {each.name for each in fields(OldRunOptions)}
    assert every - {each.name for each in fields(mode)} - BY_THEMSELVES == refused - BY_THEMSELVES
