"""Explanations of recorded runs: the run is repeated up to a tick, and the decision of every level is explained.

Runs can be repeated exactly (docs/semantics.md), so a recording only has to say how the run was made. If the
repeated run differs from the recorded one, an error is raised and nothing is explained.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose

from understudy.analysis.rerun import find_traced_run
from understudy.analysis.run_header import RecordedTick
from understudy.analysis.run_trace import BETWEEN
from understudy.analysis.tracing import (
    ActiveAutomaton,
    AgentRef,
    TransitionQuery,
    list_chain_of_command,
    make_tracing_runner,
)
from understudy.errors import UnderstudyError
from understudy.learning.explain import Explanation, explain
from understudy.model.lesson import Example, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_scenario_team
from understudy.sim.world import World

NEAR = 2e-6
"""The largest difference of two numbers in traces that count as equal, because they are rounded."""


class RunNotReproducible(UnderstudyError, json_type="CannotRepeat"):
    """A recorded run that comes out differently now, because something it depends on has changed."""

    exit_code = 1

    def __init__(self, *, problem: str, remedy: str) -> None:
        self.problem, self.remedy = problem, remedy
        super().__init__(f"the run cannot be repeated: {problem}; {remedy}")


@dataclass(frozen=True, slots=True)
class DecisionReason:
    """A decision with its explanation.

    `moments` has, by number of an example, when it was recorded, in s since its session began.
    """

    time_s: float
    automaton: str
    explanation: Explanation
    values: Mapping[str, float]
    moments: Mapping[int, float]
    taught: TrainedAutomaton

    @property
    def is_switch(self) -> bool:
        """True if the decision led to another state."""
        return self.explanation.next != self.explanation.state


@dataclass(frozen=True, slots=True)
class LevelExplanation:
    """One automaton of an agent: its state, since when, and the decisions behind it.

    `decision` is that of the explained tick; None if there was nothing to decide. `entry` is the decision that
    entered the state; None if the automaton started there. `flag` is the flag that the state raises, if any.
    """

    automaton: str
    state: str
    since_s: float
    decision: DecisionReason | None
    entry: DecisionReason | None
    flag: str | None


@dataclass(frozen=True, slots=True)
class AgentExplanation:
    """One agent, a coordinator or the robot: the last order it got, and its running automata, the root first.

    `ordered` is None if no coordinator is above the agent.
    """

    sort: str
    agent: int
    ordered: str | None
    levels: tuple[LevelExplanation, ...]


@dataclass(frozen=True, slots=True)
class RunExplanation:
    """The decisions of all levels in one tick.

    `decided_s` is when they were made, and `time_s` the end of the tick. `last` is the last switch before this tick.
    """

    time_s: float
    decided_s: float
    agents: tuple[AgentExplanation, ...]
    last: DecisionReason | None

    @property
    def has_switch(self) -> bool:
        """True if an automaton at any level changed its state in this tick."""
        return any(
            level.decision is not None and level.decision.is_switch
            for each in self.agents
            for level in each.levels
        )


def explain_run(run: RecordedTick, scenario: Scenario, libraries: Libraries) -> RunExplanation:
    """Explain the decisions at a recorded tick by repeating the run.

    RunNotReproducible is raised if the run comes out differently now.
    """
    ran, world = run.ran, World(scenario, [run.header.seed])
    roots = dict.fromkeys(ran.sorts, (run.behavior, ran.binding))
    team = make_scenario_team(world, scenario, libraries, roots, seeds=world.seeds, makes=make_tracing_runner)
    chain = list_chain_of_command(team, run.row.robot)
    for post in chain:
        find_traced_run(post).follow(post.agent)
    for _ in range(run.ticks):
        team.tick()
    _check(world, team.paths[run.row.robot], run)
    decided_s = run.row.time_s - run.header.tick_s
    agents = tuple(explain_agent(post, libraries[post.sort].taught) for post in chain)
    return RunExplanation(run.row.time_s, decided_s, agents, find_latest_switch(chain, libraries))


def find_latest_switch(chain: Sequence[AgentRef], libraries: Libraries) -> DecisionReason | None:
    """Return the last switch before this tick of a robot and all coordinators above it, or None if there was none."""
    lasts = [
        (find_traced_run(post).last_switches.get(post.agent), libraries[post.sort].taught) for post in chain
    ]
    switches = [(machine, query, taught) for last, taught in lasts if last for machine, query in [last]]
    found = max(switches, key=lambda each: each[1].time_s, default=None)
    if found is None:
        return None
    machine, query, taught = found
    return explain_query(str(machine.instance), query, taught[machine.automaton.name])


def _check(world: World, path: tuple[str, ...], run: RecordedTick) -> None:
    """Refuse a repeated run that differs from the recorded one at this tick."""
    row, robots = run.row, world.view().robots
    now = [float(column[row.robot]) for column in (robots.x, robots.y, robots.heading)]
    same = all(
        isclose(one, other, rel_tol=0.0, abs_tol=NEAR)
        for one, other in zip(now, (row.x, row.y, row.heading), strict=True)
    )
    if not same or (path and BETWEEN.join(path) != row.doing):
        problem = f"at {row.time_s:g} s robot {row.robot} was to be in {row.doing!r}"
        remedy = (
            "its world, its kit or Understudy is another since, so run it again with --trace, and ask that"
        )
        raise RunNotReproducible(
            problem=f"{problem}, and is in {BETWEEN.join(path)!r} or elsewhere", remedy=remedy
        )


def explain_agent(post: AgentRef, taught: Mapping[str, TrainedAutomaton]) -> AgentExplanation:
    """Explain the decisions of an agent in this tick, level by level."""
    levels = tuple(_level(each, taught) for each in find_traced_run(post).list_active(post.agent))
    return AgentExplanation(post.sort, post.agent, post.last_order, levels)


def _level(stood: ActiveAutomaton, taught: Mapping[str, TrainedAutomaton]) -> LevelExplanation:
    machine = stood.machine
    automaton, name = machine.automaton, str(machine.instance)
    known = taught[automaton.name]
    return LevelExplanation(
        name,
        machine.state_name,
        stood.entered_s,
        None if stood.asked is None else explain_query(name, stood.asked, known),
        None if stood.entry is None else explain_query(name, stood.entry, known),
        automaton.states[machine.state].flag,
    )


def explain_query(name: str, query: TransitionQuery, taught: TrainedAutomaton) -> DecisionReason:
    """Explain the answer to a query of an automaton.

    `name` is the automaton with its arguments, such as "goto(station)".
    """
    automaton = taught.automaton
    state = automaton.states[query.before].name
    lesson = taught.lesson or Lesson(replace(automaton, transitions={}))
    found = explain(lesson, state, query.values, automaton.transitions.get(state))
    values = {str(bound): value for bound, value in zip(automaton.features, query.values, strict=True)}
    return DecisionReason(query.time_s, name, found, values, _moments(lesson, found.examples), taught)


def _moments(lesson: Lesson, examples: tuple[Example, ...]) -> dict[int, float]:
    seconds = lesson.record.seconds
    return {
        each.number: round(float(seconds[each.moment]), 6)
        for each in examples
        if each.moment is not None and each.moment < len(seconds)
    }
