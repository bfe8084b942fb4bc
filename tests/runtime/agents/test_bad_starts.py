"""Teams that are started badly: a coordinator without members, and computers whose clocks are an hour off."""

from __future__ import annotations

from tests.runtime.agents.test_lost_agents import NAMES, ROBOTS, make_team

from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.local_team import BodyRow, LocalTeam
from understudy.runtime.agents.network import LocalNetwork

HOUR_S = 3600.0


class OtherClock(BodyRow):
    """A robot whose computer's clock is off."""

    def __init__(self, row: BodyRow, off_s: float) -> None:
        super().__init__(row.ground, row._row)
        self._off_s = off_s

    @property
    def time_s(self) -> float:
        return super().time_s + self._off_s


def test_a_coordinator_whose_members_nobody_started_orders_nothing_and_says_so() -> None:
    team = make_team(LocalNetwork())
    for name in NAMES:
        team.stop(name)
    team.run(30)
    coordinator = team.coordinators["pair_0"]["pair_0"]
    problems = [members.find_problem(each) for members in coordinator.members for each in members.members]
    assert problems == ["was never heard"] * ROBOTS
    assert coordinator.agent.percept["all_done", None][0] == 0.0  # nobody is done where nobody is
    assert team.paths == [()] * ROBOTS


def run_with_clocks(off: dict[str, float]) -> list[list[tuple[str, ...]]]:
    """What robots do, tick by tick, on computers whose clocks are off by so many seconds."""
    team = make_team(LocalNetwork())
    for name, off_s in off.items():
        node = team.network.join(name)
        node.announce(name)
        if name in team.rows:
            team.rows[name] = clock = OtherClock(team.rows[name], off_s)
            team.robots[name] = Agent(team.plan.make_agent_spec(name), clock, node)
        else:
            clock = OtherClock(BodyRow(team.snapshot, 0), off_s)
        for squad in team.plan.list_led_squads(name):
            team.coordinators[squad][name] = make_coordinator(team, squad, name, clock)
    found = []
    for _ in range(70):
        team.tick()
        found.append(team.paths)
    return found


def make_coordinator(team: LocalTeam, squad: str, name: str, clock: OtherClock) -> SquadCoordinator:
    return SquadCoordinator(
        team.plan.make_agent_spec(squad),
        team.plan.make_squad_spec(squad),
        host=name,
        candidates=team.plan.list_candidates(squad),
        clock=clock,
        network=team.network._nodes[name],
        leads=name == squad,
    )


def test_clocks_that_are_an_hour_off_change_nothing() -> None:
    """No time in a message is compared with another computer's clock."""
    right = run_with_clocks({"pair_0": 0.0, "scout_2": 0.0})
    assert run_with_clocks({"pair_0": -HOUR_S, "scout_2": HOUR_S}) == right
    assert right[-1] == [("left",)] * ROBOTS
