"""The swarm: many platoons are like a few, and one world's coordinators lead whatever threads there are."""

from __future__ import annotations

import pytest

from understudy.runtime.team.team import Team
from understudy.sim import step
from understudy.sim.team.libraries import make_team
from understudy.sim.world import World
from understudy_lab.tasks.swarm_world import SWARM, make_expert_libraries, of_platoons, scenario


def test_eight_platoons_are_the_swarm_that_ships() -> None:
    assert of_platoons(8) == scenario()


def make_swarm_team() -> Team:
    return make_team(scenario(), [4], make_expert_libraries(), {SWARM: ("swarm_work", {})})


def outcome(team: Team) -> tuple[bytes, list[tuple[str, ...]]]:
    assert isinstance(team.ground, World)
    return team.ground.snapshot(), team.paths


def test_threads_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three levels of coordinators over the robots of one world, on which several threads work."""
    ticked, alone, together = make_swarm_team(), make_swarm_team(), make_swarm_team()
    alone.run(300)
    monkeypatch.setattr(step, "ALONE", 1)
    monkeypatch.setattr(step, "MOST_TICKS", 70)
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    together.run(300)
    assert outcome(together) == outcome(alone)
    for _ in range(120):
        ticked.tick()
    short = make_swarm_team()
    short.run(120)
    assert outcome(short) == outcome(ticked)
