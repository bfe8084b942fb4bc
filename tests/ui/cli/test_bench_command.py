"""The command bench: what it compares."""

from __future__ import annotations

import json

import pytest
from tests.ui.cli.commands import run


def test_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    from understudy_lab.bench import interpreter

    monkeypatch.setattr(interpreter, "TICKS", 100)
    monkeypatch.setattr(interpreter, "ROUNDS", 3)
    result = run("bench", "interpreter", "--json")
    told = json.loads(result.stdout)
    assert told["levels"] == 3
    assert told["py_trees_nodes"] == 11
    assert result.exit_code == (0 if told["passed"] else 1)


def test_the_bench_compares_equal_decisions() -> None:
    from understudy_lab.bench.harness import import_peer
    from understudy_lab.bench.interpreter import PyTreesForager, interpreter, readings

    ours, theirs = interpreter(), PyTreesForager(import_peer("py_trees", "py_trees"))
    for tick, row in enumerate(readings(300)):
        basic = ours.pulse(row, tick * 0.1)
        theirs.tick(row)
        assert str(ours.program.basics[basic]) == theirs.action
