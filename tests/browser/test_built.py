"""The built page that is committed is what its source builds."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from understudy.ui.web import app

SOURCE = Path(__file__).parents[2] / "page"
BUILT = Path(app.__file__).parent / "static"


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_page_is_what_its_source_builds(tmp_path: Path) -> None:
    npm = shutil.which("npm") or ""
    if not npm:
        reason = "there is no npm, which builds the page"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    page = tmp_path / "page"
    shutil.copytree(SOURCE, page, ignore=shutil.ignore_patterns("node_modules"))
    for command in (
        [npm, "ci", "--no-audit", "--no-fund"],
        [npm, "test"],
        [npm, "run", "build", "--", "--outDir", str(tmp_path / "built"), "--emptyOutDir"],
    ):
        done = subprocess.run(command, cwd=page, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    assert files(tmp_path / "built") == files(BUILT)
