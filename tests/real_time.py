"""Where tests sleep, compare the real time, and are marked as timed; found in their source."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeAlias

from tests.sources import FUNCTIONS, ROOT

TESTS = ROOT / "tests"
Offence: TypeAlias = tuple[int, str]
"""The line, and what it says."""
READS = {"monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns", "time", "time_ns"}
"""What reads the real time, of the module `time`."""
MENTIONS = re.compile(r"\bsleep\b|\bmonotonic|\bperf_counter|\btime\b|\bREAL_TIME\b|\btimed\b")
ARITHMETIC = {"abs", "float", "max", "min", "round", "sum"}
SLEEP_IN_TEXT = re.compile(r"\bsleep\(")


@cache
def read_tests() -> dict[Path, str]:
    """The text of all modules of tests and of what they share."""
    return {path: path.read_text(encoding="utf-8") for path in sorted(TESTS.rglob("*.py"))}


@dataclass(frozen=True)
class Names:
    """What a module calls the things of real time."""

    modules: frozenset[str]
    sleeps: frozenset[str]
    reads: frozenset[str]

    @classmethod
    def of(cls, tree: ast.Module) -> Names:
        """Find the names in the imports, wherever in the module."""
        modules, sleeps, reads = set[str](), set[str](), set[str]()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                modules |= {
                    each.asname or each.name for each in node.names if each.name in ("time", "asyncio")
                }
            elif isinstance(node, ast.ImportFrom) and node.module in ("time", "asyncio", "understudy.clock"):
                for each in node.names:
                    called = each.asname or each.name
                    if each.name == "sleep":
                        sleeps.add(called)
                    elif each.name == "REAL_TIME":
                        modules.add(called)
                        reads.add(called)
                    elif node.module == "time" and each.name in READS:
                        reads.add(called)
        return cls(frozenset(modules), frozenset(sleeps), frozenset(reads))

    def is_sleep(self, node: ast.AST) -> bool:
        """Whether a node sleeps, or is a text that a child process or a shell sleeps by; no time at all is none."""
        if isinstance(node, ast.Call):
            nothing = (
                len(node.args) == 1 and isinstance(node.args[0], ast.Constant) and node.args[0].value == 0
            )
            return self._is_of(node.func, {"sleep"}, self.sleeps) and not nothing
        return (
            isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and bool(SLEEP_IN_TEXT.search(node.value))
        )

    def is_read(self, node: ast.AST) -> bool:
        """Whether a node is a call for the real time."""
        return isinstance(node, ast.Call) and self._is_of(node.func, READS, self.reads)

    def _is_of(self, function: ast.expr, attributes: set[str], names: frozenset[str]) -> bool:
        if isinstance(function, ast.Attribute):
            owner = function.value
            return function.attr in attributes and isinstance(owner, ast.Name) and owner.id in self.modules
        return isinstance(function, ast.Name) and function.id in names


def find_sleeps(path: Path) -> list[Offence]:
    """Find where a module sleeps outside timed tests, and outside what only these use."""
    if not re.search(r"\bsleep\b", read_tests()[path]):
        return []
    tree = _parse(path)
    names, exempt = Names.of(tree), _list_docstrings(tree)
    return [
        (node.lineno, ast.unparse(node))
        for statement in _list_untimed(path, tree)
        for node in ast.walk(statement)
        if isinstance(node, ast.expr) and names.is_sleep(node) and node not in exempt
    ]


def find_comparisons(path: Path) -> list[Offence]:
    """Find where a module compares the real time, read there or kept before, outside timed tests and their parts."""
    tree = _parse(path)
    names = Names.of(tree)
    if not names.modules and not names.reads:
        return []
    attributes = _list_kept(tree, names, ast.Attribute)
    return [
        (node.lineno, ast.unparse(node))
        for statement in _list_untimed(path, tree)
        for kept in [attributes | _list_kept(statement, names, ast.Name)]
        for node in ast.walk(statement)
        if isinstance(node, ast.Compare)
        and any(_is_time(each, names, kept) for each in (node.left, *node.comparators))
    ]


def find_marks(path: Path) -> list[Offence]:
    """Find where a module is said to be timed otherwise than by the decorator of a test function."""
    if "timed" not in read_tests()[path]:
        return []
    tree = _parse(path)
    right = {id(each) for test in _list_functions(tree) if _is_test(test) for each in test.decorator_list}
    return [
        (node.lineno, ast.unparse(node))
        for node in ast.walk(tree)
        if (isinstance(node, ast.expr) and _is_timed(node) and id(node) not in right)
        or (isinstance(node, ast.Call) and any(_is_word(each) for each in node.args))
    ]


def list_timed(path: Path) -> list[str]:
    """List the test functions of a module that are timed: by a decorator of their own, or as all of the module."""
    if "timed" not in read_tests()[path]:
        return []
    tree = _parse(path)
    tests = [test for test in _list_functions(tree) if _is_test(test)]
    marks = [each for each in tree.body if isinstance(each, ast.Assign) and _mentions_timed(each)]
    return [test.name for test in tests if marks or any(map(_mentions_timed, test.decorator_list))]


def list_importers(module: str) -> list[Path]:
    """List the modules of tests that import one, such as `tests.robots.rover`, or that name its file to start it."""
    package, _, name = module.rpartition(".")
    return [
        path
        for path, words in _list_words().items()
        if words & {module, f"{package}:{name}", f"{name}.py"} and name_of(path) != module
    ]


def name_of(path: Path) -> str:
    """Return the name that a module of tests is imported by."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


@cache
def _parse(path: Path) -> ast.Module:
    text = read_tests()[path]
    return ast.parse(text if MENTIONS.search(text) else "")


def _list_functions(tree: ast.Module) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    yield from (node for node in ast.walk(tree) if isinstance(node, FUNCTIONS))


def _list_docstrings(tree: ast.Module) -> set[ast.expr]:
    texts = (node.value for node in ast.walk(tree) if isinstance(node, ast.Expr))
    return {each for each in texts if isinstance(each, ast.Constant)}


def _is_test(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return function.name.startswith("test_")


def _is_timed(node: ast.AST) -> bool:
    mark = node.value if isinstance(node, ast.Attribute) and node.attr == "timed" else None
    return "mark" in (getattr(mark, "attr", None), getattr(mark, "id", None))


def _is_word(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value == "timed"


def _mentions_timed(node: ast.AST) -> bool:
    return any(map(_is_timed, ast.walk(node)))


def _is_time(node: ast.AST, names: Names, kept: set[str]) -> bool:
    """Whether a value is the real time, or made from it by arithmetic; what other calls make of it is not."""
    if names.is_read(node) or _name(node) in kept:
        return True
    if isinstance(node, ast.Call):
        return _name(node.func) in ARITHMETIC and any(_is_time(each, names, kept) for each in node.args)
    return any(_is_time(each, names, kept) for each in ast.iter_child_nodes(node))


def _name(node: ast.AST) -> str | None:
    if isinstance(node, ast.Attribute):
        return f".{node.attr}"
    return node.id if isinstance(node, ast.Name) else None


def _list_kept(tree: ast.AST, names: Names, sort: type[ast.Name] | type[ast.Attribute]) -> set[str]:
    """List the names, or the attributes, that keep the real time, or what was made from it by arithmetic."""
    pairs = [
        (target, value)
        for node in ast.walk(tree)
        for target, value in _list_assignments(node)
        if isinstance(target, sort)
    ]
    kept, before = set[str](), -1
    while len(kept) > before:
        before = len(kept)
        kept |= {str(_name(target)) for target, value in pairs if _is_time(value, names, kept)}
    return kept


def _list_assignments(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    """List what a node assigns, or appends, to what."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "append":
        yield from ((node.func.value, each) for each in node.args)
    if not isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign | ast.NamedExpr) or node.value is None:
        return
    for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            yield from zip(target.elts, node.value.elts, strict=False)
        else:
            yield target, node.value


def _list_untimed(path: Path, tree: ast.Module) -> list[ast.stmt]:
    """List the top-level statements of a module that are neither timed tests nor used by these alone."""
    timed: set[ast.stmt] = {
        each for each in tree.body if isinstance(each, FUNCTIONS) and any(map(_is_timed, each.decorator_list))
    }
    if not timed:
        return tree.body
    users: dict[str, set[ast.stmt]] = {}
    for statement in tree.body:
        for name in {name for node in ast.walk(statement) for name in _list_uses(node)}:
            if name != getattr(statement, "name", None):
                users.setdefault(name, set()).add(statement)
    others = "\n".join(read_tests()[each] for each in list_importers(name_of(path)))
    parts = [
        part
        for part in tree.body
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        and not part.name.startswith("test_")
        and part.name in users
        and not re.search(rf"\b{part.name}\b", others)
    ]
    before = 0
    while before < len(timed):
        before = len(timed)
        timed |= {part for part in parts if users[part.name] <= timed}
    return [each for each in tree.body if each not in timed]


@cache
def _list_words() -> dict[Path, set[str]]:
    """List what each module has of names of modules, of names imported from a package, and of names of files."""
    found = {}
    for path, text in read_tests().items():
        words = set(re.findall(r"\btests(?:\.\w+)+|\b\w+\.py\b", text))
        for package, names in re.findall(r"from (tests[\w.]*) import ([^(\n]+|\([^)]+\))", text):
            words |= {f"{package}:{name}" for name in re.findall(r"\w+", names)}
        found[path] = words
    return found


def _list_uses(node: ast.AST) -> Iterator[str]:
    """The names that a node uses: as names, as fixtures, or as texts that name fixtures."""
    if isinstance(node, ast.Name):
        yield node.id
    elif isinstance(node, ast.arg):
        yield node.arg
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
