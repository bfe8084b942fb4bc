"""Tests marked `retrains` are skipped while their sources are those with which they passed last (`reproduced.json`)."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import msgspec
import pytest
from tests.lab.reproduced import TESTS, is_reproduced

from understudy_lab.sources import PACKAGES

REPORT = "UNDERSTUDY_RETRAIN"
"""The environment variable with the file to report to; if it is set, tests retrain whatever their sources are."""
REASON = "its sources are those with which it passed last (python -m tests.lab.renew --all retrains)"


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers",
        "retrains: teaches published rows again, if its sources are not those with which it passed last",
    )


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("retrains") and REPORT not in os.environ and is_reproduced(item.path):
        pytest.skip(REASON)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if any("retrains" in report.keywords for report in terminalreporter.stats.get("passed", ())):
        terminalreporter.write_line(
            "Published rows were retrained; python -m tests.lab.renew records that, until their sources change."
        )


def pytest_sessionfinish() -> None:
    """Report which files of ours were loaded, where they are asked for: all of them must be known as sources."""
    if REPORT in os.environ:
        loaded = {str(getattr(module, "__file__", None)) for module in list(sys.modules.values())}
        folders = (*PACKAGES, TESTS)
        ours = sorted(path for path in loaded if any(Path(path).is_relative_to(folder) for folder in folders))
        Path(os.environ[REPORT]).write_bytes(msgspec.json.encode(ours))
