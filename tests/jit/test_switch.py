"""Kernels run as plain Python until another process has compiled them."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest
from tests.jit import sample_kernels

from understudy.jit import cache, switch
from understudy.jit.decorators import Kernel
from understudy.jit.dispatchers import make_dispatcher
from understudy.jit.settings import AUTO, MODE
from understudy.ui.cli.output import show_progress

ROOT = Path(__file__).parents[2]
PATIENCE_S = 30.0


@pytest.fixture(autouse=True)
def patient(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An empty folder for compiled kernels, and a loader of its own, which wants compiled code at once."""
    monkeypatch.setenv(MODE, AUTO)
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "kernels"))
    monkeypatch.setattr(switch, "PATIENCE_S", -1.0)
    monkeypatch.setattr(switch, "_the_loader", None)
    yield
    end_loader()


def end_loader() -> None:
    """End the loader, and the process that compiles for it; the next call gets another."""
    loader, switch._the_loader = switch._the_loader, None
    if loader is not None:
        loader.stop()
        if loader.compiler is not None:
            loader.compiler.wait()


def anew(kernel: Kernel[..., Any]) -> Kernel[..., Any]:
    """The same kernel, as if it had never been called."""
    kernel.run = kernel._choose_and_run
    switch._switched.pop(kernel, None)
    make_dispatcher.cache_clear()
    return kernel


def call_until(kernel: Kernel[..., Any], *args: Any) -> set[Any]:
    """Call a kernel until it is compiled for these arguments; return all that it returned."""
    found, until = set(), monotonic() + PATIENCE_S
    while not kernel.is_compiled(*args) and monotonic() < until:
        found.add(kernel(*args))
        sleep(0.01)
    assert kernel.is_compiled(*args)
    return found | {kernel(*args)}


def test_a_kernel_is_compiled_while_it_runs() -> None:
    add_up = anew(sample_kernels.add_up)
    assert call_until(add_up, np.arange(4.0)) == {6.0}
    assert not isinstance(add_up.run, switch.KernelSwitch)


def test_progress_says_that_it_is_slower_while_kernels_are_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    add_up, numbers, said = anew(sample_kernels.add_up), np.arange(4.0), ""
    assert not switch.is_compiling()
    until = monotonic() + PATIENCE_S
    while not add_up.is_compiled(numbers) and monotonic() < until:
        add_up(numbers)
        if switch.is_compiling() and not said:
            with show_progress("Worlds run") as report:
                report(1, 100)
            said = capsys.readouterr().err
    assert "Worlds run (slower until the engine is compiled)" in said
    assert not switch.is_compiling()


def test_other_types_run_as_plain_python_until_they_are_compiled_too() -> None:
    add_up = anew(sample_kernels.add_up)
    call_until(add_up, np.arange(4.0))
    whole = np.arange(4, dtype=np.int32)
    assert not add_up.is_compiled(whole)
    assert call_until(add_up, whole) == {6.0}
    assert add_up.is_compiled(np.arange(4.0))


def test_short_work_compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(switch, "PATIENCE_S", 60.0)
    add_up = anew(sample_kernels.add_up)
    for _ in range(100):
        add_up(np.arange(4.0))
    assert switch._the_loader is None


def test_what_cannot_be_compiled_stays_plain_and_is_warned_about_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    name_type = anew(sample_kernels.name_type)
    until = monotonic() + PATIENCE_S
    while not caplog.records and monotonic() < until:
        name_type(np.arange(4.0))
        sleep(0.01)
    for _ in range(10):
        assert name_type(np.arange(4.0)).startswith("Plain")
    assert [record.levelno for record in caplog.records] == [logging.WARNING]
    assert "Kernels run uncompiled, which is slower: name_type: TypingError" in caplog.text


def test_after_the_compiling_process_was_killed_kernels_stay_plain_and_others_get_a_new_one(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_up = anew(sample_kernels.add_up)
    started = []
    begin = subprocess.Popen

    def remember(*args: Any, **options: Any) -> Any:
        started.append(begin(*args, **options))
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", remember)
    until = monotonic() + PATIENCE_S
    while not started and monotonic() < until:
        add_up(np.arange(4.0))
    os.kill(started[0].pid, signal.SIGKILL)
    while not caplog.records and monotonic() < until:
        assert add_up(np.arange(4.0)) == 6.0
    assert "the process that compiles them has ended" in caplog.text
    assert call_until(add_up, np.arange(4, dtype=np.int32)) == {6.0}
    assert len(started) == 2


@pytest.mark.parametrize("spoil", [b"", b"nonsense"])
def test_a_spoiled_file_is_compiled_again(spoil: bytes, tmp_path: Path) -> None:
    add_up = anew(sample_kernels.add_up)
    call_until(add_up, np.arange(4.0))
    (file,) = (tmp_path / "kernels").iterdir()
    end_loader()
    cache.write_kernel(file.stem, spoil)
    assert call_until(anew(add_up), np.arange(4.0)) == {6.0}
    assert cache.read_kernel(file.stem) not in (b"", b"nonsense", None)


def test_a_second_process_finds_what_the_first_compiled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    add_up = anew(sample_kernels.add_up)
    call_until(add_up, np.arange(4.0))
    monkeypatch.setattr(switch, "KernelCompiler", None)
    assert call_until(anew(add_up), np.arange(4.0)) == {6.0}


def test_code_for_more_general_arguments_is_used_until_there_is_some_for_these(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    double = anew(sample_kernels.double)
    call_until(double, 1.5, True)
    end_loader()
    double = anew(double)
    asked = []
    monkeypatch.setattr(switch.KernelCompiler, "ask", lambda _, request: asked.append(request))
    assert call_until(double, 1.5, None) == {3.0}
    assert isinstance(double.run, switch.KernelSwitch)
    until = monotonic() + PATIENCE_S
    while not asked and monotonic() < until:
        sleep(0.01)
    assert [request.switch for request in asked] == [double.run]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked")
def test_a_forked_process_loads_kernels_by_itself(tmp_path: Path) -> None:
    code = (
        "import os, time, numpy as np\n"
        "from tests.jit.sample_kernels import add_up\n"
        "from understudy.jit import switch\n"
        "switch.PATIENCE_S = -1.0\n"
        "add_up(np.arange(4.0))\n"
        "child = os.fork()\n"
        "until = time.monotonic() + 60\n"
        "while not add_up.is_compiled(np.arange(4)) and time.monotonic() < until:\n"
        "    add_up(np.arange(4)); time.sleep(0.01)\n"
        "compiled = add_up.is_compiled(np.arange(4))\n"
        "if child == 0: os._exit(0 if compiled else 1)\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) + (not compiled))"
    )
    given = {**os.environ, "PYTHONPATH": os.pathsep.join((str(ROOT), *sys.path))}
    assert subprocess.run([sys.executable, "-c", code], env=given, check=False).returncode == 0
