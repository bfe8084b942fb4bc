"""How long a robot takes to answer is measured; the numbers themselves are `understudy bench robots`."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.peers.building import missing

from understudy.bench import robots
from understudy.bench.peers.cyclone_echo import built
from understudy.robots.dds import DDS


@pytest.fixture
def briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robots, "FIRST", 2)
    monkeypatch.setattr(robots, "DOMAIN", 78)


def test_a_robot_that_decides_is_measured(briefly: None, tmp_path: Path) -> None:
    found = robots.measured("ours, DDS", DDS(78), robots._decider(tmp_path, "dds"), 10)
    assert (found["what"], found["messages"], found["lost"]) == ("ours, DDS", 10, 0)
    assert 0 < found["p50_ms"] <= found["p99_ms"] <= found["max_ms"] < 1000


@pytest.mark.skipif(bool(missing()), reason=missing())
def test_the_program_in_c_is_measured(briefly: None, tmp_path: Path) -> None:
    program = built(tmp_path)
    assert program is not None
    found = robots.measured("in C", DDS(78), [str(program), "78", robots.SPACE], 10)
    assert found["lost"] == 0
    assert 0 < found["p50_ms"] < 1000


def test_what_never_answers_is_lost(briefly: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robots, "ANSWER_S", 0.01)
    found = robots.measured("nobody", DDS(78), ["echo", "ready"], 3)
    assert found["lost"] == 3


def test_goals_of_what_was_not_measured_are_not_reached_and_not_missed() -> None:
    assert {goal.of([])["passed"] for goal in robots.goals()} == {None}
    rows = [{"what": robots.DDS_ROW, "p50_ms": 2.1, "p99_ms": 9.0, "lost": 0}]
    reached = {goal.what: goal.of(rows)["passed"] for goal in robots.goals()[:3]}
    assert reached == {"ours, DDS: p50_ms": False, "ours, DDS: p99_ms": True, "ours, DDS: lost": True}
