"""Of several processes that want the same kernel one compiles it, and the others wait for it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from understudy.jit import cache
from understudy.jit.settings import COMPILED, MODE

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="files cannot be locked")


def start(code: str, folder: Path) -> subprocess.Popen[str]:
    """Start a Python whose folder for compiled kernels is this one."""
    given = {
        **os.environ,
        MODE: COMPILED,
        cache.SETTING: str(folder),
        "PYTHONPATH": os.pathsep.join((str(ROOT), *sys.path)),
    }
    return subprocess.Popen(
        [sys.executable, "-c", code], env=given, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )


def test_a_lock_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "kernels"))
    log = tmp_path / "log"
    code = (
        "import sys\nfrom understudy.jit.cache import lock_kernel\n"
        "print('ready', flush=True)\n"
        "with lock_kernel('0'), open(sys.stdin.readline(), 'a') as log: log.write('second')\n"
    )
    with start(code, tmp_path / "kernels") as other:
        assert other.stdin is not None
        assert other.stdout is not None
        with cache.lock_kernel("0"):
            other.stdin.write(str(log))
            other.stdin.close()
            assert other.stdout.readline() == "ready\n"
            with log.open("a") as file:
                file.write("first ")
        assert other.wait() == 0
    assert log.read_text() == "first second"
    assert list((tmp_path / "kernels").iterdir()) == [], "locks are cleared away"


@pytest.mark.long
def test_two_processes_compile_a_kernel_once(tmp_path: Path) -> None:
    code = (
        "import json, numpy as np\nfrom tests.jit.sample_kernels import add_up\n"
        "assert add_up(np.arange(4.0)) == 6.0\n"
        "counted = add_up.run.stats\n"
        "print(json.dumps([sum(counted.cache_hits.values()), sum(counted.cache_misses.values())]))"
    )
    both = [start(code, tmp_path) for _ in range(2)]
    loaded_and_compiled = [json.loads(process.communicate()[0]) for process in both]
    assert sorted(loaded_and_compiled) == [[0, 1], [1, 0]]
    assert len(list(tmp_path.iterdir())) == 1


def test_without_locks_nothing_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "file" / "kernels"))
    (tmp_path / "file").write_text("")
    with cache.lock_kernel("0"), cache.lock_kernel("0"):
        pass
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "kernels"))
    monkeypatch.setattr("understudy.jit.cache.fcntl", None)
    with cache.lock_kernel("0"), cache.lock_kernel("0"):
        assert not (tmp_path / "kernels").exists()
