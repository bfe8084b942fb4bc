"""Which tests `make test` leaves to `make test-rest`: by folder here; elsewhere by the markers `long` and `timed`."""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
from functools import cache
from pathlib import Path

import pytest
from hypothesis import settings

from understudy.jit.settings import ALL_PARTS, COMPILED, MODE, PARTS

gc.disable()  # until the tests are collected: what that makes stays, and is searched through again and again

os.environ.setdefault(MODE, COMPILED)  # none runs as plain Python at first, and compiles in the background
os.environ.setdefault(PARTS, ALL_PARTS)  # kernels are compiled once for the worlds of all tests

# The first call may load kernels, and the suite asserts no times. A change is judged by the same cases each time; a
# person's runs draw others, and what fails once is kept and tried first.
settings.register_profile("person", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "person")

ROOT = Path(__file__).parent
LONG = ("browser", "lab", "peers", "sim_mujoco")
"""Folders of tests of the page in a browser, of experiments and demos, of compiled peers, and of simulated physics."""
REST = ("long", "timed")
"""The markers of tests that are left to `make test-rest`."""
PR_SET_PDEATHSIG = 1


def pytest_configure(config: pytest.Config) -> None:
    """Let the kernel kill a worker of pytest-xdist whose parent was killed (Linux)."""
    if sys.platform == "linux" and hasattr(config, "workerinput"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Import none of the long tests where none is asked for, and only files with some where no others are asked for."""
    if "not long" in config.option.markexpr:
        return True if collection_path.parent == ROOT and collection_path.name in LONG else None
    if "long or timed" in config.option.markexpr and collection_path.suffix == ".py":
        return None if is_in_long_folder(collection_path) or names_a_marker(collection_path) else True
    return None


def is_in_long_folder(path: Path) -> bool:
    """Whether all tests of a file are long."""
    return path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in LONG


@cache
def names_a_marker(path: Path) -> bool:
    """Whether a file marks tests as long or timed."""
    return any(f"mark.{name}" in path.read_text(encoding="utf-8") for name in REST)


def pytest_collection_finish() -> None:
    """Collect no garbage among what is there to stay."""
    gc.collect()
    gc.freeze()
    gc.enable()


def pytest_unconfigure() -> None:
    """Let libraries find at the end what they made."""
    gc.unfreeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if is_in_long_folder(item.path):
            item.add_marker(pytest.mark.long)
        elif any(map(item.get_closest_marker, REST)) and not names_a_marker(item.path):
            raise pytest.UsageError(
                f"{item.nodeid}: write pytest.mark.long or pytest.mark.timed in its file, by which it is found"
            )


@pytest.fixture(autouse=True)
def without_scores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Begin no runs in new worlds after a press: they take processors, and end at any moment."""
    keeper = sys.modules.get("understudy.ui.controller.score_keeper")
    if keeper is not None:
        monkeypatch.setattr(keeper, "begin_in_thread", lambda work: None)
        monkeypatch.setattr(keeper.LessonScoreKeeper, "run_beside", lambda keeper, beside: None)
