"""The modules of the source, each read and parsed once for all house rules."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
MODULES = sorted((ROOT / "src").rglob("*.py"))
FUNCTIONS = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Source:
    """What house rules ask of a module; the whole tree would take much memory."""

    lines: int
    docstring: str | None
    imports: frozenset[str]
    """The top-level names of all that it imports, wherever in it."""
    body: list[ast.stmt]
    """Its statements, but functions without theirs."""


@cache
def read_source(module: Path) -> Source:
    """Parse a module."""
    text = module.read_text(encoding="utf-8")
    tree = ast.parse(text)
    docstring, imports, functions = ast.get_docstring(tree), set[str](), []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            imports.add((node.module or "").partition(".")[0])
        elif isinstance(node, FUNCTIONS):
            functions.append(node)
    for function in functions:
        function.body = []
    return Source(len(text.splitlines()), docstring, frozenset(imports), tree.body)


def relative(path: Path) -> str:
    """Return the place of a file in the repository."""
    return path.relative_to(ROOT).as_posix()
