"""The modes of `understudy run`: each has a class of the options that mean something in it, and none is left out."""

from __future__ import annotations

from inspect import signature

from understudy.ui.cli.commands.run import OPTIONS, run_behavior


def test_every_option_means_something_in_a_mode() -> None:
    assert set(OPTIONS) == set(signature(run_behavior).parameters) - {"context"}
