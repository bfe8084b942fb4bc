"""The time from a command to what a person waits for, in fresh processes, with empty and with full caches of kernels.

Peers do what their users do first: import, make an environment or a model, and take one step. Every case runs once per
round; the rounds take turns, and medians and ranges are reported. The cache of files of the operating system is warm.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from understudy.jit.cache import SETTING
from understudy.jit.settings import AUTO, MODE

ROUNDS = 5
EMPTY, FULL = "empty", "full"
COMMAND = [sys.executable, "-c", "from understudy.ui.cli import run_command_line; run_command_line()"]
LESSON = {
    "do": "new",
    "name": "goto",
    "states": ["forward", "rotate_left", "rotate_right"],
    "features": ["distance_to(A)", "angle_to(A)"],
    "parameters": ["A"],
    "flags": ["done"],
    "targets": {"A": "station"},
}
FIRST_TICK = """
import understudy
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World
world = World(load_scenario("patrol"), [1])
world.act({"drive": [1.0] * world.agents, "turn": [0.0] * world.agents})
"""
EVALUATION = """
from understudy import evaluate, open_library
from understudy.sim.forage import FORAGE_KIT
evaluate(open_library("library", FORAGE_KIT).library, "goto", "forage", range(10), binding={"A": "station"})
"""
PEERS: Mapping[str, tuple[str, str]] = {
    "mesa: a model and a step": (
        "mesa",
        "import mesa\nmodel = mesa.Model()\nmesa.Agent(model)\nmodel.agents.do('__repr__')\nmodel.step()",
    ),
    "gymnasium: CartPole and a step": (
        "gymnasium",
        "import gymnasium\nworld = gymnasium.make('CartPole-v1')\nworld.reset(seed=1)\nworld.step(0)",
    ),
    "py_trees: a tree and a tick": (
        "py_trees",
        "import py_trees\npy_trees.trees.BehaviourTree(py_trees.behaviours.Running('run')).tick()",
    ),
    "torch: import": ("torch", "import torch"),
}
GOALS: tuple[tuple[str, str, float], ...] = (
    ("studio: first frame", EMPTY, 3.0),
    ("studio: first press on disk", EMPTY, 5.0),
    ("studio, a new scenario: first frame", EMPTY, 3.0),
    ("studio, a new scenario: first press on disk", EMPTY, 5.0),
    ("studio: first frame", FULL, 1.5),
    ("studio: first press on disk", FULL, 3.0),
    ("demo", EMPTY, 25.0),
    ("demo", FULL, 9.0),
    ("--help", FULL, 0.25),
    ("list", FULL, 0.4),
    ("show", FULL, 0.4),
    ("Python: first tick of four robots", EMPTY, 0.5),
)
"""Case, cache, and the most time in s."""

Times = dict[str, float]


def run() -> dict[str, Any]:
    """Measure every case in turns; return medians and ranges in s, and which goals were reached."""
    times_by_case: dict[tuple[str, str], list[float]] = {}
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        full = folder / "full"
        _run_process([*COMMAND, "prepare", "forage", "patrol"], folder, full)
        _run_process([*COMMAND, "demo", "--json", "--out", "demo"], folder, full)
        (folder / "library").symlink_to(folder / "demo" / "library")
        for number in range(ROUNDS):
            for cache, kernels in ((EMPTY, folder / f"empty {number}"), (FULL, full)):
                for case, seconds in _run_round(folder, kernels).items():
                    times_by_case.setdefault((case, cache), []).append(seconds)
            for peer, (module, code) in PEERS.items():
                if find_spec(module) is not None:
                    seconds = _run_process([sys.executable, "-c", code], folder, full)
                    times_by_case.setdefault((peer, ""), []).append(seconds)
    results = [
        {"case": case, "cache": cache, "s": median(times), "least_s": min(times), "most_s": max(times)}
        for (case, cache), times in times_by_case.items()
    ]
    goals = [
        {
            "what": f"{case}, {cache} cache",
            "most": most,
            "value": median(times_by_case[case, cache]),
            "passed": median(times_by_case[case, cache]) <= most,
        }
        for case, cache, most in GOALS
    ]
    return {
        "results": results,
        "goals": goals,
        "missing": [peer for peer, (module, _) in PEERS.items() if find_spec(module) is None],
        "passed": all(goal["passed"] for goal in goals),
    }


def _run_round(folder: Path, kernels: Path) -> Times:
    """Run all cases of ours once; with an empty cache, each finds it as the case before left it but for kernels."""
    times: Times = {}
    python: Mapping[str, Callable[[Path], float]] = {
        "Python: first tick of four robots": lambda cache: _run_code(FIRST_TICK, folder, cache),
        "Python: evaluate in ten worlds": lambda cache: _run_code(EVALUATION, folder, cache),
        "--help": lambda cache: _run_process([*COMMAND, "--help"], folder, cache),
        "list": lambda cache: _run_process([*COMMAND, "list", "-l", "library"], folder, cache),
        "show": lambda cache: _run_process([*COMMAND, "show", "goto", "-l", "library"], folder, cache),
        "demo": lambda cache: _run_process([*COMMAND, "demo", "--json", "--out", "out"], folder, cache),
    }
    each = iter(range(100))

    def cache() -> Path:
        return kernels if kernels.name == FULL else kernels / str(next(each))

    for name, work in python.items():
        times[name] = work(cache())
    new = folder / "new.toml"
    new.write_text(_write_new_scenario(folder))
    for name, scenario in (("studio", "forage"), ("studio, a new scenario", str(new))):
        frame, press = _run_studio(scenario, folder, cache())
        times[f"{name}: first frame"], times[f"{name}: first press on disk"] = frame, press
    return times


def _write_new_scenario(folder: Path) -> str:
    """Return the file of a scenario whose kernels no built-in one has: forage with a sonar."""
    done = subprocess.run(
        [*COMMAND, "worlds", "forage"], cwd=folder, capture_output=True, text=True, check=True
    )
    sensor = "[[types.forager.sensors]]\nkind = "
    sonar = f'{sensor}"sonar"\nrange = 2\nsectors = {{ ahead = [-20, 20] }}\n\n'
    return done.stdout.replace('name = "forage"', 'name = "new"', 1).replace(sensor, sonar + sensor, 1)


def _run_process(command: list[str], folder: Path, kernels: Path) -> float:
    """Return the time in s that a process takes from its start to its end."""
    began = perf_counter()
    subprocess.run(
        command, cwd=folder, env=_environment(kernels), check=True, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    return perf_counter() - began


def _run_code(code: str, folder: Path, kernels: Path) -> float:
    """Return the time in s that Python takes for code, from its start to its end."""
    return _run_process([sys.executable, "-c", code], folder, kernels)


def _environment(kernels: Path) -> dict[str, str]:
    """Return the environment of a process that keeps compiled kernels in this folder."""
    return {**os.environ, MODE: AUTO, SETTING: str(kernels), "PYTHONUNBUFFERED": "1"}


def _run_studio(scenario: str, folder: Path, kernels: Path) -> tuple[float, float]:
    """Return the times in s from the command to the first frame in which the world moved, and to a press on disk.

    A press is on disk when the studio acknowledges it.
    """
    with TemporaryDirectory() as library:
        command = [*COMMAND, "studio", scenario, "--library", library, "--no-browser", "--port", "0"]
        began = perf_counter()
        with _started(command, folder, kernels) as process:
            port = next(
                found[1]
                for line in process.stdout or ()
                if (found := re.search(r"http://127\.0\.0\.1:(\d+)/", line))
            )
            from websockets.sync.client import connect

            with connect(f"ws://127.0.0.1:{port}/ws", max_size=None) as socket:
                _ask(socket, 1, LESSON)
                while not isinstance(socket.recv(timeout=300), bytes):
                    pass
                frame = perf_counter() - began
                _ask(socket, 2, {"do": "press", "state": "forward"})
                return frame, perf_counter() - began


@contextmanager
def _started(command: list[str], folder: Path, kernels: Path) -> Any:
    """Start a process that is ended with the block."""
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=_environment(kernels),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def _ask(socket: Any, number: int, request: Mapping[str, Any]) -> None:
    """Send a request, and wait for the answer to it."""
    socket.send(json.dumps({"id": number, **request}))
    while True:
        received = socket.recv(timeout=300)
        if isinstance(received, str) and json.loads(received).get("re") == number:
            return
