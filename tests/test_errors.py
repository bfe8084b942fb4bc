"""Errors come whole out of another process, where experiments work."""

from __future__ import annotations

from copy import copy

import pytest

from understudy.errors import FileError, UnderstudyError, UnknownName
from understudy.extras import ExtraMissing

MADE = [
    UnknownName(what="reading", name="x", where="here", known=["y"]),
    FileError(path="a.toml", place="b", problem="c", remedy="d"),
    ExtraMissing(what="a recording", extra="ros2"),
]


@pytest.mark.parametrize("error", MADE, ids=lambda error: type(error).__name__)
def test_errors_come_whole_out_of_another_process(error: UnderstudyError) -> None:
    again = copy(error)  # as pickle does it
    assert type(again) is type(error)
    assert (str(again), vars(again)) == (str(error), vars(error))


SUGGESTED: list[tuple[str, tuple[str, ...], str]] = [
    ("forwrad", ("forward", "left"), "; did you mean 'forward'? It has forward and left"),
    ("FORWARD", ("forward", "left"), "; did you mean 'forward'? It has forward and left"),
    ("fly", ("forward", "left"), "; it has forward and left"),
    ("fly", (), "; it has none"),
    ("", ("forward",), "; it has forward"),
]


@pytest.mark.parametrize(("name", "known", "said"), SUGGESTED)
def test_an_unknown_name_comes_with_one_that_may_be_meant(
    name: str, known: tuple[str, ...], said: str
) -> None:
    error = UnknownName(what="behavior", name=name, where="the library", known=known)
    assert str(error) == f"the library has no behavior {name!r}{said}"
