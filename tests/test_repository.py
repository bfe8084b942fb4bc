"""House rules that no tool checks for us."""

import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest
from tests.sources import MODULES, ROOT, read_source, relative

from understudy.jit.cache import KERNELS

LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-bench.lock", "requirements-release.lock")
PIN = re.compile(r"^(?P<name>[A-Za-z0-9._-]+)==(?P<version>\S+)( ; .+)? \\$")
HASH = re.compile(r"^    --hash=sha256:[0-9a-f]{64}( \\)?$")
MAX_LINES = 500

NO_KERNELS = ("__init__", "dtypes", "seeing")
"""Files beside kernels that say what kernels find in memory."""

QUICK_TO_IMPORT = ("understudy", "understudy.model", "understudy.runtime.interpreter", "understudy.ui.cli")
SLOW = ("numba", "matplotlib", "textual")


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


@pytest.mark.xdist_group("sources")
def test_modules_are_short_and_say_why_they_exist() -> None:
    assert len(MODULES) > 500
    found = []
    for module in MODULES:
        source = read_source(module)
        if source.lines >= MAX_LINES:
            found.append(f"{relative(module)} has {source.lines} lines; {MAX_LINES - 1} are allowed")
        if not source.docstring:
            found.append(f"{relative(module)} has no docstring")
    assert not found, "\n".join(found)


@pytest.mark.xdist_group("sources")
def test_only_the_package_jit_imports_numba() -> None:
    """Ruff bans the import, but a `noqa` would silence it."""
    others = [module for module in MODULES if module.parent.name != "jit"]
    found = [relative(module) for module in others if "numba" in read_source(module).imports]
    assert not found, "modules that import numba:\n" + "\n".join(found)


@pytest.mark.xdist_group("sources")
def test_kernels_are_bare() -> None:
    """They import other kernels, and what follows edits in those; else math and NumPy only."""
    kernels = {relative(module): read_source(module).imports for module in MODULES if is_kernels(module)}
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
