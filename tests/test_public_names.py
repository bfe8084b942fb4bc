"""The names that `understudy` hands out are there, and only when asked for."""

import subprocess
import sys

import pytest

import understudy


@pytest.mark.parametrize("name", understudy.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(understudy, name).__doc__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Understudies'"):
        understudy.Understudies  # noqa: B018


def test_importing_fetches_nothing() -> None:
    code = "import understudy, sys; print(sorted(n for n in sys.modules if n.startswith('understudy.')))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"
