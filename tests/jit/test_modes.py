"""Kernels work out the same, bit by bit, whether compiled, compiled with bounds checked, or run as plain Python."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from understudy.errors import SettingError
from understudy.jit.plain import Plain, make_plain
from understudy.jit.settings import (
    ALL_PARTS,
    CHECKED,
    COMPILED,
    MODE,
    OWN_PARTS,
    PARTS,
    PYTHON,
    read_kernel_mode,
    read_kernel_parts,
)
from understudy.sim.kernel_context import find_world_contents
from understudy.sim.params import make_world_params
from understudy.sim.scenario.files import load_scenario

ROOT = Path(__file__).parents[2]
LED = "squads"
KERNELS = "*/kernels/*.py,*/_*kernels.py"
UNREACHED = {
    "_growth_kernels.py": 1, "_handwritten_kernels.py": 4, "_pulse_kernels.py": 13, "_split_kernels.py": 2,
    "_squad_kernels.py": 34,
    "camera.py": 2, "clearance.py": 2, "collisions.py": 8, "dynamics.py": 8, "grid.py": 23, "placement.py": 4,
    "pulling.py": 1, "scan.py": 1, "sensing.py": 8, "signals.py": 9, "sector_distances.py": 1, "thread_barrier.py": 14,
    "tick.py": 19,
}  # fmt: skip
"""How many of some 1400 branches of kernels no case reaches: above all those of several threads, of parts of kernels
that are left out, and of most statistics of coordinators."""
RECORD = np.dtype([("x", "f8"), ("n", "i4")], align=True)
BEYOND = [  # index of an array of three -> whether it is refused: in checked mode, in plain Python
    (2, False, False),
    (3, True, True),
    (-1, False, True),
    (-4, True, True),
]


def in_mode(chosen: str, *arguments: str, parts: str = ALL_PARTS) -> str:
    """What a Python prints in which kernels run so."""
    command = [sys.executable, *arguments]
    given = {**os.environ, MODE: chosen, PARTS: parts, "PYTHONPATH": os.pathsep.join((str(ROOT), *sys.path))}
    if chosen == CHECKED:
        given["NUMBA_OPT"] = "0"
    done = subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def run_cases(chosen: str, *left_out: str, parts: str = ALL_PARTS) -> dict[str, Any]:
    """What comes out of all cases but those left out in a mode, with these parts of the kernels."""
    read: dict[str, Any] = json.loads(in_mode(chosen, "-m", "tests.kernel_modes", *left_out, parts=parts))
    return read


class PlainRun(NamedTuple):
    """What comes out of all cases as plain Python, and how many branches of each file of kernels are not reached."""

    cases: dict[str, str]
    numba: bool
    unreached: dict[str, int] | None
    """None: coverage is not installed."""


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> PlainRun:
    """All cases as plain Python, under coverage if it is installed."""
    if find_spec("coverage") is None:
        read = run_cases(PYTHON)
        return PlainRun(read["cases"], read["numba"], None)
    data, report = (str(tmp_path_factory.mktemp("coverage") / name) for name in ("data", "report.json"))
    kept = f"--data-file={data}"
    own = f"--rcfile={os.devnull}"  # what the project's settings include is all of its source
    text = in_mode(
        PYTHON,
        "-m",
        "coverage",
        "run",
        own,
        "--branch",
        kept,
        f"--include={KERNELS}",
        "-m",
        "tests.kernel_modes",
    )
    in_mode(PYTHON, "-m", "coverage", "json", own, kept, "-q", "-o", report)
    files = json.loads(Path(report).read_text())["files"]
    unreached = {Path(name).name: file["summary"]["missing_branches"] for name, file in files.items()}
    return PlainRun(**json.loads(text), unreached={name: count for name, count in unreached.items() if count})


@pytest.mark.long
def test_modes_agree(plain: PlainRun) -> None:
    """What takes longest is to compile checked kernels, so they are not optimized, and those of coordinators left out.

    Plain Python checks bounds in these, too, and more strictly.
    """
    compiled, checked = run_cases(COMPILED), run_cases(CHECKED, LED)
    assert checked["cases"] == {name: result for name, result in compiled["cases"].items() if name != LED}
    assert plain.cases == compiled["cases"]
    assert run_cases(PYTHON, parts=OWN_PARTS)["cases"] == compiled["cases"]
    assert compiled["numba"]
    assert not plain.numba


@pytest.mark.long
def test_modes_are_compared_in_every_branch_of_kernels(plain: PlainRun) -> None:
    if plain.unreached is None:
        pytest.skip("coverage is not installed")
    assert {name: many for name, many in plain.unreached.items() if many > UNREACHED.get(name, 0)} == {}


@pytest.fixture(scope="module")
def refusals() -> dict[str, list[int]]:
    """The indices of BEYOND that are refused in each mode."""
    code = (
        "import json, numpy as np\n"
        "from understudy.jit.decorators import njit_entry\n"
        "element = njit_entry()(lambda array, index: array[index])\n"
        "refused = []\n"
        f"for index in {[index for index, *_ in BEYOND]}:\n"
        "    try: element(np.zeros(3), index)\n"
        "    except IndexError: refused.append(index)\n"
        "print(json.dumps(refused))"
    )
    return {mode: json.loads(in_mode(mode, "-c", code)) for mode in (CHECKED, PYTHON)}


@pytest.mark.parametrize(("index", "checked", "python"), BEYOND)
def test_index_out_of_bounds(refusals: dict[str, list[int]], index: int, checked: bool, python: bool) -> None:
    assert (index in refusals[CHECKED]) == checked
    assert (index in refusals[PYTHON]) == python


def test_parts_of_kernels_are_those_of_the_world_unless_all_are_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenario = load_scenario("arena")
    rules = make_world_params(scenario)
    monkeypatch.delenv(PARTS)
    assert None in find_world_contents(scenario, rules)
    monkeypatch.setenv(PARTS, ALL_PARTS)
    assert None not in find_world_contents(scenario, rules)
    monkeypatch.setenv(PARTS, "none")
    with pytest.raises(SettingError, match="UNDERSTUDY_KERNEL_PARTS is 'none'; give one of own, all"):
        read_kernel_parts()


def test_unknown_mode_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(MODE, "fast")
    with pytest.raises(
        SettingError, match="UNDERSTUDY_KERNELS is 'fast'; give one of auto, compiled, checked, python"
    ):
        read_kernel_mode()


def test_plain_records_write_through() -> None:
    records = np.zeros(3, RECORD)
    found = Plain(records)
    found[1].x = 0.5
    found[2] = found[1]
    assert records["x"].tolist() == [0.0, 0.5, 0.5]


def test_plain_arrays_give_numbers_of_python() -> None:
    table = Plain(np.arange(6.0).reshape(2, 3))
    assert type(table[1, 2]) is float
    assert [table[1][index] for index in range(3)] == [3.0, 4.0, 5.0]
    assert type(Plain(np.arange(3, dtype=np.int32))[2]) is int


@pytest.mark.parametrize("index", [-1, (0, -1), (-1, 0), slice(-1, None), 2, (0, 3)])
def test_plain_arrays_refuse_what_is_out_of_bounds(index: Any) -> None:
    with pytest.raises(IndexError):
        Plain(np.zeros((2, 3)))[index]


def test_all_arrays_of_nested_tuples_become_plain() -> None:
    (first, (second, text)), number = make_plain(((np.zeros(1), (np.zeros(2), "as it is")), np.float64(0.5)))
    assert (len(first), len(second), text, type(number)) == (1, 2, "as it is", float)
