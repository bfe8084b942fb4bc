"""How long a robot takes to answer is measured; the numbers themselves are `understudy bench robots`."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.peers.building import missing

from understudy.addons.robots.ros.dds import DdsTransport
from understudy_lab.bench import robot_latency
from understudy_lab.bench.robot_latency import build_program


@pytest.fixture
def briefly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_latency, "FIRST", 2)
    monkeypatch.setattr(robot_latency, "ANSWER_S", 30.0)  # so that nothing counts as lost on a busy machine
    monkeypatch.setattr(robot_latency, "DOMAIN", 78)  # each test has its own: they may run at the same time


@pytest.mark.timed
def test_a_robot_that_decides_is_measured(briefly: None, tmp_path: Path) -> None:
    found = robot_latency.measure_latency(
        "ours, DDS", DdsTransport(78), robot_latency._decider(tmp_path, "dds"), 10
    )
    assert (found["what"], found["messages"], found["lost"]) == ("ours, DDS", 10, 0)
    assert 0 < found["p50_ms"] <= found["p99_ms"] <= found["max_ms"]


@pytest.mark.timed
def test_the_program_in_c_is_measured(briefly: None, tmp_path: Path) -> None:
    if reason := missing():  # asked here, since compilers take seconds to say so
        pytest.skip(reason)
    program = build_program(tmp_path)
    assert program is not None
    found = robot_latency.measure_latency(
        "in C", DdsTransport(79), [str(program), "79", robot_latency.SPACE], 10
    )
    assert found["lost"] == 0
    assert 0 < found["p50_ms"] <= found["max_ms"]


def test_what_never_answers_is_lost(briefly: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot_latency, "ANSWER_S", 0.01)
    found = robot_latency.measure_latency("nobody", DdsTransport(80), ["echo", "ready"], 3)
    assert found["lost"] == 3


def test_goals_of_what_was_not_measured_are_not_reached_and_not_missed() -> None:
    assert {goal.of([])["passed"] for goal in robot_latency.goals()} == {None}
    rows = [{"what": robot_latency.DDS_ROW, "p50_ms": 2.1, "p99_ms": 9.0, "lost": 0}]
    reached = {goal.what: goal.of(rows)["passed"] for goal in robot_latency.goals()[:3]}
    assert reached == {"ours, DDS: p50_ms": False, "ours, DDS: p99_ms": True, "ours, DDS: lost": True}
