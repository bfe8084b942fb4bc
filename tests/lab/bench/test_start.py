"""The benchmark of starting: what it reports of times, and that a studio that was started answers."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import pytest

from understudy_lab.bench import start


def test_medians_and_goals(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers: Iterator[int] = count()

    def run_round(folder: Path, kernels: Path) -> dict[str, float]:
        number = next(numbers)  # an empty and a full cache in turn
        return dict.fromkeys({case for case, _, _ in start.GOALS}, 0.1 * number)

    def run_process(command: list[str], folder: Path, kernels: Path) -> float:
        return 0.5

    monkeypatch.setattr(start, "ROUNDS", 3)
    monkeypatch.setattr(start, "_run_round", run_round)
    monkeypatch.setattr(start, "_run_process", run_process)
    found = start.run()
    times = {
        (row["case"], row["cache"]): (row["least_s"], row["s"], row["most_s"]) for row in found["results"]
    }
    assert times["--help", start.EMPTY] == pytest.approx((0.0, 0.2, 0.4))
    assert times["--help", start.FULL] == pytest.approx((0.1, 0.3, 0.5))
    goals = {goal["what"]: (goal["most"], goal["passed"]) for goal in found["goals"]}
    assert goals["--help, full cache"] == (0.25, False)
    assert goals["list, full cache"] == (0.4, True)
    assert not found["passed"]
    measured = {case for case, cache in times if cache == ""}
    assert measured == start.PEERS.keys() - set(found["missing"])


def test_a_new_scenario_in_the_studio(tmp_path: Path) -> None:
    file = tmp_path / "new.toml"
    file.write_text(start._write_new_scenario(tmp_path))
    assert 'kind = "sonar"' in file.read_text()
    frame_s, press_s = start._run_studio(str(file), tmp_path, tmp_path / "kernels")
    assert 0 < frame_s < press_s


def test_a_command_that_fails_is_no_time(tmp_path: Path) -> None:
    failing: Any = [*start.COMMAND, "show", "nothing", "-l", str(tmp_path)]
    with pytest.raises(CalledProcessError):
        start._run_process(failing, tmp_path, tmp_path / "kernels")
