"""Diagnosis of a robot's connection: rate and age of its messages, and what is missing, before anything moves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan

from understudy.addons.robots.inputs import LatestSample, TopicInput
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.ros.transport import Publisher
from understudy.model.features import format_reading_label
from understudy.sim.kit import list_type_readings

SLOW = 0.8
"""The share of the rate in the robot file below which an actual rate is reported."""


@dataclass(frozen=True, slots=True)
class TopicStats:
    """The messages that arrived from one source: number, rate (Hz; NaN if fewer than two) and age of the last (s)."""

    name: str
    topic: str
    messages: int
    rate_hz: float
    age_s: float
    values: Mapping[str, float]
    """The latest value of each reading by name; NaN where absent."""
    unit: str
    required: bool
    problem: str
    """A sentence about what is wrong; empty if nothing is."""


@dataclass(frozen=True, slots=True)
class ConnectionReport:
    """The state of a robot's sources, and everything else that argues against arming it."""

    name: str
    seconds: float
    arrivals: Sequence[TopicStats]
    problems: Sequence[str]
    """All problems, including those of the sources."""
    lacks: Sequence[str] = ()
    """The readings of its scenario that the robot does not have, so that lessons find them absent."""


def diagnose_connection(robot: Robot, *, seconds: float) -> ConnectionReport:
    """Report what arrived from a robot so far, which was listened to for the given time (s); nothing is sent."""
    peers, now, senses = robot.transport.peers(), robot.now_s, robot.senses
    arrivals = []
    for name, source in senses.sources.items():
        latest, topic = senses.latest[name], robot.file.topic(source.topic)
        age_s = now - latest.at_s if latest.count else inf
        fresh = senses.read_fresh(name, now)
        arrivals.append(
            TopicStats(
                name,
                topic,
                latest.count,
                latest.rate_hz,
                age_s if latest.count else nan,
                {format_reading_label(key): fresh.get(key, nan) for key in source.keys},
                source.readings[0].unit if source.readings else "m",
                source.required,
                _problem(name, topic, source, latest, age_s, peers),
            )
        )
    invalid = [arrival.problem for arrival in arrivals if arrival.problem]
    problems = tuple(
        dict.fromkeys(
            (*invalid, *_others(robot, peers), *_unheard(robot), *_still(robot), *_unready_skills(robot))
        )
    )
    return ConnectionReport(robot.file.name, seconds, arrivals, problems, _lacks(robot))


def _lacks(robot: Robot) -> Sequence[str]:
    """List the readings of the robot's type in its scenario that it does not have."""
    if robot.kind is None:
        return ()
    here = {reading.name for reading in robot.readings}
    return tuple(reading.name for _, reading in list_type_readings(robot.kind) if reading.name not in here)


def _problem(
    name: str, topic: str, of: TopicInput, latest: LatestSample, age_s: float, peers: Sequence[Publisher]
) -> str:
    """Describe in one sentence what is wrong with a source; return an empty text if nothing is."""
    there = sorted({peer.type for peer in peers if peer.topic == topic})
    if not latest.count and latest.refused:
        return f"{name}: what comes on {topic} is no {of.type} ({latest.problem}); correct the publisher"
    if not latest.count and there and of.type not in there:
        return (
            f"{name}: {topic} carries {', '.join(there)}, not {of.type}; correct `type` in the robot's file"
        )
    if not latest.count:
        return (
            f"{name}: nothing comes on {topic}, and {'somebody' if there else 'nobody'} publishes there; "
            "start the robot, or correct `topic`, `namespace` or `domain` in its file"
        )
    if age_s > of.stale_s:
        return f"{name}: {topic} fell silent {age_s:.1f} s ago; start its sensor again"
    if of.rate_hz is not None and latest.rate_hz < SLOW * of.rate_hz:
        return f"{name}: {topic} comes at {latest.rate_hz:.1f} Hz, not {of.rate_hz:g}; correct `rate_hz`, or the sensor"
    if latest.refused:
        return f"{name}: {latest.refused} on {topic} were not {of.type} ({latest.problem}); find their sender"
    return ""


def _others(robot: Robot, peers: Sequence[Publisher]) -> Iterator[str]:
    """Yield sentences about other publishers of the robot's commands or sensor topics."""
    commands = robot.file.topic(robot.file.commands.topic)
    drive = any(skill.moves for skill in robot.file.skills.values())
    if not drive and (count := sum(peer.topic == commands for peer in peers)):
        who = "somebody else publishes" if count == 1 else f"{count} others publish"
        yield f"{who} on {commands}; stop them, or this robot obeys two masters"
    for topic in dict.fromkeys(robot.file.topic(source.topic) for source in robot.senses.sources.values()):
        if (count := sum(peer.topic == topic for peer in peers)) > 1:
            yield f"{count} publish on {topic}; give each robot a namespace of its own"


def _unheard(robot: Robot) -> Iterator[str]:
    """Yield a sentence about each status of the robot's drivers that its file names and that has not come."""
    of = robot.file.diagnostics
    if of is None:
        return
    for name in dict.fromkeys((*of.unfit, *of.stop)):
        if name not in robot.statuses.heard:
            yield (
                f"diagnostics: nothing named {name!r} comes on {robot.file.topic(of.topic)}; start its driver, or "
                "correct the name in the robot's file"
            )


def _still(robot: Robot) -> Iterator[str]:
    """Yield a sentence if the simulation's clock, by which the robot ticks, has not come."""
    if robot.simulation_clock is not None and not robot.simulation_clock.heard:
        yield "use_sim_time: nothing comes on /clock; start the simulation with its clock, or leave it out of the file"


def _unready_skills(robot: Robot) -> Iterator[str]:
    """Yield sentences about skills whose action or service is not there, or is of another type."""
    for name, problem in robot.skills.find_problems().items():
        yield f"{name}: {problem}; start it, or correct `skills.{name}` in the robot's file"
