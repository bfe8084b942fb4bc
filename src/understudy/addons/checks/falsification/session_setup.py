"""The setup of a session, to be run in other worlds: the trained agent, and the programs of all other agents.

A robot is trained in a world, in which other robots idle or run a behavior; or the coordinator of a squad, whose
members follow its orders while other coordinators of its sort idle or run a behavior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import ProgramRun, TeamRun, find_raised_times, mark_agent
from understudy.judging.properties.offered_goals import offer_goals
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import IDLING, Program, link
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.training.session import Session


class CoordinatorRun(TeamRun):
    """A behavior that one coordinator of each world runs, with its members; many ticks at once where possible."""

    def __init__(
        self, team: Team, sort: str, library: Library, call: tuple[str, Mapping[str, str]], agent: int
    ) -> None:
        super().__init__(team, {sort: library}, {sort: call}, agent=agent)
        self._runner = team.layer(sort).runner
        self._chosen = agent
        self.own_robots = team.tree.mark_robots_below(sort, agent)

    @property
    def is_fused(self) -> bool:
        """Whether many ticks can be run at once."""
        return True

    @property
    def knows_times(self) -> bool:
        """True if `find_raised_s` can be called at any time after a flag was raised."""
        return True

    def _advance(self, ticks: int, *, to_goal: bool, ended: NDArray[np.bool_] | None) -> None:
        self._team.run(ticks)

    def find_raised_s(self, flag: str) -> NDArray[np.float64]:
        """Return when the coordinator of each world raised a flag [B, 1], s; NaN where it has not."""
        if not isinstance(self._runner, Engine):
            raise TypeError("interpreters run this team")
        times = find_raised_times(self._runner, flag, worlds=self.worlds)
        return times[:, mark_agent(self._chosen, times.shape[1])]


@dataclass(frozen=True)
class SessionSetup:
    """The setup of a session: the scenario, the trained agent, and the programs of all other agents.

    Parameters
    ----------
    scenario
        The scenario of the world.
    agent
        The agent that is trained: a robot, or a coordinator among those of its sort.
    others
        What each robot, or each coordinator of the sort, runs from the start of a world; that at `agent` is not used.
        Empty: there are no others.
    team
        The team whose coordinators are trained. None: a robot is.
    sort
        The sort of these coordinators.
    """

    scenario: Scenario
    agent: int = 0
    others: Sequence[Program] = ()
    team: Team | None = None
    sort: str = ""

    @classmethod
    def from_session(cls, session: Session) -> Self | None:
        """Return what a session runs; None if its body is none of which there are other worlds."""
        body, others = session.body, session.other_agents.programs
        if isinstance(body, World):
            return cls(body.scenario, session.agent, others)
        if isinstance(body, CoordinatorBody) and isinstance(body.ground, World):
            return cls(body.ground.scenario, session.agent, others, body.team, body.squads.squad.name)
        return None

    @property
    def idle_agents(self) -> int:
        """The number of other agents that idle."""
        return sum(program.root == IDLING for program in self._list_others())

    @property
    def do_others_move(self) -> bool:
        """Whether other robots than the trained one may move."""
        return self.team is not None or self.idle_agents < len(self._list_others())

    def _list_others(self) -> list[Program]:
        return [program for agent, program in enumerate(self.others) if agent != self.agent]

    @property
    def robots(self) -> int:
        """The number of robots in a world."""
        return max(1, len(self.others)) if self.team is None else len(self.team.tree.type_of)

    @property
    def own_robots(self) -> NDArray[np.bool_]:
        """Which robots of a world a goal is about [N]: the one that is trained, or those that follow who is."""
        if self.team is not None:
            return self.team.tree.mark_robots_below(self.sort, self.agent)
        return mark_agent(self.agent, self.robots)

    def describe_others(self, behavior: str) -> str:
        """Return in words what the others do while one runs a behavior: "the other robots idle"; empty without any."""
        others = self._list_others()
        if not others:
            return ""
        who = "robot" if self.team is None else "coordinator"
        names = {_describe_root(each, behavior) for each in others if each.root != IDLING}
        plural, one = ("s", "") if len(others) > 1 else ("", "s")
        doing = f"run{one} {', '.join(sorted(names))}" if names else f"idle{one}"
        return f"the other {who}{plural} {doing}"

    def start(
        self, seeds: Sequence[int], library: Library, behavior: str, binding: Mapping[str, str]
    ) -> ProgramRun | CoordinatorRun:
        """Start a behavior as the session runs it, in the worlds of some seeds.

        Parameters
        ----------
        seeds
            The seed of each world.
        library
            The library of the trained agent.
        behavior
            The behavior that it runs.
        binding
            The target of each parameter.

        Returns
        -------
        ProgramRun | CoordinatorRun
            The run before the first tick, whose flags and readings are those of the trained agent only.

        Raises
        ------
        UnboundParameter
            If a parameter is not bound to a target.
        """
        world, program = World(self.scenario, seeds), link(library, behavior, binding)
        if self.team is None:
            others = self.others or [program]
            return ProgramRun(world, program, library, binding, agent=self.agent, others=others)
        programs = [*self.others]
        programs[self.agent] = program
        team = self.team.with_ground(world, seeds, {self.sort: programs})
        return CoordinatorRun(team, self.sort, library, (behavior, binding), self.agent)


def offer_session_goals(session: Session) -> tuple[Property, ...]:
    """List goals that fit what was shown in a session, about the robots that count there; see `offer_goals`."""
    setup, body = SessionSetup.from_session(session), session.body
    world = body.ground if isinstance(body, CoordinatorBody) else body
    if setup is None or not isinstance(world, World):
        return ()
    robots, leads = setup.own_robots, setup.team is not None
    return offer_goals(session.lesson, world, robots=robots, of_coordinator=leads)


def _describe_root(program: Program, trained: str) -> str:
    """Return what a program runs in words; an automaton that is in training elsewhere is the one that was saved."""
    root = program.root
    if isinstance(root, int):
        return str(program.basics[root])
    return f"{root} as saved" if root.automaton.name == trained else str(root)
