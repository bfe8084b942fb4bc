"""Which tests `make test` leaves to `make test-all`: by folder here; elsewhere by the markers `long` and `timed`."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

from understudy.jit.settings import ALL_PARTS, COMPILED, MODE, PARTS

os.environ.setdefault(MODE, COMPILED)  # none runs as plain Python at first, and compiles in the background
os.environ.setdefault(PARTS, ALL_PARTS)  # kernels are compiled once for the worlds of all tests

settings.register_profile(
    "untimed", deadline=None
)  # the first call may load kernels; the suite asserts no times
settings.load_profile("untimed")

ROOT = Path(__file__).parent
LONG = ("lab", "sim_mujoco")
"""Experiments, demos and benchmarks with scripted teachers; simulated physics."""
TIMED = ("browser", "peers", "robots")
"""Tests in which time is that of people, robots and other programs."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        folder = item.path.relative_to(ROOT).parts[0] if item.path.is_relative_to(ROOT) else ""
        if folder in LONG:
            item.add_marker(pytest.mark.long)
        elif folder in TIMED:
            item.add_marker(pytest.mark.timed)
