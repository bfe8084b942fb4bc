"""The names that `understudy` hands out are there, and only when asked for."""

import ast
import inspect
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


def test_what_type_checkers_see_is_what_programs_get() -> None:
    imports = (
        each
        for each in ast.walk(ast.parse(inspect.getsource(understudy)))
        if isinstance(each, ast.ImportFrom)
    )
    seen = {each.names[0].asname: str(each.module) for each in imports if each.names[0].asname}
    assert seen == {name: f"understudy.{module}" for name, module in understudy._MODULES.items()}
