"""Agents that decide for themselves do what a team in one program does, as long as nothing is lost or late."""

from __future__ import annotations

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import Scripted
from tests.robots.scale_team import make_plan
from tests.runtime.random_libraries import Played, played
from tests.runtime.test_team import CASES, random_tree

from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.runtime.team.team import Team


@settings(max_examples=80)
@given(CASES, st.integers(1, 5))
def test_agents_do_what_a_team_does(random: Random, robots: int) -> None:
    body = played(random, agents=robots, ticks=25)
    other = Played(body.percepts, body.ticks_s, body.time_s)
    tree, libraries, top = random_tree(random, robots)
    name = list(libraries[top].taught)[-1]
    bound = {each: random.choice(Played.targets) for each in libraries[top].parameters(name)}
    roots = {top: (name, bound)}
    team = Team(body, tree, libraries, roots)
    plan = TeamPlan(tree, libraries, roots, readings={"robot": Played.readings}, targets=Played.targets)
    agents = LocalTeam(other, plan)
    for _ in range(25):
        team.tick()
        agents.tick()
        assert agents.paths == team.paths
        assert body.commanded[-1] == other.commanded[-1]


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
