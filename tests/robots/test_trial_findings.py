"""What recordings say about trials with agents: recordings by hand, and what is found in them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="needs the extra mujoco")

from tests.robots.trial_findings import Recordings, Trial

from understudy_lab.lossy_networks.distributed_patrol import MEMBERS, ROBOTS
from understudy_lab.lossy_networks.simulated_robots import WORLD

TICKS = 60
FIRST, SECOND = "patrol_0", "pioneer_1"
BEGAN, ENDED = 20, 40


def record(folder: Path, agents: dict[str, dict[int, dict[str, Any]]], moving: range) -> Recordings:
    """Record agents in each tick of 0.1 s in which there is a line of them; the second robot moves in some."""
    for name in MEMBERS:
        lines = [
            {"began_s": tick / 10, "ended_s": tick / 10, **line}
            for tick, line in agents.get(name, {}).items()
        ]
        (folder / f"{name}.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    worlds = [
        {
            "at_s": tick / 10 + 0.05,
            "commands": [(float(name == ROBOTS[1] and tick in moving), 0.0) for name in ROBOTS],
        }
        for tick in range(TICKS)
    ]
    (folder / WORLD).write_text("".join(json.dumps(line) + "\n" for line in worlds))
    return Recordings(folder)


def leads(term: int, *ticks: range) -> dict[int, dict[str, Any]]:
    return {tick: {"leads": (term, tick)} for each in ticks for tick in each}


def obeys(leader: str, term: int, ticks: range, *, last: int = TICKS) -> dict[int, dict[str, Any]]:
    """Obey a leader, whose last message that is heard is that of the tick `last`."""
    return {tick: {"obeys": (term, min(tick, last)), "leader": leader} for tick in ticks}


TRIAL = Trial("killed", FIRST, BEGAN / 10, ENDED / 10, (TICKS - 1) / 10)


def test_a_deputy_takes_over_and_remains(tmp_path: Path) -> None:
    agents = {
        FIRST: leads(1, range(BEGAN)),
        SECOND: leads(2, range(25, TICKS)),
        ROBOTS[1]: obeys(FIRST, 1, range(25), last=BEGAN - 1) | obeys(SECOND, 2, range(25, TICKS)),
    }
    found = record(tmp_path, agents, range(TICKS)).judge(TRIAL)
    assert found.oldest_s == pytest.approx(0.55)  # of tick 19, at the tick 24 of the world
    assert found.leaderless_s == pytest.approx(0.5, abs=0.02)
    assert found.healed_s == 0.0
    assert found.two_s == 0.0
    assert found.moving == 1


def test_robots_that_stand_still_move_on_no_order(tmp_path: Path) -> None:
    agents = {FIRST: leads(1, range(BEGAN)), ROBOTS[1]: obeys(FIRST, 1, range(TICKS), last=BEGAN - 1)}
    assert record(tmp_path, agents, range(BEGAN)).judge(TRIAL).oldest_s == 0.0
    assert record(tmp_path, agents, range(TICKS)).judge(TRIAL).oldest_s == pytest.approx(3.95)


def test_two_that_are_obeyed_at_once_are_found(tmp_path: Path) -> None:
    agents = {
        FIRST: leads(1, range(TICKS)),
        SECOND: leads(2, range(25, TICKS)),
        ROBOTS[1]: obeys(FIRST, 1, range(TICKS)),
        ROBOTS[2]: obeys(SECOND, 2, range(25, 50)) | obeys(FIRST, 1, range(50, TICKS)),
    }
    found = record(tmp_path, agents, range(TICKS)).judge(TRIAL)
    assert found.two_s == pytest.approx(2.5)
    assert found.healed_s is None


def test_a_former_leader_that_comes_back_is_healed_when_one_is_left(tmp_path: Path) -> None:
    agents = {
        FIRST: leads(1, range(45)),
        SECOND: leads(2, range(25, TICKS)),
        ROBOTS[1]: obeys(SECOND, 2, range(25, TICKS)),
    }
    found = record(tmp_path, agents, range(TICKS)).judge(TRIAL)
    assert found.healed_s == pytest.approx(0.65, abs=0.02)  # led until tick 44, and counts for 0.25 s more
    assert found.two_s == 0.0  # nobody obeyed it
