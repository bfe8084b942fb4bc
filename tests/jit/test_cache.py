"""Files of compiled kernels: where they are, that they are whole or not there, and that their number stays bounded."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path
from time import time
from typing import Any

import pytest
from tests.processes import end_with_tests

from understudy.jit import cache
from understudy.jit.stored import PROCESSOR_KINDS, find_processor_kind

KEY = "0" * 64


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for compiled kernels, named in the environment."""
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "kernels"))
    monkeypatch.setattr(cache, "SHIPPED", tmp_path / "shipped")
    cache._warn.cache_clear()
    return tmp_path / "kernels"


def test_a_kernel_is_read_as_written(folder: Path) -> None:
    assert cache.read_kernel(KEY) is None
    cache.write_kernel(KEY, b"code")
    assert cache.read_kernel(KEY) == b"code"
    assert [path.name for path in folder.iterdir()] == [KEY + cache.SUFFIX]


@pytest.mark.parametrize(
    "spoil", [lambda whole: whole[:-1], lambda whole: whole[:-1] + b"?", lambda whole: b""]
)
def test_a_spoiled_file_is_not_used(folder: Path, spoil: Any) -> None:
    cache.write_kernel(KEY, b"code")
    path = folder / (KEY + cache.SUFFIX)
    path.write_bytes(spoil(path.read_bytes()))
    assert cache.read_kernel(KEY) is None


def test_shipped_kernels_are_found(folder: Path) -> None:
    cache.write_kernel(KEY, b"code")
    folder.rename(cache.SHIPPED)
    assert cache.read_kernel(KEY) == b"code"


def test_a_folder_that_cannot_be_made_is_named_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    cache._warn.cache_clear()
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "file" / "kernels"))
    for _ in range(2):
        cache.write_kernel(KEY, b"code")
    assert cache.read_kernel(KEY) is None
    assert [(record.levelno, record.getMessage()) for record in caplog.records] == [
        (
            logging.WARNING,
            f"Compiled kernels are not kept (Not a directory: {tmp_path / 'file' / 'kernels'}); "
            "set UNDERSTUDY_KERNEL_CACHE to a folder that can be written to",
        )
    ]


def test_a_full_disk_leaves_nothing_half_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def refuse(*_: Any) -> None:
        raise OSError(28, "No space left on device", "kernel")

    monkeypatch.setattr(Path, "replace", refuse)
    cache.write_kernel(KEY, b"code")
    assert list(folder.iterdir()) == []
    assert len(caplog.records) == 1


def test_those_not_used_for_longest_are_deleted(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "MOST_BYTES", 3 * (32 + len(zlib.compress(b"code", 1))))
    now = time()
    for number in range(3):
        cache.write_kernel(str(number), b"code")
        os.utime(folder / f"{number}{cache.SUFFIX}", (now - 100 + number, now - 100 + number))
    cache.read_kernel("0")
    cache.write_kernel("3", b"code")
    assert {path.stem for path in folder.iterdir()} == {"0", "2", "3"}


@pytest.mark.parametrize(("age_s", "stays"), [(60, True), (2 * cache.HALF_WRITTEN_S, False)])
def test_what_a_killed_process_left_is_deleted_later(folder: Path, age_s: float, stays: bool) -> None:
    folder.mkdir()
    left = folder / ".left"
    left.write_bytes(b"")
    os.utime(left, (time() - age_s, time() - age_s))
    cache.write_kernel(KEY, b"code")
    assert left.exists() == stays


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills with fork and SIGKILL")
def test_a_process_killed_while_it_writes_leaves_whole_files(folder: Path) -> None:
    """Killed before or after any operation of two writes, it leaves no file, or a whole one."""
    code = (
        "import os\nfrom tests.killed_at_operation import kill_self_after\nfrom understudy.jit import cache\n"
        "found = []\n"
        "cache.write_kernel('0', b'what is imported late is imported here')\n"
        "for calls in range(500):\n"
        "    if (child := os.fork()) == 0:\n"
        "        kill_self_after(calls)\n"
        "        cache.write_kernel('1', os.urandom(30_000))\n"
        "        cache.write_kernel('1', os.urandom(30_000))\n"
        "        os._exit(0)\n"
        "    _, status = os.waitpid(child, 0)\n"
        "    found.append(cache.read_kernel('1'))\n"
        "    assert found[-1] is None or len(found[-1]) == 30_000, calls\n"
        "    assert found[-1] is not None or not (cache.find_cache_folder() / ('1' + cache.SUFFIX)).exists(), calls\n"
        "    if status == 0: break\n"
        "    for left in cache.find_cache_folder().glob('.*'): left.unlink()\n"
        "assert found[0] is None and found[-1] is not None and 20 < len(found) < 500, len(found)\n"
    )
    root = Path(__file__).parents[2]
    given = {**os.environ, "PYTHONPATH": os.pathsep.join((str(root), *sys.path))}
    assert (
        subprocess.run(end_with_tests([sys.executable, "-c", code]), env=given, check=False).returncode == 0
    )
    assert folder.exists()


def test_two_processes_that_write_do_not_harm_each_other(folder: Path) -> None:
    code = (
        "import sys\nfrom understudy.jit import cache\n"
        "for _ in range(40):\n"
        "    cache.write_kernel('1', sys.argv[1].encode() * 300_000)\n"
        "    found = cache.read_kernel('1')\n"
        "    assert found in (b'a' * 300_000, b'b' * 300_000)\n"
    )
    writers = [subprocess.Popen(end_with_tests([sys.executable, "-c", code, letter])) for letter in "ab"]
    assert [writer.wait() for writer in writers] == [0, 0]


AVX2 = set(PROCESSOR_KINDS["x86_64"].features)
KINDS = [  # machine, what a processor can do -> the kind whose code it runs
    ("x86_64", AVX2 | {"avx512f"}, "x86-64-v3"),
    ("x86_64", AVX2 - {"fma"}, None),
    ("aarch64", {"neon"}, "generic"),
    ("riscv64", {"m"}, None),
]


@pytest.mark.parametrize(("machine", "features", "expected"), KINDS)
def test_shipped_kernels_are_for_processors_that_can_run_them(
    machine: str, features: set[str], expected: str | None
) -> None:
    kind = find_processor_kind(features, machine)
    assert (kind and kind.name) == expected


PLACES = [  # what can be written at home, what is named -> the folder, from the user's home
    (True, None, ".cache/understudy/kernels"),
    (True, "named", "named"),
    (False, "named", "named"),
    (False, None, None),
]


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="caches are elsewhere")
@pytest.mark.parametrize(("home", "named", "found"), PLACES)
def test_place(
    home: bool, named: str | None, found: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(cache, "_make_temporary", cache._make_temporary.__wrapped__)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv(cache.SETTING, raising=False)
    if named:
        monkeypatch.setenv(cache.SETTING, str(tmp_path / named))
    monkeypatch.setattr(cache, "_is_writable", lambda folder: home)
    folder = cache.find_cache_folder()
    if found is not None:
        assert folder == tmp_path / found
    else:
        assert folder.parent == Path(tempfile.gettempdir())
        assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="users have no numbers")
def test_a_folder_of_another_user_is_not_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    trap = tmp_path / f"understudy-kernels-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    assert cache._make_temporary.__wrapped__() != trap


@pytest.mark.parametrize("name", ["engine/_kernels.py", "sim/kernels/tick.py", "sim/sensing/sectors.py"])
def test_an_edit_of_kernels_or_records_is_noticed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).parent.mkdir(parents=True)
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "jit" / "cache.py"))
    hashes = set()
    for text in ("one", "two"):
        (tmp_path / name).write_text(text)
        cache.hash_kernel_sources.cache_clear()
        hashes.add(cache.hash_kernel_sources())
    cache.hash_kernel_sources.cache_clear()
    assert len(hashes) == 2
