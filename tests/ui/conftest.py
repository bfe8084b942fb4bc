"""What the tests of several user interfaces share: failing worlds, which are made once and copied."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

import pytest
from tests.ui.web.test_failing_worlds import make_failures


@pytest.fixture(scope="session")
def failures_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with failing worlds and the library in which they fail, to be copied."""
    folder = tmp_path_factory.mktemp("failing_worlds")
    make_failures(folder)
    return folder


@pytest.fixture
def library_with_failures(failures_folder: Path, tmp_path: Path) -> Path:
    """A library beside whose folder are worlds in which it fails."""
    copytree(failures_folder, tmp_path, dirs_exist_ok=True)
    return tmp_path / "library"
