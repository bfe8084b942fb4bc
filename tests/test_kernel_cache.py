"""Where compiled kernels go when the usual places cannot be written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from understudy import kernel_cache

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
    source = Path(kernel_cache.__file__).parent
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.delenv(kernel_cache.SETTING, raising=False)
    monkeypatch.setattr(kernel_cache, "_writable", lambda folder: beside if folder == source else home)
    kernel_cache.choose_cache_folder()
    named = os.environ.get(kernel_cache.SETTING)
    monkeypatch.delenv(kernel_cache.SETTING, raising=False)
    assert (named is not None and Path(named).parent == tmp_path) == temporary
    if named is not None:
        assert Path(named).stat().st_mode & 0o077 == 0


def test_a_folder_of_somebody_else_is_not_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    trap = tmp_path / f"understudy-kernels-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    assert kernel_cache._temporary() != trap


def test_a_named_folder_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(kernel_cache.SETTING, "/somewhere")
    kernel_cache.choose_cache_folder()
    assert os.environ[kernel_cache.SETTING] == "/somewhere"


@pytest.mark.parametrize("name", ["engine/_kernels.py", "sim/kernels/tick.py", "sim/sensing/sectors.py"])
def test_an_edit_of_kernels_or_records_is_noticed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).parent.mkdir(parents=True)
    monkeypatch.setattr(kernel_cache, "__file__", str(tmp_path / "compiling.py"))
    hashes = set()
    for text in ("one", "two"):
        (tmp_path / name).write_text(text)
        hashes.add(kernel_cache.hash_kernel_sources())
    assert len(hashes) == 2
