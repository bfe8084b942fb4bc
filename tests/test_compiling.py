"""Where compiled kernels go when the usual places cannot be written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from understudy import compiling

PLACES = [  # what can be written: beside the source, at home -> whether a temporary folder is named
    (True, True, False),
    (True, False, False),
    (False, True, False),
    (False, False, True),
]


@pytest.mark.parametrize(("beside", "home", "temporary"), PLACES)
def test_place(
    beside: bool, home: bool, temporary: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = Path(compiling.__file__).parent
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.delenv(compiling.SETTING, raising=False)
    monkeypatch.setattr(compiling, "_writable", lambda folder: beside if folder == source else home)
    compiling.find_cache()
    named = os.environ.get(compiling.SETTING)
    monkeypatch.delenv(compiling.SETTING, raising=False)
    assert (named is not None and Path(named).parent == tmp_path) == temporary
    if named is not None:
        assert Path(named).stat().st_mode & 0o077 == 0


def test_a_folder_of_somebody_else_is_not_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    trap = tmp_path / f"understudy-kernels-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    assert compiling._temporary() != trap


def test_a_named_folder_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(compiling.SETTING, "/somewhere")
    compiling.find_cache()
    assert os.environ[compiling.SETTING] == "/somewhere"


@pytest.mark.parametrize("name", ["_kernels.py", "_step_kernels.py", *compiling.LAYOUTS])
def test_an_edit_of_kernels_or_records_is_noticed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "worlds").mkdir()
    monkeypatch.setattr(compiling, "__file__", str(tmp_path / "compiling.py"))
    hashes = set()
    for text in ("one", "two"):
        (tmp_path / "worlds" / name).write_text(text)
        hashes.add(compiling.kernel_sources("worlds"))
    assert len(hashes) == 2
