"""Check that a team's file can be run by agents: names, times, and parts that contradict each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from understudy.addons.robots.robot_file import RobotFile, TeamFile
from understudy.errors import FileError, join_names
from understudy.runtime.agents.leadership import SILENT_S
from understudy.runtime.agents.messages import LONGEST_LEASE_S

RESERVED = "/*?#$"
"""The signs that names must not have, because they are parts of keys."""
LONGEST_TICK_S = SILENT_S / 2
"""The longest tick, s: with a longer one, a leader that works would be taken for silent."""
LEASE_TICKS = 3
"""The number of ticks for which an order holds at least, so that a lost message ends none."""


def check_robot_worlds(path: Path | str, team: TeamFile, files: Sequence[RobotFile]) -> None:
    """Refuse a team whose robots cannot be agents of one team.

    Parameters
    ----------
    path
        The team's file.
    team
        Its content.
    files
        The content of the robots' files.

    Raises
    ------
    FileError
        If names, ticks, the lease or the topics of commands do not fit.
    """
    _refuse(path, _find_wrong_robots(team, files))


def check_agents(path: Path | str, team: TeamFile, robots: Sequence[str], squads: Sequence[str]) -> None:
    """Refuse settings of agents that the team does not have.

    Parameters
    ----------
    path
        The team's file.
    team
        Its content.
    robots
        The names of the robots.
    squads
        The names of the squads.

    Raises
    ------
    FileError
        If a robot has the name of a squad, or settings are of no agent or sort.
    """
    _refuse(path, _find_wrong_agents(team, robots, squads))


def _refuse(path: Path | str, wrong: Iterator[tuple[str, str, str]]) -> None:
    for place, problem, remedy in wrong:
        raise FileError(path=path, place=place, problem=problem, remedy=remedy)


def _find_wrong_robots(team: TeamFile, files: Sequence[RobotFile]) -> Iterator[tuple[str, str, str]]:
    for place, name in [("name", team.name), *(("robots", file.name) for file in files)]:
        if not name or not set(name).isdisjoint(RESERVED):
            yield place, f"has the name {name!r:.60}", f"give a name without {' '.join(RESERVED)}"
    names = [file.name for file in files]
    for name in names:
        if names.count(name) > 1:
            yield "robots", f"has two robots of the name {name!r}", "rename one of them"
    first = files[0]
    taken: dict[str, str] = {}
    for file in files:
        if file.tick_s != first.tick_s:
            problem = f"differ in tick_s: {first.name} has {first.tick_s:g}, {file.name} {file.tick_s:g}"
            yield "robots", problem, "give all the same"
        topic = f"{file.domain}:{file.topic(file.commands.topic)}"
        if topic in taken:
            problem = f"has {taken[topic]} and {file.name}, which would get the same commands"
            yield "robots", problem, "give each its own namespace or domain"
        taken[topic] = file.name
    if first.tick_s > LONGEST_TICK_S:
        yield "robots", f"have a tick_s of {first.tick_s:g}", f"give agents at most {LONGEST_TICK_S:g}"
    shortest = LEASE_TICKS * first.tick_s
    if not shortest <= team.agents.lease_s <= LONGEST_LEASE_S:
        remedy = f"give from {shortest:g} (three ticks) to {LONGEST_LEASE_S:g}"
        yield "agents.lease_s", f"is {team.agents.lease_s:g}", remedy


def _find_wrong_agents(
    team: TeamFile, robots: Sequence[str], squads: Sequence[str]
) -> Iterator[tuple[str, str, str]]:
    settings = team.agents
    trainer = settings.trainer
    if trainer is not None and (not trainer or not set(trainer).isdisjoint(RESERVED)):
        yield "agents.trainer", f"is {trainer!r:.60}", f"give a name without {' '.join(RESERVED)}"
    if trainer in (*robots, *squads):
        yield "agents.trainer", f"is {trainer!r:.60}, which is that of an agent", "give another name"
    for name in robots:
        if name in squads:
            yield "robots", f"has a robot of the name {name!r}, which is that of a squad", "rename the robot"
    for name in settings.each:
        if name not in (*robots, *squads):
            yield (
                f"agents.each.{name}",
                "is no agent of this team",
                f"name one of {join_names([*robots, *squads])}",
            )
    for sort in settings.bind:
        if sort not in settings.runs:
            yield f"agents.bind.{sort}", "is of a sort that runs nothing", "name it in agents.runs, too"
