"""The experiment about lossy networks: its conclusions from rows by hand, and cycles in recordings by hand."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra mujoco")

from tests.robots.agent_processes import save_patrol

from understudy.addons.robots.team_network.load_plan import open_libraries
from understudy.errors import SettingError
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab.lossy_networks import study
from understudy_lab.lossy_networks.distributed_patrol import BEHAVIOR, ROBOTS, measure_cycles
from understudy_lab.lossy_networks.simulated_patrol import make_agents, make_lossy_fate, watch_agents
from understudy_lab.lossy_networks.simulated_robots import WORLD
from understudy_lab.patrol import practice
from understudy_lab.patrol.metrics import captures
from understudy_lab.patrol.practice import make_coordinated_team, teach
from understudy_lab.patrol.tracks import ATTACK, DISPERSE, HOME, PatrolTracks, watch


def row(one: int, well: int, loses: int) -> dict[str, Any]:
    """Six minutes each, with so many complete cycles."""
    counts = zip(study.NETWORKS, (one, well, loses), strict=True)
    return {"task": {"seed": 1}} | {
        network: {
            "minutes": 6.0,
            "cycles": count,
            "complete": count,
            "captures": count,
            "cycle_s": [30.0] * count,
        }
        for network, count in counts
    }


SHARES = [  # rows, shares of the cycles of one program, whether the goals are reached
    ([row(10, 9, 8)], (0.9, 0.8), (True, True)),
    ([row(10, 9, 8), row(10, 8, 8)], (0.85, 0.8), (False, True)),
    ([row(10, 10, 7)], (1.0, 0.7), (True, False)),
    ([row(0, 5, 5)], (0.0, 0.0), (False, False)),
]


@pytest.mark.parametrize(("rows", "shares", "held"), SHARES)
def test_cycles_are_compared_with_those_of_one_program(
    rows: list[dict[str, Any]], shares: tuple[float, float], held: tuple[bool, bool]
) -> None:
    found = study.EXPERIMENT.conclude(rows)
    assert [goal.measured for goal in found.goals] == [f"{share:.0%}" for share in shares]
    assert tuple(goal.held for goal in found.goals) == held
    assert found.numbers[study.ONE]["per_hour"] == 10 * sum(
        each[study.ONE]["complete"] for each in rows
    ) / len(rows)
    study.EXPERIMENT.draw(rows)


def test_who_is_not_root_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "find_obstacle", lambda: "network namespaces need root")
    with pytest.raises(SettingError, match="network namespaces need root"):
        study.work({"seed": 1})


def test_a_cycle_is_found_in_recordings(tmp_path: Path) -> None:
    """An intruder is there for the first 10 s; robots attack it, go home, and disperse after 30 s."""
    with (tmp_path / WORLD).open("w") as file:
        for tick in range(400):
            things = {"home": (5.0, 5.0, True), "intruder": (1.0, 1.0, tick < 100), "boss": (0.0, 0.0, False)}
            places = [(5.0, 5.0)] * len(ROBOTS)
            file.write(
                json.dumps({"at_s": tick / 10, "robots": places, "commands": [], "objects": things}) + "\n"
            )
    when = [(0.0, DISPERSE), (5.0, ATTACK), (10.2, HOME), (30.0, DISPERSE)]
    ticks = [tick / 10 for tick in range(400)]
    done = [(at_s, next(what for since_s, what in reversed(when) if at_s >= since_s)) for at_s in ticks]
    found = measure_cycles(tmp_path, dict.fromkeys(ROBOTS, done))
    assert (found["cycles"], found["complete"], found["captures"]) == (1, 1, 1)
    assert found["cycle_s"] == pytest.approx([20.0], abs=0.2)


def compare_agents(libraries: Libraries) -> PatrolTracks:
    """Let agents and one program patrol in the same world, and return what they do if it is the same."""
    one_program = watch(make_coordinated_team(libraries, [7], BEHAVIOR), 900)
    world = World(practice.scenario(), [7])
    agents = watch_agents(make_agents(libraries, world), world, 900)
    np.testing.assert_array_equal(agents.doing, one_program.doing)
    np.testing.assert_array_equal(agents.x, one_program.x)
    assert captures(agents) == captures(one_program)
    return agents


def test_agents_in_simulation_do_what_one_program_does(tmp_path: Path) -> None:
    """Tick for tick, so that without losses the simulation is that of `understudy experiment patrol`."""
    save_patrol(tmp_path)
    libraries = open_libraries(practice.scenario(), tmp_path)
    assert len(np.unique(compare_agents(libraries).doing)) > 1


def test_agents_of_a_taught_patrol_capture_what_one_program_does() -> None:
    assert captures(compare_agents(teach(1).libraries)) != []


def test_a_lossy_network_loses_and_delays_messages() -> None:
    fate = make_lossy_fate(3)
    arrived = Counter(tuple(fate("one", "two", 0)) for _ in range(10_000))
    assert set(arrived) == {(), (1,), (2,)}
    assert 1_800 < arrived[()] < 2_200
    assert 3_700 < arrived[(1,)] < 4_300
