"""The sources on which a module depends: files that it imports, directly or not, and a hash of their code."""

from __future__ import annotations

import ast
import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import understudy
from understudy import spi

LABORATORY = Path(__file__).parent
PACKAGES = (LABORATORY, LABORATORY.with_name("understudy"))
"""The packages whose files are followed; of other packages there is the version (`describe_environment`)."""
BY_NAME = {"understudy.judging.baseline": "understudy_lab.tasks.forage_expert"}
"""The modules that another one finds without their names in its source, here by an entry point."""
PUBLIC = {module.__name__: module._MODULES for module in (understudy, spi)}
"""The modules that hand out names of other modules, which they import when a name is used."""
DECISIVE = ("llvmlite", "mujoco", "numba", "numpy", "scikit-learn", "scipy")
"""The packages of others that decide numbers in rows."""
SCENARIOS = "scenarios/*.toml"
DOTTED = re.compile(r"[a-z_]\w*(\.\w+)+")


@dataclass(frozen=True)
class SourceFile:
    """The code of a Python file, without comments, docstrings and layout; and names of modules that it may import."""

    code: str
    modules: frozenset[str]


def find_sources(roots: Iterable[Path], packages: Iterable[Path] = PACKAGES) -> set[Path]:
    """Return files and all that they depend on: what they import, and scenarios beside it.

    Imports within functions count, those only for type checkers do not.

    Parameters
    ----------
    roots
        The Python files to start from.
    packages
        The folders of packages whose modules are followed. Imports of other packages are ignored.

    Returns
    -------
    set of Path
        The files themselves, and all of the packages that they need.
    """
    above = {package.name: package.parent for package in packages}
    sources: set[Path] = set()
    modules: set[str] = set()
    left = list(roots)
    while left:
        path = left.pop()
        if path not in sources:
            sources.add(path)
            new = read_source(path).modules - modules
            modules |= new
            left += [each for module in new for each in _find_files(module, above)]
    return sources | {data for folder in {path.parent for path in sources} for data in folder.glob(SCENARIOS)}


def hash_sources(files: Iterable[Path]) -> str:
    """Hash names and contents of files; comments, docstrings and layout of Python files do not count."""
    ordered = sorted(files)
    folder = os.path.commonpath([path.parent for path in ordered])
    digest = sha256()
    for path in ordered:
        content = read_source(path).code.encode() if path.suffix == ".py" else path.read_bytes()
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + content + b"\0")
    return digest.hexdigest()[:16]


def describe_environment() -> str:
    """Name the versions of Python and of packages of others that decide numbers in rows.

    Neither the processor nor the operating system is named: rows are the same on all, but for their last digits.
    """
    parts = [f"Python {sys.version_info.major}.{sys.version_info.minor}"]
    for name in DECISIVE:
        try:
            parts.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            parts.append(f"no {name}")
    return ", ".join(parts)


def read_source(path: Path) -> SourceFile:
    """Read a Python file."""
    return _parse(path.read_bytes())


@cache
def _parse(content: bytes) -> SourceFile:
    tree = ast.parse(content)
    modules = frozenset(_list_modules(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [each for each in node.body if not _is_text(each)]
    return SourceFile(ast.dump(tree), modules)


def _list_modules(node: ast.AST) -> Iterator[str]:
    """Yield what may be names of modules: imports, but for those of type checkers, and texts that look like names."""
    within: Iterable[ast.AST] = ast.iter_child_nodes(node)
    if isinstance(node, ast.Import):
        yield from (each.name for each in node.names)
    elif isinstance(node, ast.ImportFrom):
        yield from (f"{node.module}.{each.name}" for each in node.names)
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, str) and DOTTED.fullmatch(node.value):
            yield node.value
    elif isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        within = node.orelse
    for child in within:
        yield from _list_modules(child)


def _find_files(name: str, above: dict[str, Path]) -> Iterator[Path]:
    """Yield the files of a module and of the packages that contain it, as far as the name is one of modules."""
    module, _, attribute = name.rpartition(".")
    if place := PUBLIC.get(module, {}).get(attribute):
        yield from _find_files(f"understudy.{place}", above)
    parts = name.split(".")
    if parts[0] not in above:
        return
    for count in range(1, len(parts) + 1):
        path = above[parts[0]].joinpath(*parts[:count])
        if path.with_suffix(".py").is_file():
            yield path.with_suffix(".py")
        elif (path / "__init__.py").is_file():
            yield path / "__init__.py"
        if also := BY_NAME.get(".".join(parts[:count])):
            yield from _find_files(also, above)


def _is_text(statement: ast.stmt) -> bool:
    """Return whether a statement is a mere text, such as a docstring."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
