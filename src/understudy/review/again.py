"""Deciding again: what automata decide over the readings of a recording, beside what was decided then.

Each runs through all of it by itself, as it would have run then. Where it decided otherwise the robot would have come
elsewhere, so what it decides after that is about readings that it would not have had: the first difference counts most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from understudy.model.binding import Binding
from understudy.model.library import Library, Taught
from understudy.review.following import Followed, Post, command, followed
from understudy.review.why import Reason, reason
from understudy.robots.recording_file import Recording
from understudy.robots.replay import Replay
from understudy.robots.transitions import transition
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import Program, link
from understudy.runtime.team import Team
from understudy.worlds.dealing import deal
from understudy.worlds.scenario import Scenario
from understudy.worlds.teams import Libraries


@dataclass(frozen=True, slots=True)
class Difference:
    """Ticks in a row, from one time to another (s, both included), in which an agent is in other states than recorded:
    which those were in the first of them, and what decided it (None: the automata are built otherwise).
    """

    agent: int
    from_s: float
    until_s: float
    ticks: int
    recorded: tuple[str, ...]
    now: tuple[str, ...]
    reason: Reason | None


@dataclass(frozen=True, slots=True)
class Again:
    """How often the agents of a recording were asked (once each tick), how often they decided as recorded, and where
    not, in order of time.
    """

    decisions: int
    same: int
    differences: Sequence[Difference]


def decided_again(
    recording: Recording,
    libraries: Libraries,
    sorts: Sequence[str],
    behavior: str,
    *,
    binding: Mapping[str, str],
    scenario: Scenario | None = None,
) -> Again:
    """Decide over all ticks of a recording: agents of some sorts run a behavior, with what each sort knows.

    They are a scenario's team where as many were recorded as it has robots; otherwise each runs it by itself.
    """
    body = Replay(recording)
    root = behavior, Binding(binding)
    running: _Teamed | _Alone
    if scenario is not None and len(deal(scenario).type_of) == body.agents:
        running = _Teamed(body, scenario, libraries, dict.fromkeys(sorts, root))
    else:
        running = _Alone(body, libraries[sorts[0]], link(libraries[sorts[0]], *root))
    open_: dict[int, Difference] = {}
    found: list[Difference] = []
    same = 0
    while not body.ended:
        tick, time_s = body.tick, float(recording.times[body.tick])
        running.tick()
        for agent, now in enumerate(running.paths):
            recorded = tuple(recording.paths[agent][tick])
            before = open_.get(agent)
            if now == recorded:
                same += 1
                if before is not None:
                    found.append(open_.pop(agent))
            elif before is None:
                why = running.reason(agent, recorded, now)
                open_[agent] = Difference(agent, time_s, time_s, 1, recorded, now, why)
            else:
                open_[agent] = replace(before, until_s=time_s, ticks=before.ticks + 1)
    found += open_.values()
    return Again(
        recording.ticks * body.agents, same, sorted(found, key=lambda each: (each.from_s, each.agent))
    )


class _Alone:
    """Agents that run a behavior by themselves."""

    def __init__(self, body: Replay, library: Library, program: Program) -> None:
        self._library = library
        agents = range(body.agents)
        self._run = Followed(body, [Interpreter(program, now=body.time_s) for _ in agents])
        for agent in agents:
            self._run.follow(agent)

    def tick(self) -> None:
        self._run.tick()

    @property
    def paths(self) -> list[tuple[str, ...]]:
        return [each.path for each in self._run.interpreters]

    def reason(self, agent: int, recorded: tuple[str, ...], now: tuple[str, ...]) -> Reason | None:
        return _reason(self._run, agent, _level(recorded, now), self._library.taught)


class _Teamed:
    """The team of a scenario."""

    def __init__(
        self, body: Replay, scenario: Scenario, libraries: Libraries, roots: Mapping[str, tuple[str, Binding]]
    ) -> None:
        self._libraries = libraries
        self._team = Team(
            body,
            deal(scenario),
            libraries,
            roots,
            makes=followed,
            delay_s=scenario.radio.delay_s,
            loss=scenario.radio.loss,
            seeds=[body.recording.head.ran.seed],
        )
        self._chains = [command(self._team, agent) for agent in range(body.agents)]
        for post in (post for chain in self._chains for post in chain):
            _runner(post).follow(post.agent)

    def tick(self) -> None:
        self._team.tick()

    @property
    def paths(self) -> list[tuple[str, ...]]:
        return self._team.paths

    def reason(self, agent: int, recorded: tuple[str, ...], now: tuple[str, ...]) -> Reason | None:
        chain = self._chains[agent]
        own, level = chain[-1], _level(recorded, now)
        if own.ordered:  # paths begin with what the one above ordered
            if level == 0:
                return self._asked(chain[-2], None)
            level -= 1
        return self._asked(own, level)

    def _asked(self, post: Post, level: int | None) -> Reason | None:
        return _reason(_runner(post), post.agent, level, self._libraries[post.sort].taught)


def _level(recorded: tuple[str, ...], now: tuple[str, ...]) -> int:
    """The outermost level that differs."""
    changed = transition(recorded, now)
    return 0 if changed is None else changed.level


def _runner(post: Post) -> Followed:
    if not isinstance(post.layer.runner, Followed):
        raise TypeError("agents that cannot be followed")
    return post.layer.runner


def _reason(runner: Followed, agent: int, level: int | None, taught: Mapping[str, Taught]) -> Reason | None:
    """What an agent decided in this tick at a level; at the outermost that switched, where it is not said which."""
    stood = runner.stood(agent)
    if level is None:
        switching = (
            number for number, each in enumerate(stood) if each.asked is not None and each.asked.switched
        )
        level = next(switching, len(stood) - 1)
    if not 0 <= level < len(stood):
        return None
    query, machine = stood[level].asked, stood[level].machine
    return None if query is None else reason(str(machine.instance), query, taught[machine.automaton.name])
