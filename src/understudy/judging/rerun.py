"""Reruns: automata run again in a simulated world, or over the readings of a recording, with their queries traced."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence

import msgspec

from understudy.errors import UnderstudyError
from understudy.judging.tracing import AgentRef, TracedRun, list_chain_of_command, make_tracing_runner
from understudy.model.binding import Binding
from understudy.records.reader import RecordedDuty, Recording
from understudy.records.record import RESTART
from understudy.records.replay import ReplayBody
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import IDLE_PROGRAM, Program
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.team import Team
from understudy.runtime.team.team_programs import make_finder
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries, make_scenario_team
from understudy.sim.world import World


class TracedRerun(ABC):
    """A run that is made again tick by tick, of which decisions are traced.

    Parameters
    ----------
    libraries
        The library of each sort of agents.
    """

    def __init__(self, libraries: Libraries) -> None:
        self.libraries = libraries

    @property
    @abstractmethod
    def tick_count(self) -> int:
        """The number of ticks that have passed."""

    @property
    @abstractmethod
    def paths(self) -> list[tuple[str, ...]]:
        """The states that each robot is in, outermost first."""

    @abstractmethod
    def tick(self) -> None:
        """Let all agents sense, decide and act once."""

    @abstractmethod
    def list_chain(self, robot: int) -> tuple[AgentRef, ...]:
        """List a robot and all coordinators above it, the topmost first."""

    def trace(self, robot: int) -> None:
        """Record the queries of a robot, and of all coordinators above it, from now on."""
        for post in self.list_chain(robot):
            find_traced_run(post).follow(post.agent)

    def replay_to(self, tick: int, look: Callable[[], object] = lambda: None) -> None:
        """Run until so many ticks have passed, and call `look` after each."""
        while self.tick_count < tick:
            self.tick()
            look()


class WorldRerun(TracedRerun):
    """The team of a scenario that runs again in a simulated world, bit for bit as it ran there before.

    Parameters
    ----------
    scenario
        The scenario.
    seed
        The seed of the world.
    libraries
        The library of each sort of agents.
    roots
        What each sort of agents runs by itself.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int,
        libraries: Libraries,
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
    ) -> None:
        super().__init__(libraries)
        self.world = World(scenario, [seed])
        self.team = make_scenario_team(
            self.world, scenario, libraries, roots, seeds=[seed], makes=make_tracing_runner
        )
        self._ticks = 0

    @property
    def tick_count(self) -> int:
        """The number of ticks that have passed."""
        return self._ticks

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """The states that each robot is in, outermost first."""
        return self.team.paths

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        self.team.tick()
        self._ticks += 1

    def list_chain(self, robot: int) -> tuple[AgentRef, ...]:
        """List a robot and all coordinators above it, the topmost first."""
        return list_chain_of_command(self.team, robot)


class Rerun(TracedRerun):
    """Agents of the given sorts that run a behavior over a recording, restarted at the recorded moments.

    They form the scenario's team if as many agents were recorded as it has robots; otherwise each runs alone. An agent
    of a team that decided for itself begins what it began then: what an order told it, or what it runs without one.
    """

    def __init__(
        self,
        recording: Recording,
        libraries: Libraries,
        sorts: Sequence[str],
        behavior: str | None,
        *,
        binding: Mapping[str, str],
        scenario: Scenario | None = None,
    ) -> None:
        super().__init__(libraries)
        self.recording = recording
        self._body = ReplayBody(recording.records, recording.head)
        self._team: Team | None = None
        self._begun: dict[int, list[RecordedDuty]] = {}
        members = -1 if scenario is None else len(assign_team_members(scenario).type_of)
        decided_alone = isinstance(recording.head.ran.agent, str)
        if (
            scenario is not None
            and behavior is not None
            and members == self._body.agents
            and not decided_alone
        ):
            seeds, roots = [recording.head.ran.seed], dict.fromkeys(sorts, (behavior, Binding(binding)))
            self._team = make_scenario_team(
                self._body, scenario, libraries, roots, seeds=seeds, makes=make_tracing_runner
            )
        else:
            self._find = make_finder(libraries[sorts[0]], sorts[0])
            self._root = IDLE_PROGRAM if behavior is None else self._find(behavior, Binding(binding))
            now = self._body.time_s
            for duty in (duty for each in recording.duties for duty in each):
                self._begun.setdefault(duty.tick, []).append(duty)
            others = [self._find_begun(duty) for each in self._begun.values() for duty in each]
            self._alone = TracedRun(
                self._body,
                [Interpreter(self._root, now=now) for _ in range(self._body.agents)],
                [IDLE_PROGRAM, *others],
            )
            self._layer, self._sort = AgentLayer(self._body, self._alone), sorts[0]
        for agent in range(self._body.agents):
            self.trace(agent)
        self._restarts = {
            (press.tick, agent): press.at_s
            for agent, record in enumerate(recording.records)
            for press in record.presses
            if press.does == RESTART
        }

    @property
    def tick_count(self) -> int:
        """The number of ticks that have passed."""
        return self._body.tick

    @property
    def is_over(self) -> bool:
        """True if all ticks of the recording have passed."""
        return self._body.is_over

    def tick(self) -> None:
        """Run all agents over one more tick of the recording."""
        for agent in range(self._body.agents):
            if (self.tick_count, agent) in self._restarts:
                self._body.wait(self._restarts[self.tick_count, agent])
                self._restart(agent)
        for duty in self._begun.get(self.tick_count, ()):
            self._begin(duty)
        if self._team is not None:
            self._team.tick()
        else:
            self._alone.tick()

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """The states that each robot is in, outermost first."""
        if self._team is not None:
            return self._team.paths
        return [each.path for each in self._alone.interpreters]

    def list_chain(self, robot: int) -> tuple[AgentRef, ...]:
        """List a robot and all coordinators above it, the topmost first; it alone without a team."""
        if self._team is not None:
            return list_chain_of_command(self._team, robot)
        return (AgentRef(self._sort, robot, self._layer, None),)

    def _restart(self, agent: int) -> None:
        """Restart an agent; in a team, restart the whole team."""
        if self._team is not None:
            self._team.clear()
        else:
            self._alone.interpreters[agent].start(self._body.time_s)

    def _begin(self, duty: RecordedDuty) -> None:
        """Let the agent begin what it began at this tick, or go on in the run state that it took over."""
        self._body.wait(duty.time_s)
        self._alone.begin([0], self._find_begun(duty))
        if duty.frames:
            frames = msgspec.json.decode(duty.frames, type=list[StackFrame])
            self._alone.interpreters[0].restore(frames, now=duty.time_s)

    def _find_begun(self, duty: RecordedDuty) -> Program:
        if duty.alone:
            return self._root
        try:
            return self._find(duty.behavior, Binding(duty.binding)) if duty.behavior else IDLE_PROGRAM
        except UnderstudyError:  # agents do nothing if they are ordered to what they do not have
            return IDLE_PROGRAM


def find_traced_run(post: AgentRef) -> TracedRun:
    """Return the traced run of an agent; raise TypeError if its runner records no queries."""
    if not isinstance(post.layer.runner, TracedRun):
        raise TypeError("agents that cannot be followed")
    return post.layer.runner
