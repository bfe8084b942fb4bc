"""Comparison of recorded decisions with those that the automata make now from the same recorded readings.

The automata run through the whole recording. After a first difference the robot would have moved differently, and so
have had other readings than the recorded ones; so the first difference counts most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from understudy.analysis.explain_run import (
    DecisionReason,
    RunExplanation,
    RunNotReproducible,
    explain_agent,
    explain_query,
    find_latest_switch,
)
from understudy.analysis.rerun import Rerun, find_traced_run
from understudy.analysis.run_trace import BETWEEN
from understudy.analysis.tracing import AgentRef
from understudy.robots.ros.state_topic import detect_state_change


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
    found: list[DecisionDiff] = []
    same = 0
    while not rerun.is_over:
        tick, time_s = rerun.tick_count, float(recording.times[rerun.tick_count])
        rerun.tick()
        for agent, now in enumerate(rerun.paths):
            recorded = tuple(recording.paths[agent][tick])
            before = differing.get(agent)
            if now == recorded:
                same += 1
                if before is not None:
                    found.append(differing.pop(agent))
            elif before is None:
                why = _decision(rerun, agent, recorded, now)
                differing[agent] = DecisionDiff(agent, time_s, time_s, 1, recorded, now, why)
            else:
                differing[agent] = replace(before, until_s=time_s, ticks=before.ticks + 1)
    found = sorted((*found, *differing.values()), key=lambda each: (each.from_s, each.agent))
    return ReplayDiff(recording.ticks * len(recording.paths), same, found)


def explain_recorded_tick(rerun: Rerun, agent: int, tick: int) -> RunExplanation:
    """Explain an agent's decisions in a tick of a recording, counted from 0.

    RunNotReproducible is raised if the agent is now in other states than recorded.
    """
    recording = rerun.recording
    while rerun.tick_count <= tick:
        rerun.tick()
    recorded, now = recording.paths[agent][tick], rerun.paths[agent]
    time_s = float(recording.times[tick])
    if recorded != now:
        problem = f"at {time_s:g} s it was in {BETWEEN.join(recorded)!r}, and is in {BETWEEN.join(now)!r}"
        remedy = "its kit or Understudy is another since; `understudy run --replay` shows all that differs"
        raise RunNotReproducible(problem=problem, remedy=remedy)
    chain, libraries = rerun.chains[agent], rerun.libraries
    agents = tuple(explain_agent(post, libraries[post.sort].taught) for post in chain)
    return RunExplanation(time_s, time_s, agents, find_latest_switch(chain, libraries))


def _decision(
    rerun: Rerun, agent: int, recorded: tuple[str, ...], now: tuple[str, ...]
) -> DecisionReason | None:
    """Return the decision at the outermost level whose state differs."""
    changed, chain = detect_state_change(recorded, now), rerun.chains[agent]
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
        switching = (at for at, each in enumerate(stood) if each.asked is not None and each.asked.is_switch)
        level = next(switching, len(stood) - 1)
    if not 0 <= level < len(stood):
        return None
    query, machine = stood[level].asked, stood[level].machine
    taught = rerun.libraries[post.sort].taught
    return (
        None if query is None else explain_query(str(machine.instance), query, taught[machine.automaton.name])
    )
