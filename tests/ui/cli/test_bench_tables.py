"""What `understudy bench` shows to people, in a terminal of 80 columns: everything, nothing cut short."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from understudy.ui.cli.main import make_command_line
from understudy_lab.bench import swarm
from understudy_lab.bench.harness import Row, result
from understudy_lab.commands.bench_tables import short

SHORT = [
    (0.9768, "0.977"),
    (57.0, "57"),
    (999.7, "1 000"),
    (9_990.0, "9 990"),
    (20_000.0, "20 k"),
    (999_999.0, "1 M"),
    (6_543_210.0, "6.54 M"),
    (4e9, "4 G"),
]


@pytest.mark.parametrize(("number", "text"), SHORT)
def test_numbers_are_short(number: float, text: str) -> None:
    assert short(number) == text


def test_a_table_of_speeds_fits_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    tasks = [(case.task, case.threads) for group in swarm.groups() for case in group]
    rows: list[Row] = [
        {
            "task": task,
            "robots": 100_000,
            "threads": threads,
            "robot_ticks_per_s": 123_456_789.0,
            "spread": 1.234,
        }
        for task, threads in tasks
    ]
    told = {**result(rows, swarm.GOALS), "fractions": [{**row, "of_by_hand": 1.5} for row in rows]}
    monkeypatch.setattr(swarm, "run", lambda: told)
    shown = CliRunner(env={"COLUMNS": "80", "NO_COLOR": "1", "TERM": "dumb"}).invoke(
        make_command_line(), ["bench", "swarm"]
    )
    lines = shown.stdout.splitlines()
    assert "…" not in shown.stdout
    assert max(map(len, lines)) <= 80
    assert sum("100 000" in line and "123 M" in line and "123%" in line for line in lines) == len(tasks)
    assert "reached" in shown.stdout
    for text in ("robot-ticks/s", "times Mesa", "at least 4 M", "at least 200", "not measured"):
        assert text in shown.stdout
