"""Kernels run as plain Python until another process has compiled them."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Condition, Event
from typing import Any

import numpy as np
import pytest
from tests.jit import sample_kernels
from tests.processes import end_with_tests

from understudy.jit import cache, switch
from understudy.jit.decorators import Kernel
from understudy.jit.dispatchers import make_dispatcher
from understudy.jit.settings import AUTO, MODE
from understudy.learning._linalg_kernels import invert_matrix
from understudy.ui.cli.progress_bar import show_progress

ROOT = Path(__file__).parents[2]
PATIENCE_S = 60.0
"""How long is waited for the loader at most."""
SERVED = Condition()
"""Notified whenever the loader has served a request."""


@pytest.fixture(autouse=True)
def patient(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An empty folder for compiled kernels, and a loader of its own, which wants compiled code at once."""
    monkeypatch.setenv(MODE, AUTO)
    monkeypatch.setenv(cache.SETTING, str(tmp_path / "kernels"))
    monkeypatch.setattr(switch, "PATIENCE_S", -1.0)
    monkeypatch.setattr(switch, "_the_loader", None)
    serve = switch.KernelLoader._serve

    def serve_and_notify(loader: switch.KernelLoader, request: switch.Request) -> None:
        try:
            serve(loader, request)
        finally:
            with SERVED:
                SERVED.notify_all()

    monkeypatch.setattr(switch.KernelLoader, "_serve", serve_and_notify)
    yield
    end_loader()


def wait_until(holds: Callable[[], object]) -> None:
    """Wait until something holds, which comes of a request that the loader serves."""
    with SERVED:
        assert SERVED.wait_for(holds, PATIENCE_S)


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
    found = set()

    def call() -> bool:
        found.add(kernel(*args))
        return kernel.is_compiled(*args)

    wait_until(call)
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
    add_up, numbers, held = anew(sample_kernels.add_up), np.arange(4.0), Event()
    pickles: Any = vars(switch)["pickle"]
    load = pickles.load
    monkeypatch.setattr(pickles, "load", lambda file: (load(file), held.wait(PATIENCE_S))[0])
    assert not switch.is_compiling()
    add_up(numbers)
    wait_until(switch.is_compiling)
    with show_progress("Worlds run") as report:
        report(1, 100)
    assert "Worlds run (slower until the engine is compiled)" in capsys.readouterr().err
    held.set()
    wait_until(lambda: add_up.is_compiled(numbers))
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
    name_type(np.arange(4.0))
    wait_until(lambda: "TypingError" in caplog.text)
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
        if len(started) == 1:
            started[0].kill()
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", remember)
    assert add_up(np.arange(4.0)) == 6.0
    # A record is in the list before its text is written.
    wait_until(lambda: "the process that compiles them has ended" in caplog.text)
    assert add_up(np.arange(4.0)) == 6.0
    assert call_until(add_up, np.arange(4, dtype=np.int32)) == {6.0}
    assert len(started) == 2


@pytest.mark.long
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
    wait_until(lambda: asked)
    assert [request.switch for request in asked] == [double.run]


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked")
def test_a_forked_process_loads_kernels_by_itself(tmp_path: Path) -> None:
    code = (
        "import os, threading, numpy as np\n"
        "from tests.jit.sample_kernels import add_up\n"
        "from understudy.jit import switch\n"
        "switch.PATIENCE_S = -1.0\n"
        "add_up(np.arange(4.0))\n"
        "child = os.fork()\n"
        "while not add_up.is_compiled(np.arange(4)): add_up(np.arange(4)); threading.Event().wait(0.01)\n"
        "if child == 0: os._exit(0)\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))"
    )
    given = {**os.environ, "PYTHONPATH": os.pathsep.join((str(ROOT), *sys.path))}
    assert (
        subprocess.run(end_with_tests([sys.executable, "-c", code]), env=given, check=False).returncode == 0
    )


def test_long_work_waits_for_the_compiler() -> None:
    kernel = anew(invert_matrix)
    matrix = np.eye(3) * 2.0
    plain = kernel(matrix)
    assert not kernel.is_compiled(matrix)
    assert (kernel.run_long(matrix) == plain).all()
    assert kernel.compiling is not None
    assert kernel.compiling is not make_dispatcher(kernel.function)
    kernel.compiling = None
    anew(kernel)


def test_long_work_does_not_mind_what_a_thread_loads() -> None:
    """The thread's own function is forbidden to compile; another test, or the same session, may have asked for it."""
    kernel = anew(invert_matrix)
    make_dispatcher(kernel.function)._cache.compiles = False
    matrix = np.eye(4) * 2.0
    assert (kernel.run_long(matrix) == np.eye(4) / 2).all()
    kernel.compiling = None
    anew(kernel)
