"""Coordinators of squads decide in every target as in Understudy."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from tests.export.exports import make, read_counts
from tests.export.recorded_answers import Ask
from tests.make.transcripts import FOLDER
from tests.training.test_squad_session import SQUAD

from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.targets.target_table import TARGETS
from understudy.learning.fit import learn
from understudy.storage.library_folder import open_library

PEERS = {"c99": "gcc", "json": "node", "scxml": "scion", "xstate": "xstate", "btcpp": "behaviortreepy"}


@pytest.mark.parametrize("to", [target for target in TARGETS if target != "ros2"])  # which is for robots
def test_a_coordinator_orders_as_in_understudy(to: str, ask: Ask, tmp_path: Path) -> None:
    library = open_library(FOLDER / "squad" / "patrol", SQUAD.kit, learn).library
    result = export_automaton(library, "lead", tmp_path, to=to)
    rows = (tmp_path / "conformance.csv").read_text().splitlines()
    assert ",order,issued" in rows[0]
    orders = {tuple(row.split(",")[-2:]) for row in rows[1:]}
    assert orders >= {(f"{order}.0", issued) for order in (1, 2, 3) for issued in ("0.0", "1.0")}
    if to == "python":
        assert read_counts(make(tmp_path, "test", PYTHON=sys.executable)) == (result.ticks, 0)
    else:
        assert ask(PEERS[to], tmp_path).counts == (result.ticks, 0)
