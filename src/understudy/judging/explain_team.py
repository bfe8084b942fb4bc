"""Explanations of what an agent of a team did, across computers: its decisions, its order, who gave that, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isnan

import numpy as np

from understudy.errors import SettingError, UnknownName
from understudy.judging.explain_run import (
    AgentExplanation,
    DecisionReason,
    LevelExplanation,
    explain_recorded_tick,
)
from understudy.judging.rerun import Rerun
from understudy.model.binding import Binding
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.squad import Assignment
from understudy.records.header import SCENARIO, format_part
from understudy.records.reader import RecordedDuty, Recording
from understudy.records.team_reader import LoggedOrders, TeamRecording
from understudy.runtime.agents.messages import OrderId, compute_layout, list_reported_readings
from understudy.runtime.team.comms import SILENT_S
from understudy.sim.kit import list_readings
from understudy.sim.scenario.files import parse_scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries

NEAR_NS = 1000
"""The tolerance in ns within which two times are equal."""


@dataclass(frozen=True, slots=True)
class ReportSummary:
    """The last report of a member that a coordinator had heard when it decided.

    Attributes
    ----------
    member
        The member.
    flag
        The flag that it had raised.
    order
        The order (term, number) that it executed.
    unfit
        Why it was not to be counted; empty if it was.
    age_s
        How old the report was when the coordinator decided, s; None if there was none.
    readings
        The readings in it, without absent ones, if it is of a robot.
    """

    member: str
    flag: str | None
    order: tuple[int, int] | None
    unfit: str
    age_s: float | None
    readings: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class OrderSummary:
    """An order that an agent executes.

    Attributes
    ----------
    order
        Its term and number.
    squad
        The squad of the agent.
    leader
        The agent that gives it now.
    duty
        What it tells the agent to do; empty if nothing.
    heard_s
        When the agent began it, s.
    """

    order: tuple[int, int]
    squad: str
    leader: str
    duty: str
    heard_s: float


@dataclass(frozen=True, slots=True)
class AgentMoment:
    """An agent at a moment of a team's recording, with times by the recording's clock, from its beginning.

    Attributes
    ----------
    agent
        The agent: a robot or, for a coordinator, its squad.
    host
        The agent on whose computer that was decided.
    time_s
        The moment, s.
    error_s
        The largest error of times of this computer, s.
    doing
        The current state of every level.
    explanation
        The decisions of every level.
    order
        The order that it executes; None without one.
    reports
        For a coordinator, the reports that it had.
    missing
        Why its superior's decision is not explained; empty if it is, or there is no superior.
    """

    agent: str
    host: str
    time_s: float
    error_s: float
    doing: tuple[str, ...]
    explanation: AgentExplanation
    order: OrderSummary | None
    reports: Sequence[ReportSummary] = ()
    missing: str = ""


LoadLibraries = Callable[[Recording], Libraries]
"""A function that returns the libraries of all sorts as they were when a recording was made."""


def explain_team_moment(
    team: TeamRecording, agent: str, time_s: float, load: LoadLibraries
) -> list[AgentMoment]:
    """Explain what an agent did at a moment, and then who ordered that, when, and why, up to the top of the team.

    Parameters
    ----------
    team
        The recording.
    agent
        The name of the agent; for a coordinator, that of its squad.
    time_s
        The moment, by the recording's clock, from its beginning, s.
    load
        The libraries of a recording.

    Returns
    -------
    list
        The agent at this moment; then each superior at the moment at which it decided on the order of the one before.

    Raises
    ------
    UnknownName
        If nothing of this agent was recorded.
    SettingError
        If it was not running at this moment.
    RunNotReproducible
        If its decisions come out differently now.
    """
    at_ns = team.clock.start_ns + round(time_s * 1e9)
    part = _find_part(team, agent, at_ns)
    moments = list[AgentMoment]()
    while True:
        recording = team.read_part(part)
        tick = _find_tick(team, recording, agent, at_ns)
        moment, order = _explain(team, part, recording, tick, load)
        if order is None:
            return [*moments, moment]
        messages = list_first_messages(team, order.squad, order.order)
        if not messages:
            return [*moments, replace(moment, missing="no message of who decided on it is in this file")]
        decided = next((each for each in messages if each.is_sent), None)
        above = format_part(order.squad, messages[0].orders.leader)
        if decided is None or above not in team.parts:
            who = messages[0].orders.leader
            return [*moments, replace(moment, missing=f"the recording of {who} is not in this file")]
        moments.append(moment)
        part, agent, at_ns = above, order.squad, _find_deciding_tick(team.read_part(above), decided)


def _find_part(team: TeamRecording, agent: str, at_ns: int) -> str:
    """Find the part of an agent, or of the leader of a squad of this name at a time."""
    if agent in team.parts:
        return agent
    led = [part for part in team.parts if part.rpartition("/")[0] == agent]
    sent = [each for each in team.orders if each.is_sent and each.orders.squad == agent]
    before = [each for each in sent if each.logged_ns <= at_ns + NEAR_NS]
    if not led or not sent:
        names = dict.fromkeys(part.rpartition("/")[0] or part for part in team.parts)
        raise UnknownName(what="agent", name=agent, where=str(team.path), known=list(names))
    return format_part(agent, (before or sent[:1])[-1].agent)


def _find_tick(team: TeamRecording, recording: Recording, agent: str, at_ns: int) -> int:
    logged = recording.logged_ns
    first_s, last_s = team.count_seconds(int(logged[0])), team.count_seconds(int(logged[-1]))
    tick = int(np.searchsorted(logged, at_ns + NEAR_NS, side="right")) - 1
    if tick < 0 or at_ns > logged[-1] + recording.head.tick_s * 1e9 + NEAR_NS:
        problem = f"is {team.count_seconds(at_ns):g}, when {agent} was not recorded"
        remedy = f"give one from {first_s:.3f} to {last_s:.3f}"
        raise SettingError(where=str(team.path), setting="--time", problem=problem, remedy=remedy)
    return tick


def _explain(
    team: TeamRecording, part: str, recording: Recording, tick: int, load: LoadLibraries
) -> tuple[AgentMoment, OrderSummary | None]:
    """Explain an agent at a tick of its recording; return also its order."""
    ran, libraries = recording.head.ran, load(recording)
    rerun = Rerun(recording, libraries, ran.sorts, ran.behavior, binding=ran.binding)
    (explained,) = explain_recorded_tick(rerun, 0, tick).agents
    squad, _, host = part.rpartition("/")
    logged_ns = int(recording.logged_ns[tick])
    time_s = team.count_seconds(logged_ns)
    order = _find_order(team, host, recording, tick)
    moment = AgentMoment(
        squad or host,
        host,
        time_s,
        team.find_error(host),
        recording.records[0].states[tick],
        _shift(explained, time_s - float(recording.times[tick]), "" if order is None else order.duty),
        order,
        _find_reports(team, squad, host, logged_ns, _list_keys(recording)) if squad else (),
    )
    return moment, order


def _find_order(team: TeamRecording, host: str, recording: Recording, tick: int) -> OrderSummary | None:
    """Find the order that an agent executes at a tick, and its squad, which only messages name."""
    duty = next((each for each in reversed(recording.duties[0]) if each.tick <= tick), None)
    if duty is None or duty.order is None:
        return None
    squads = [
        each.orders.squad
        for each in team.orders
        if each.agent == host and each.orders.order == duty.order and each.orders.leader == duty.leader
    ]
    if not squads:
        return None
    now_ns = int(recording.logged_ns[tick])
    leader = _find_present_leader(team, host, squads[0], duty, now_ns)
    return OrderSummary(
        duty.order, squads[0], leader, _describe_duty(duty), team.count_seconds(duty.logged_ns)
    )


def _find_present_leader(team: TeamRecording, host: str, squad: str, duty: RecordedDuty, now_ns: int) -> str:
    """Find who gave an order last that an agent executes: a deputy may go on with it."""
    heard = [
        each.orders.leader
        for each in team.orders
        if each.agent == host and each.orders.squad == squad and each.orders.order == duty.order
        and each.logged_ns <= now_ns
    ]  # fmt: skip
    return heard[-1] if heard else duty.leader


def _describe_duty(duty: RecordedDuty) -> str:
    return str(Assignment(duty.behavior, Binding(duty.binding))) if duty.behavior else ""


def list_first_messages(team: TeamRecording, squad: str, order: OrderId) -> list[LoggedOrders]:
    """List the messages with an order of the leader that decided on it, whose term is that of the order.

    A leader that takes over goes on with the order in a later term.
    """
    return [
        each
        for each in team.orders
        if (each.orders.squad, each.orders.order, each.orders.term) == (squad, order, order[0])
    ]


def _find_deciding_tick(recording: Recording, decided: LoggedOrders) -> int:
    """Return the time (ns) of the tick in which orders were decided on; they are sent before it is recorded."""
    tick = min(int(np.searchsorted(recording.logged_ns, decided.logged_ns)), recording.ticks - 1)
    return int(recording.logged_ns[tick])


def _list_keys(recording: Recording) -> tuple[ReadingKey, ...]:
    """List the readings that robots report to the squad of a coordinator's recording."""
    scenario = parse_scenario(recording.head.files[SCENARIO], str(recording.path))
    kinds = [squad for squad, _ in assign_team_members(scenario).squads]
    kind = next((each for each in kinds if each.name in recording.head.ran.sorts), None)
    if kind is None:
        return ()
    return list_reported_readings(kind, list_readings(scenario), recording.head.targets)


def _find_reports(
    team: TeamRecording, squad: str, host: str, at_ns: int, keys: tuple[ReadingKey, ...]
) -> list[ReportSummary]:
    """Find the last report of each member that a coordinator had heard."""
    members = dict.fromkeys(
        name for each in team.orders if each.orders.squad == squad for name in each.orders.duties
    )
    reports: dict[str, ReportSummary] = {}
    for each in team.reports:
        if each.agent != host or each.logged_ns > at_ns or each.report.member not in members:
            continue
        report, age_s = each.report, (at_ns - each.logged_ns) / 1e9
        unfit = report.unfit or ("is silent" if age_s > SILENT_S else "")
        named = zip(map(format_reading_label, keys), report.readings, strict=False)
        readings = {name: value for name, value in named if not isnan(value)}
        reports[report.member] = ReportSummary(
            report.member,
            report.flag,
            report.order,
            unfit,
            age_s,
            readings if report.layout == compute_layout(keys) else {},
        )
    never = [
        ReportSummary(name, None, None, "was never heard", None) for name in members if name not in reports
    ]
    return [*(reports[name] for name in members if name in reports), *never]


def _shift(explained: AgentExplanation, by_s: float, duty: str) -> AgentExplanation:
    """Return an explanation with its times by the recording's clock."""

    def shift(reason: DecisionReason | None) -> DecisionReason | None:
        return None if reason is None else replace(reason, time_s=reason.time_s + by_s)

    def shift_level(level: LevelExplanation) -> LevelExplanation:
        return replace(
            level, since_s=level.since_s + by_s, decision=shift(level.decision), entry=shift(level.entry)
        )

    return replace(explained, ordered=duty or None, levels=tuple(map(shift_level, explained.levels)))
