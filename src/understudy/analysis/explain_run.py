"""Why a robot of a recorded run did what it did: the run is made again until then, and every level asked.

A run is the same each time (ARCHITECTURE section 3), so nothing of it has to be kept but how it was made. Where it does
not come out the same, that is said, and no reason is given.
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
"""How far apart two numbers of a trace may be that are the same but for rounding."""


class RunNotReproducible(UnderstudyError, json_type="CannotRepeat"):
    """A run that does not come out as it was recorded: something it was made with has changed since."""

    exit_code = 1

    def __init__(self, *, problem: str, remedy: str) -> None:
        self.problem, self.remedy = problem, remedy
        super().__init__(f"the run cannot be repeated: {problem}; {remedy}")


@dataclass(frozen=True, slots=True)
class DecisionReason:
    """A decision with what was behind it. `moments` says for an example's number when it was shown, s of the
    demonstrator's time in the session in which it was.
    """

    time_s: float
    automaton: str
    explanation: Explanation
    values: Mapping[str, float]
    moments: Mapping[int, float]
    taught: TrainedAutomaton

    @property
    def is_switch(self) -> bool:
        """Whether it left its state."""
        return self.explanation.next != self.explanation.state


@dataclass(frozen=True, slots=True)
class LevelExplanation:
    """One automaton of an agent: where it is and since when, why it decided so in this tick (None: nothing was there
    to decide), and why it had gone there (None: it began there). `flag` is the one that its state raises.
    """

    automaton: str
    state: str
    since_s: float
    decision: DecisionReason | None
    entry: DecisionReason | None
    flag: str | None


@dataclass(frozen=True, slots=True)
class AgentExplanation:
    """One agent, from a coordinator at the top to the robot: what it was ordered to do, and its levels."""

    sort: str
    agent: int
    ordered: str | None
    levels: tuple[LevelExplanation, ...]


@dataclass(frozen=True, slots=True)
class RunExplanation:
    """What all levels decided in the tick that ended at `time_s`, and the last switch of any before it."""

    time_s: float
    decided_s: float
    agents: tuple[AgentExplanation, ...]
    last: DecisionReason | None

    @property
    def has_switch(self) -> bool:
        """Whether some level switched in this tick."""
        return any(
            level.decision is not None and level.decision.is_switch
            for each in self.agents
            for level in each.levels
        )


def explain_run(run: RecordedTick, scenario: Scenario, libraries: Libraries) -> RunExplanation:
    """Why the robot did what the trace says of it then; CannotRepeat where it now comes out otherwise."""
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
    """The last switch before this tick of a robot and of all above it."""
    lasts = [(find_traced_run(post).last, libraries[post.sort].taught) for post in chain]
    switches = [(machine, query, taught) for last, taught in lasts if last for machine, query in [last]]
    found = max(switches, key=lambda each: each[1].time_s, default=None)
    if found is None:
        return None
    machine, query, taught = found
    return explain_query(str(machine.instance), query, taught[machine.automaton.name])


def _check(world: World, path: tuple[str, ...], run: RecordedTick) -> None:
    """Refuse to explain another run than the one that was recorded."""
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
    """What an agent was asked in this tick, level by level."""
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
    """What was behind the answer to a query of an automaton, which ran as `name`: goto(station)."""
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
