"""Runs in failing worlds until shortly before they go wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from understudy.analysis.tracing import AgentRef, list_chain_of_command
from understudy.errors import SessionError, UnknownName
from understudy.falsification.failing_world import FailingWorld
from understudy.falsification.failure_moment import (
    FailureMoment,
    RunInstant,
    choose_instant,
    find_lesson,
    list_active,
)
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.run_loop import Run
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.squad_body import SquadBody
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_scenario_team
from understudy.sim.world import World


class FailingRun:
    """A failing world, run again tick by tick by interpreters.

    Parameters
    ----------
    failing
        The failing world.
    scenario
        Its scenario, with markers to place by hand.
    libraries
        The library of each sort of agents.
    roots
        What each sort of agents runs by itself.
    is_led
        Whether the robots follow coordinators. Otherwise all run the behavior, and no coordinator does anything.
    """

    def __init__(
        self,
        failing: FailingWorld,
        scenario: Scenario,
        libraries: Libraries,
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        is_led: bool,
    ) -> None:
        seed = failing.trial.seed
        self._world = World(scenario, [seed])
        self._team = make_scenario_team(self._world, scenario, libraries, roots, seeds=[seed])
        self._facts, self._libraries, self._is_led = failing.facts, libraries, is_led
        chain = list_chain_of_command(self._team, failing.facts.robot)
        self._between = chain[1:-1] if is_led else ()
        self._posts = [_Post(self._world, chain[-1])]
        if is_led and isinstance(chain[0].layer.body, SquadBody):
            self._posts.append(_Post(CoordinatorBody(self._team, chain[0].sort), chain[0]))

    def find_moment(self, ticks: int, until: int, *, name: str | None) -> FailureMoment:
        """Run the team, and choose the moment and the automaton to correct.

        Parameters
        ----------
        ticks
            The tick at which the session is to begin; below 1 for the start.
        until
            The tick at which the automaton that runs is the one that made the mistake.
        name
            The automaton to correct. None: the innermost one with a lesson, the robot's before its coordinator's.

        Returns
        -------
        FailureMoment
            The moment.

        Raises
        ------
        UnknownName
            If no automaton of that name ran then.
        SessionError
            If it has no lesson, or is that of a coordinator below another one.
        """
        starts = [post.body.snapshot() for post in self._posts]
        first = max(1, ticks)
        for _ in range(first - 1):
            self._team.tick()
        seen: list[list[RunInstant]] = [[] for _ in self._posts]
        for _ in range(first, max(first, until) + 1):
            self._team.tick()
            for post, instants in zip(self._posts, seen, strict=True):
                instants.append(post.note_instant())
        number = self._choose_post(seen, name)
        post, instants = self._posts[number], seen[number]
        library = self._libraries[post.agent.sort]
        instant, level = choose_instant(instants, library, name)
        automaton, targets = instant.active[level]
        lesson = find_lesson(library, automaton)
        is_start = ticks < 1 and instant is instants[0]
        post.body.restore(starts[number] if is_start else instant.body)
        return FailureMoment(
            self._world,
            post.body,
            post.agent.agent,
            automaton,
            lesson,
            library,
            targets,
            () if is_start else instant.states[level:],
            self._facts.behavior.removeprefix(f"{post.agent.sort}/"),
            self._facts.binding,
            instant.members if self._is_led else (),
            instant.others if self._is_led else None,
        )

    def _choose_post(self, seen: list[list[RunInstant]], name: str | None) -> int:
        """Return the number of the agent whose automaton is corrected: the robot, or the topmost coordinator."""
        ends = [instants[-1].active for instants in seen]
        if name is None:
            for number, active in enumerate(ends):
                taught = self._libraries[self._posts[number].agent.sort].taught
                if any(taught[each].lesson is not None for each, _ in active):
                    return number
            return next((number for number, active in enumerate(ends) if active), 0)
        for number, instants in enumerate(seen):
            if any(name == each for instant in instants for each, _ in instant.active):
                return number
        if any(name in self._libraries[each.sort].taught for each in self._between):
            raise SessionError(
                f"{name!r} is that of a coordinator below another one, which cannot be trained in its team: name an "
                "automaton of the robot or of the topmost coordinator"
            )
        known = [each for active in ends for each, _ in active]
        raise UnknownName(what="automaton", name=name, where="the run at this moment", known=known)


class _Post(NamedTuple):
    """An agent that can be corrected, and the body on which a session trains it."""

    body: World | CoordinatorBody
    agent: AgentRef

    def note_instant(self) -> RunInstant:
        """Note the present instant of the run, with the run states of all agents of the body."""
        interpreters, now = _list_interpreters(self.agent.layer), self.body.time_s
        driver = interpreters[self.agent.agent]
        others = tuple(each.snapshot(now) for each in interpreters)
        members = tuple(interpreters) if isinstance(self.body, World) else ()
        return RunInstant(
            self.body.snapshot(), list_active(driver), others[self.agent.agent], members, others
        )


def _list_interpreters(layer: AgentLayer) -> list[Interpreter]:
    if not isinstance(layer.runner, Run):
        raise TypeError("an engine runs this team")
    return layer.runner.interpreters
