"""Kernels work out the same, bit by bit, whether compiled, compiled with bounds checked, or run as plain Python."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

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
    done = subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def found(chosen: str, parts: str = ALL_PARTS) -> dict[str, Any]:
    """What comes out of all cases in a mode, with these parts of the kernels."""
    read: dict[str, Any] = json.loads(in_mode(chosen, "-m", "tests.kernel_modes", parts=parts))
    return read


@pytest.mark.long
def test_modes_agree() -> None:
    compiled, checked, plain = found(COMPILED), found(CHECKED), found(PYTHON)
    assert checked["cases"] == compiled["cases"]
    assert plain["cases"] == compiled["cases"]
    assert found(PYTHON, OWN_PARTS)["cases"] == compiled["cases"]
    assert compiled["numba"]
    assert not plain["numba"]


@pytest.mark.parametrize(("index", "checked", "python"), BEYOND)
def test_index_out_of_bounds(index: int, checked: bool, python: bool) -> None:
    code = (
        "import numpy as np\n"
        "from understudy.jit.decorators import njit_entry\n"
        "element = njit_entry()(lambda array, index: array[index])\n"
        f"try: element(np.zeros(3), {index})\n"
        "except IndexError: print('refused')"
    )
    assert in_mode(CHECKED, "-c", code) == ("refused\n" if checked else "")
    assert in_mode(PYTHON, "-c", code) == ("refused\n" if python else "")


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
