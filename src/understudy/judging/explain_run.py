"""Explanations of recorded runs: the run is repeated up to a tick, and the decision of every level is explained.

Runs can be repeated exactly (docs/semantics.md), so a recording only has to say how the run was made. If the
repeated run differs from the recorded one, an error is raised and nothing is explained.

Recorded decisions are also compared with those that the automata make now from the same recorded readings. The automata
run through the whole recording. After a first difference the robot would have moved differently, and so have had other
readings than the recorded ones; so the first difference counts most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose

from understudy.errors import UnderstudyError
from understudy.judging.rerun import Rerun, TracedRerun, WorldRerun, find_traced_run
from understudy.judging.run_header import RecordedTick
from understudy.judging.tracing import (
    ActiveAutomaton,
    AgentRef,
    TransitionQuery,
)
from understudy.learning.explain import Explanation, explain
from understudy.model.lesson import Example, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.records.message_types import detect_state_change
from understudy.records.record import BETWEEN
from understudy.runtime.interpreter import RunningAutomaton
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
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
    roots = dict.fromkeys(run.ran.sorts, (run.behavior, run.ran.binding))
    rerun = WorldRerun(scenario, run.header.seed, libraries, roots)
    rerun.trace(run.robot)
    rerun.replay_to(run.ticks)
    _check(rerun.world, rerun.paths[run.robot], run)
    return _explain_tick(rerun, run.robot, run.time_s, run.time_s - run.header.tick_s)


def _explain_tick(rerun: TracedRerun, robot: int, time_s: float, decided_s: float) -> RunExplanation:
    """Explain the decisions of a robot, and of all coordinators above it, in the last tick of a rerun."""
    agents = tuple(
        _explain_agent(post, rerun.libraries[post.sort].taught) for post in rerun.list_chain(robot)
    )
    return RunExplanation(time_s, decided_s, agents, find_latest_switch(rerun, robot))


def find_latest_switch(rerun: TracedRerun, robot: int) -> DecisionReason | None:
    """Return the last switch before this tick of a robot and all coordinators above it, or None if there was none."""
    lasts = [
        (find_traced_run(post).last_switches.get(post.agent), rerun.libraries[post.sort].taught)
        for post in rerun.list_chain(robot)
    ]
    switches = [(machine, query, taught) for last, taught in lasts if last for machine, query in [last]]
    latest = max(switches, key=lambda each: each[1].time_s, default=None)
    if latest is None:
        return None
    machine, query, taught = latest
    return explain_answer(machine, query, taught)


def _check(world: World, path: tuple[str, ...], run: RecordedTick) -> None:
    """Refuse a repeated run that differs from the recorded one at this tick."""
    now = [float(column[run.robot]) for column in world.view().pose.values()]
    same = all(
        isclose(one, other, rel_tol=0.0, abs_tol=NEAR) for one, other in zip(now, run.pose, strict=True)
    )
    if not same or (path and BETWEEN.join(path) != run.format_states()):
        problem = f"at {run.time_s:g} s robot {run.robot} was to be in {run.format_states()!r}"
        remedy = (
            "its world, its kit or Understudy is another since, so run it again with --trace, and ask that"
        )
        raise RunNotReproducible(
            problem=f"{problem}, and is in {BETWEEN.join(path)!r} or elsewhere", remedy=remedy
        )


def _explain_agent(post: AgentRef, taught: Mapping[str, TrainedAutomaton]) -> AgentExplanation:
    """Explain the decisions of an agent in this tick, level by level."""
    levels = tuple(_level(each, taught) for each in find_traced_run(post).list_active(post.agent))
    return AgentExplanation(post.sort, post.agent, post.last_order, levels)


def _level(stood: ActiveAutomaton, taught: Mapping[str, TrainedAutomaton]) -> LevelExplanation:
    machine = stood.machine
    return LevelExplanation(
        str(machine.instance),
        machine.state_name,
        stood.entered_s,
        None if stood.query is None else explain_answer(machine, stood.query, taught),
        None if stood.entry is None else explain_answer(machine, stood.entry, taught),
        machine.automaton.states[machine.state].flag,
    )


def explain_answer(
    machine: RunningAutomaton, query: TransitionQuery, taught: Mapping[str, TrainedAutomaton]
) -> DecisionReason:
    """Explain the answer to a query of a running automaton, which is one of those that were taught."""
    return explain_query(str(machine.instance), query, taught[machine.automaton.name])


def explain_query(name: str, query: TransitionQuery, taught: TrainedAutomaton) -> DecisionReason:
    """Explain the answer to a query of an automaton.

    `name` is the automaton with its arguments, such as "goto(station)".
    """
    automaton = taught.automaton
    state = automaton.states[query.before].name
    lesson = taught.lesson or Lesson(replace(automaton, transitions={}))
    explanation = explain(lesson, state, query.values, automaton.transitions.get(state))
    values = {str(bound): value for bound, value in zip(automaton.features, query.values, strict=True)}
    return DecisionReason(
        query.time_s, name, explanation, values, _moments(lesson, explanation.examples), taught
    )


def _moments(lesson: Lesson, examples: tuple[Example, ...]) -> dict[int, float]:
    seconds = lesson.record.seconds
    return {
        each.number: round(float(seconds[each.moment]), 6)
        for each in examples
        if each.moment is not None and each.moment < len(seconds)
    }


@dataclass(frozen=True, slots=True)
class DecisionDiff:
    """A period of consecutive ticks in which an agent is in other states than recorded.

    It lasts from `from_s` to `until_s`, inclusive. `recorded` and `now` are the paths of states in its first tick.
    `reason` is the decision that led there; None if the automata have another structure than then.
    """

    agent: int
    from_s: float
    until_s: float
    ticks: int
    recorded: tuple[str, ...]
    now: tuple[str, ...]
    reason: DecisionReason | None


@dataclass(frozen=True, slots=True)
class ReplayDiff:
    """The comparison of all decisions of a recording with those made now.

    `decisions` is their number, one per agent and tick, and `same` the number of equal ones. `differences` are in
    order of time.
    """

    decisions: int
    same: int
    differences: Sequence[DecisionDiff]


def diff_replayed_decisions(rerun: Rerun) -> ReplayDiff:
    """Rerun all ticks of a recording and compare the states of each agent with the recorded ones."""
    recording = rerun.recording
    differing: dict[int, DecisionDiff] = {}
    over: list[DecisionDiff] = []
    same = 0
    while not rerun.is_over:
        tick, time_s = rerun.tick_count, float(recording.times[rerun.tick_count])
        rerun.tick()
        for agent, now in enumerate(rerun.paths):
            recorded = recording.records[agent].states[tick]
            before = differing.get(agent)
            if now == recorded:
                same += 1
                if before is not None:
                    over.append(differing.pop(agent))
            elif before is None:
                why = _decision(rerun, agent, recorded, now)
                differing[agent] = DecisionDiff(agent, time_s, time_s, 1, recorded, now, why)
            else:
                differing[agent] = replace(before, until_s=time_s, ticks=before.ticks + 1)
    over = sorted((*over, *differing.values()), key=lambda each: (each.from_s, each.agent))
    return ReplayDiff(recording.ticks * len(recording.records), same, over)


def explain_recorded_tick(rerun: Rerun, agent: int, tick: int) -> RunExplanation:
    """Explain an agent's decisions in a tick of a recording, counted from 0.

    RunNotReproducible is raised if the agent is now in other states than recorded.
    """
    recording = rerun.recording
    rerun.replay_to(tick + 1)
    recorded, now = recording.records[agent].states[tick], rerun.paths[agent]
    time_s = float(recording.times[tick])
    if recorded != now:
        problem = f"at {time_s:g} s it was in {BETWEEN.join(recorded)!r}, and is in {BETWEEN.join(now)!r}"
        remedy = "its kit or Understudy is another since; `understudy replay` shows all that differs"
        raise RunNotReproducible(problem=problem, remedy=remedy)
    return _explain_tick(rerun, agent, time_s, time_s)


def _decision(
    rerun: Rerun, agent: int, recorded: tuple[str, ...], now: tuple[str, ...]
) -> DecisionReason | None:
    """Return the decision at the outermost level whose state differs."""
    changed, chain = detect_state_change(recorded, now), rerun.list_chain(agent)
    level, own = 0 if changed is None else changed.level, chain[-1]
    if own.last_order:  # paths begin with what the one above ordered
        return _decided(rerun, chain[-2], None) if level == 0 else _decided(rerun, own, level - 1)
    return _decided(rerun, own, level)


def _decided(rerun: Rerun, post: AgentRef, level: int | None) -> DecisionReason | None:
    """Return what an agent's automaton at a level decided in the replayed tick, and why.

    Levels count from 0, the outermost. If `level` is None, it is the outermost one that switched, or the innermost
    if none did. Return None if that level does not exist or made no decision.
    """
    stood = find_traced_run(post).list_active(post.agent)
    if level is None:
        switching = (at for at, each in enumerate(stood) if each.query is not None and each.query.is_switch)
        level = next(switching, len(stood) - 1)
    if not 0 <= level < len(stood):
        return None
    query, machine = stood[level].query, stood[level].machine
    return None if query is None else explain_answer(machine, query, rerun.libraries[post.sort].taught)
