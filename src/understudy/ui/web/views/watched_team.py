"""Show a team whose agents run on computers of their own, and drive those of its robots that are trained here."""

from __future__ import annotations

from typing import Literal, TypeAlias

from msgspec import field

from understudy.addons.robots.team_network.remote_robot import drive_robots
from understudy.addons.robots.team_network.team_watch import TeamWatch, WatchedAgent
from understudy.addons.robots.twin import DigitalTwin
from understudy.ui.web.messages.base import Data
from understudy.ui.web.session_host import SessionHost

Presence: TypeAlias = Literal["here", "silent", "gone"]
"""Whether an agent is heard, is silent though it is in the network, or is not in it."""


class TeamAgentData(Data, frozen=True, kw_only=True):
    """One agent of a running team: a robot, or the coordinator of a squad."""

    name: str
    sort: str
    squad: str | None
    """The squad that it is a member of; null if it is in none."""
    is_robot: bool
    presence: Presence
    silent_s: float | None
    """For how long it has been silent, s; null if it is heard, or never was."""
    states: list[str]
    """The state of every level, outermost first; of a squad, those of its leader."""
    duty: str = ""
    """What its order tells it to do; empty without one."""
    order: str | None
    """Its order: term and number, such as 3.12."""
    order_age_s: float | None
    """For how long it has executed this order, s."""
    leader: str | None = None
    """The agent whose orders it obeys."""
    leads: dict[str, int] = field(default_factory=dict)
    """The squads that it leads, with the term."""
    armed: bool | None = None
    """Whether the robot is armed; null for coordinators."""
    problem: str
    """Why it is not counted as a member of its squad; empty if it is."""
    trainer: str = ""
    """The computer that drives it to train it; empty if none does."""
    other_library: bool
    """Whether its library is not that of this computer."""


class TeamData(Data, frozen=True, kw_only=True):
    """A running team as this computer sees it."""

    name: str
    agents: list[TeamAgentData]
    """The coordinators, topmost squad first, then the robots."""
    trainer: str | None
    """The name under which this computer may train robots; null if the team's file gives none."""


def describe_team(watch: TeamWatch) -> TeamData:
    """Return what every agent of a team does, and which are missing."""
    watched = watch.list_agents()
    counted, led = dict[str, str](), dict[str, tuple[int, list[str]]]()
    for each in watched:
        if each.status is None or each.is_silent or not each.is_present:
            continue
        counted |= each.status.missing
        for squad, term in each.status.leads.items():
            led[squad] = max(led.get(squad, (0, [])), (term, each.status.decides.get(squad, [])))
    robots = set(watch.team.plan.robots)
    agents = [
        _describe_agent(watch, each, counted, led.get(each.name), is_robot=each.name in robots)
        for each in watched
    ]
    return TeamData(
        name=watch.team.name,
        agents=[
            *reversed([each for each in agents if not each.is_robot]),
            *(each for each in agents if each.is_robot),
        ],
        trainer=watch.team.settings.trainer,
    )


def _describe_agent(
    watch: TeamWatch,
    agent: WatchedAgent,
    counted: dict[str, str],
    led: tuple[int, list[str]] | None,
    *,
    is_robot: bool,
) -> TeamAgentData:
    plan = watch.team.plan
    sort = plan.find_sort(agent.name)
    presence: Presence = "gone" if not agent.is_present else "silent" if agent.is_silent else "here"
    status = agent.status if presence == "here" else None
    states = [] if led is None else led[1]
    order, age_s = (None, None) if status is None else (status.order, status.order_age_s)
    return TeamAgentData.of(
        status,
        name=agent.name,
        sort=sort,
        squad=plan.find_superior(agent.name),
        is_robot=is_robot,
        presence=presence,
        silent_s=None if agent.status is None or status is not None else float(round(agent.age_s)),
        states=status.path if is_robot and status is not None else states,
        order=None if order is None else "{}.{}".format(*order),
        order_age_s=None if age_s is None else float(round(age_s)),
        problem=(status is not None and status.unfit) or counted.get(agent.name, ""),
        other_library=agent.status is not None and agent.status.library != watch.team.fingerprints[sort],
    )


def drive_trained_robots(host: SessionHost) -> None:
    """Drive the robots that the open session trains or runs, and leave all others to their agents."""
    if isinstance(host.world, DigitalTwin):
        drive_robots(host.world.fleet, _list_driven(host))


def _list_driven(host: SessionHost) -> list[int]:
    trainer = host.trainer
    if trainer is None:
        return []
    if host.sort is None and host.other_behavior is None:
        return [trainer.robot]
    return list(range(host.world.robots))
