"""The names that `understudy` hands out are there, and only when asked for."""

import ast
import inspect
import subprocess
import sys
from collections.abc import Iterator
from types import GenericAlias
from typing import Any

import pytest
from tests.sources import MODULES, ROOT, read_source

import understudy
from understudy import spi

SPI_NEEDS = ["understudy.entry_points", "understudy.errors", "understudy.spi"]
LAZY = pytest.mark.parametrize("module", [understudy, spi], ids=["understudy", "spi"])


@LAZY
def test_every_public_name_is_there(module: Any) -> None:
    assert len(module.__all__) > 40
    values = {name: getattr(module, name, None) for name in module.__all__}
    found = [name for name, value in values.items() if not (value.__doc__ or isinstance(value, GenericAlias))]
    assert not found, f"names that are not there, or have no docstring: {', '.join(found)}"


@LAZY
def test_an_unknown_name_is_an_attribute_error(module: Any) -> None:
    with pytest.raises(AttributeError, match="no attribute 'Understudies'"):
        module.Understudies  # noqa: B018


def test_only_public_names_and_modules_are_listed() -> None:
    names = [name for name in dir(understudy) if not name.startswith("_")]
    others = [name for name in names if f"understudy.{name}" not in sys.modules]
    assert sorted(understudy.__all__) == others


@pytest.mark.parametrize(("module", "others"), [("understudy", []), ("understudy.spi", SPI_NEEDS)])
def test_importing_fetches_nothing(module: str, others: list[str]) -> None:
    code = f"import {module}, sys; print(*sorted(n for n in sys.modules if n.startswith('understudy.')))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).split() == others


@LAZY
def test_what_type_checkers_see_is_what_programs_get(module: Any) -> None:
    imports = (
        each for each in ast.walk(ast.parse(inspect.getsource(module))) if isinstance(each, ast.ImportFrom)
    )
    seen = {each.names[0].asname: str(each.module) for each in imports if each.names[0].asname}
    assert seen == {name: f"understudy.{place}" for name, place in module._MODULES.items()}


@pytest.mark.parametrize("point", spi.EXTENSION_POINTS, ids=lambda point: point.group)
def test_an_extension_point_has_a_contract(point: spi.ExtensionPoint) -> None:
    assert inspect.getdoc(getattr(spi, point.contract))


def _functions(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    for each in body:
        if isinstance(each, ast.ClassDef) and not each.name.startswith("_"):
            yield from _functions(each.body)
        if isinstance(each, ast.FunctionDef) and (not each.name.startswith("_") or each.name == "__init__"):
            yield each


def _paths_only(function: ast.FunctionDef) -> Iterator[str]:
    """Parameters of a function that are to be given as a Path."""
    arguments = function.args
    for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
        kinds = set() if each.annotation is None else set(ast.unparse(each.annotation).split(" | "))
        if "Path" in kinds and "str" not in kinds:
            yield each.arg


SOURCE = ROOT / "src" / "understudy"
LIBRARY = [
    each for each in MODULES if each.is_relative_to(SOURCE) and "ui" not in each.relative_to(SOURCE).parts
]


@pytest.mark.xdist_group("sources")
def test_what_takes_a_path_takes_a_text() -> None:
    assert len(LIBRARY) > 100
    found = [
        f"{path.relative_to(SOURCE)}: {function.name}({name})"
        for path in LIBRARY
        for function in _functions(read_source(path).body)
        for name in _paths_only(function)
    ]
    assert found == []
