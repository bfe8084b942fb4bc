"""House rules that no tool checks for us."""

import ast
import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

from understudy.jit.cache import KERNELS

ROOT = Path(__file__).parents[1]
MODULES = sorted((ROOT / "src").rglob("*.py"))
LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-bench.lock", "requirements-release.lock")
PIN = re.compile(r"^(?P<name>[A-Za-z0-9._-]+)==(?P<version>\S+)( ; .+)? \\$")
HASH = re.compile(r"^    --hash=sha256:[0-9a-f]{64}( \\)?$")
MAX_LINES = 500

NO_KERNELS = ("__init__", "dtypes", "seeing")
"""Files beside kernels that say what kernels find in memory."""

QUICK_TO_IMPORT = ("understudy", "understudy.model", "understudy.runtime.interpreter", "understudy.ui.cli")
SLOW = ("numba", "matplotlib", "textual")


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def imports(module: Path) -> set[str]:
    """The top-level names of all that a module imports, wherever in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add((node.module or "").partition(".")[0])
    return found


def is_kernels(module: Path) -> bool:
    """Whether a module is one of kernels."""
    return module.stem.endswith("kernels") or (
        module.parent.name == "kernels" and module.stem not in NO_KERNELS
    )


def exists(module: str) -> bool:
    """Whether a module is there; the design names some that are still to come."""
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def pins(lock: str) -> set[str]:
    return {line for line in (ROOT / lock).read_text().splitlines() if PIN.match(line)}


@pytest.mark.parametrize("module", MODULES, ids=relative)
def test_module_is_short(module: Path) -> None:
    assert len(module.read_text().splitlines()) < MAX_LINES


@pytest.mark.parametrize("module", MODULES, ids=relative)
def test_module_says_why_it_exists(module: Path) -> None:
    assert ast.get_docstring(ast.parse(module.read_text()))


@pytest.mark.parametrize("module", MODULES, ids=relative)
def test_only_the_package_jit_imports_numba(module: Path) -> None:
    """Ruff bans the import, but a `noqa` would silence it."""
    assert module.parent.name == "jit" or "numba" not in imports(module)


def test_kernels_are_bare() -> None:
    """They import other kernels, and what follows edits in those; else math and NumPy only."""
    kernels = {relative(module): imports(module) for module in MODULES if is_kernels(module)}
    bare = {"math", "numpy", "understudy", "typing", "__future__"}
    assert {name: found - bare for name, found in kernels.items() if not found <= bare} == {}


def test_kernels_import_nothing_whose_edits_go_unnoticed() -> None:
    """Of ours, they and the files of records import each other, and what compiled code does not contain."""
    keyed = [module for pattern in KERNELS for module in (ROOT / "src" / "understudy").glob(pattern)]
    allowed = {module.stem for module in keyed} | {"plain", "settings"}
    for module in keyed:
        found = re.findall(r"^from understudy(?:\.\w+)*\.(\w+) import", module.read_text(), re.MULTILINE)
        assert set(found) <= allowed, relative(module)


@pytest.mark.parametrize("module", [name for name in QUICK_TO_IMPORT if exists(name)])
def test_import_is_quick(module: str) -> None:
    """A robot or a command starts at once: what is slow to load waits until it is used."""
    code = f"import sys, {module}; print(*(name for name in {SLOW!r} if name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.parametrize("lock", LOCKS)
def test_lock_holds_pins_and_hashes_only(lock: str) -> None:
    """So no index address, no link, no path of the machine that locked it."""
    lines = (ROOT / lock).read_text().splitlines()
    assert [line for line in lines if not PIN.match(line) and not HASH.match(line)] == []


def test_each_lock_holds_the_one_before() -> None:
    """`make demo`, `make test` and `make bench` share one environment."""
    assert pins("requirements.lock") <= pins("requirements-dev.lock")
    assert pins("requirements-dev.lock") <= pins("requirements-bench.lock") & pins(
        "requirements-release.lock"
    )


def test_locks_hold_what_the_project_asks_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    locked = {pin.partition("==")[0].replace("_", "-") for pin in pins("requirements.lock")}
    asked = {re.split(r"[^\w.-]", need)[0].replace("_", "-").lower() for need in project["dependencies"]}
    assert asked <= locked


def test_no_uv_lock() -> None:
    """It records an index address."""
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert [path for path in tracked.stdout.splitlines() if Path(path).name == "uv.lock"] == []
