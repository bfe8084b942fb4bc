"""Agents that decide for themselves do what a team in one program does, as long as nothing is lost or late."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.bodies import Scripted
from tests.robots.scale_team import make_plan
from tests.runtime.agents.test_lost_agents import make_team
from tests.runtime.random_libraries import Played, play_random_body
from tests.runtime.test_team import CASES, random_tree

from understudy.model.features import Percept
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.team.team import Team

TICKS = 25


class Failing(Played):
    """Agents some of which are out of action at times; now and then, a tick takes long."""

    def __init__(
        self, percepts: Sequence[Percept], ticks_s: Sequence[float], begin_s: float, down: NDArray[np.bool_]
    ) -> None:
        super().__init__(percepts, ticks_s, begin_s)
        self._down = down

    @property
    def failed(self) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = self._down[self.tick % len(self._down)]
        return found


def make_both(
    random: Random, robots: int, *, delay_ticks: int = 0
) -> tuple[Team, LocalTeam, Failing, Failing]:
    """A team in one program, and one of agents, with the same percepts; any sort runs what it was taught."""
    body = play_random_body(random, agents=robots, ticks=TICKS)
    ticks_s = [random.choice((each, 2.5)) if random.random() < 0.2 else each for each in body.ticks_s]
    down = np.array([[random.random() < 0.2 for _ in range(robots)] for _ in range(TICKS)], np.bool_)
    one, other = (Failing(body.percepts, ticks_s, body.time_s, down) for _ in range(2))
    tree, libraries, top = random_tree(random, robots)
    sort = random.choice([top, random.choice(tree.names)])
    name = list(libraries[sort].taught)[-1]
    bound = {each: random.choice(Played.targets) for each in libraries[sort].parameters(name)}
    roots = {sort: (name, bound)}
    team = Team(one, tree, libraries, roots, delay_s=delay_ticks * one.tick_s)
    plan = TeamPlan(
        tree,
        libraries,
        roots,
        readings={"robot": Played.readings},
        targets=Played.targets,
        only_led=True,
    )
    return team, LocalTeam(other, plan, LocalNetwork(lambda *_: [delay_ticks])), one, other


@pytest.mark.long
@settings(max_examples=120)
@given(CASES, st.integers(1, 5))
def test_agents_do_what_a_team_does(random: Random, robots: int) -> None:
    """Also where robots fail, where a computer is held up for seconds, and after a restart."""
    team, agents, one, other = make_both(random, robots)
    assert {sort: len(each) for sort, each in agents.programs.items()} == {
        sort: len(each) for sort, each in team.programs.items()
    }
    for tick in range(2 * TICKS):
        if tick == TICKS:
            team.clear()
            agents.clear()
        team.tick()
        agents.tick()
        assert agents.paths == team.paths
        assert one.commanded[-1] == other.commanded[-1]
        for sort in team._layers_of:
            raised = [each.find_raised(sort, {"done", "failed"}).tolist() for each in (team, agents)]
            assert raised[0] == raised[1]


@settings(max_examples=60)
@given(CASES, st.integers(1, 5), st.integers(1, 4))
def test_messages_that_all_take_as_long_are_as_in_a_scenario_with_a_radio(
    random: Random, robots: int, delay_ticks: int
) -> None:
    team, agents, one, other = make_both(random, robots, delay_ticks=delay_ticks)
    for each in (one, other):  # a radio counts even ticks
        each.time_s, each.ticks_s = 0.0, [each.tick_s]
    team.clear()
    agents.clear()
    for _ in range(TICKS):
        team.tick()
        agents.tick()
        assert agents.paths == team.paths
        assert one.commanded[-1] == other.commanded[-1]


@pytest.mark.parametrize("slow_s", [0.1, 3.0])
def test_slow_ticks_end_no_order(slow_s: float) -> None:
    """Who is held up together is not silent."""
    plan = make_team(LocalNetwork(), near=-1e9).plan
    body = Scripted(len(plan.robots))
    body.tick_s = slow_s
    team = LocalTeam(body, plan)
    for _ in range(30):
        team.tick()
        assert team.paths == [("go", "forward")] * len(plan.robots)
    assert {robot.beginnings for robot in team.robots.values()} == {1}


def test_squads_report_their_own_statistics_to_the_coordinator_above() -> None:
    """The coordinator of all squads decides on readings that only the squads below it compute."""
    plan = make_plan(24)
    body, other = Scripted(len(plan.robots)), Scripted(len(plan.robots))
    team = Team(body, plan.tree, plan.libraries, plan.roots)
    agents = LocalTeam(other, plan)
    seen = set()
    for _ in range(30):
        team.tick()
        agents.tick()
        assert agents.paths == team.paths
        seen |= {path[0] for path in agents.paths}
    assert seen == {"go_to_ball", "right"}
