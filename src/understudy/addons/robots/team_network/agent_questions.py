"""The questions that agents answer: their status, whether their robots can be armed, and the lines of their logs."""

from __future__ import annotations

from typing import Any

import msgspec

from understudy.addons.robots.team_network.team_access import TeamAccess
from understudy.runtime.agents.messages import UNREADABLE

ASK_S = 8.0
"""The longest time in s to wait for the answers of all agents; longer than a permit to arm holds."""
READY_S = 4.0
"""The longest time in s to wait for permits to arm robots; the person who arms them has prepared them before."""
PREPARE_S = 16.0
"""The longest time in s to wait until the watchdogs of robots run: a slow computer may need 15 s to start one."""


class AgentStatus(msgspec.Struct, frozen=True, kw_only=True):
    """The status of an agent."""

    name: str
    sort: str
    path: list[str]
    duty: str
    """The behavior that its order names; empty without an order."""
    order: tuple[int, int] | None
    order_age_s: float | None
    """For how long it has executed this order, s."""
    leader: str | None
    """The agent whose orders it obeys."""
    term: int
    armed: bool | None
    """True if the robot is armed; None if the agent has no robot."""
    trainer: str
    """The agent that drives it to train it; empty if none does."""
    unfit: str
    """Why it is not counted as a member; empty if it is."""
    leads: dict[str, int]
    """The squads that it leads, and in which term."""
    decides: dict[str, list[str]]
    """The state of every level of these squads' coordinators."""
    missing: dict[str, str]
    """The members of these squads that are not counted, and why."""
    library: str
    refused: dict[str, int]
    """The number of orders that were refused, by reason."""
    ticks: int
    late: int


class AgentQuestion(msgspec.Struct, frozen=True):
    """A request to an agent: what it is to `do`, and the person who asks (`by`)."""

    do: str
    by: str = ""
    files: dict[str, bytes] = {}
    """The documents of a library to prepare."""
    permits: dict[str, str] = {}
    """For each robot that is to be armed, the permit that its agent gave."""


class AgentAnswer(msgspec.Struct, frozen=True):
    """An agent's answer: a status, lines of its log, or why it did not do what it was asked; empty if it did."""

    status: AgentStatus | None = None
    log: list[str] = []
    problem: str = ""
    permit: str = ""
    """The permit with which the robot can be armed, for a short while and until it is stopped."""


def ask(
    network: TeamAccess, question: AgentQuestion, *, agent: str = "*", wait_s: float = ASK_S
) -> dict[str, AgentAnswer]:
    """Ask the agents of a team.

    Parameters
    ----------
    network
        An access to the team's network.
    question
        The question.
    agent
        The name of the agent; `*` asks all.
    wait_s
        The longest time to wait for answers, s.

    Returns
    -------
    dict
        The answer of each agent that gave one, by its name.
    """
    decoded = {}
    answers: dict[str, Any] = network.ask(
        f"agent/{agent}", msgspec.msgpack.encode(question), timeout_s=wait_s
    )
    for key, data in answers.items():
        try:
            decoded[key.rpartition("/")[2]] = msgspec.msgpack.decode(data, type=AgentAnswer)
        except UNREADABLE:
            continue
    return dict(sorted(decoded.items()))


def ask_to_stop(network: TeamAccess, by: str, agent: str = "*") -> dict[str, AgentAnswer]:
    """Stop and disarm robots at once, because the person `by` orders it; `agent` and the result are those of `ask`."""
    return ask(network, AgentQuestion("stop", by), agent=agent)


def ask_to_prepare(network: TeamAccess, by: str, agent: str = "*") -> dict[str, AgentAnswer]:
    """Start the watchdogs of robots that the person `by` is about to arm; arming them is immediate then.

    Parameters
    ----------
    network
        An access to the team's network.
    by
        The person.
    agent
        The name of the robot's agent; `*` asks all.

    Returns
    -------
    dict
        The answer of each agent that gave one, by its name. Its permit should not be used: `ask_to_arm` asks for one
        when the person orders it, so that a stop until then is not overridden.
    """
    return ask(network, AgentQuestion("ready", by), agent=agent, wait_s=PREPARE_S)


def ask_to_arm(network: TeamAccess, by: str, agent: str = "*") -> dict[str, AgentAnswer]:
    """Arm robots: ask whether they are ready, and arm those that are.

    A robot that was stopped in between stays disarmed, also if the network held the question up; and one whose agent
    does not answer is not armed later.

    Parameters
    ----------
    network
        An access to the team's network.
    by
        The person who orders it.
    agent
        The name of the robot's agent; `*` asks all.

    Returns
    -------
    dict
        The answer of each agent that gave one, by its name.
    """
    ready = ask(network, AgentQuestion("ready", by), agent=agent, wait_s=READY_S)
    permits = {name: answer.permit for name, answer in ready.items() if answer.permit}
    refused = {name: answer for name, answer in ready.items() if not answer.permit}
    if not permits:
        return refused
    armed = ask(network, AgentQuestion("arm", by, permits=permits), agent=agent)
    return dict(sorted((refused | {name: armed[name] for name in permits if name in armed}).items()))
