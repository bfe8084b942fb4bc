"""The claim of an agent on its name: of two that are started at the same moment, one remains."""

from __future__ import annotations

import time
from collections.abc import Callable
from secrets import token_hex

from understudy.errors import SettingError
from understudy.robots.team_network.zenoh_network import ZenohNetwork

HEARD_S = 0.3
"""The time in s in which two agents that have joined the network hear of each other's claims."""


def claim_name(network: ZenohNetwork, name: str, *, team: str, answers: Callable[[], bool]) -> None:
    """Claim the name of an agent.

    Each claim has a random number: of two at the same moment, the smaller one wins. Whoever comes later finds that the
    name is held. An agent whose computer has died holds its name for a while, but does not answer.

    Parameters
    ----------
    network
        The agent's access to the network.
    name
        The name of the agent.
    team
        The name of the team.
    answers
        A function that returns whether an agent of this name answers questions.

    Raises
    ------
    SettingError
        If another agent of this name is running or starting.
    """
    held_before = is_held(network, name)
    if held_before and answers():
        raise _refuse(name, team, "is running already", "stop the other one first")
    mine = token_hex(8)
    network.declare_token(f"claim/{name}/{mine}")
    time.sleep(HEARD_S)
    others = [key.rpartition("/")[2] for key in network.list_tokens(f"claim/{name}/*")]
    if any(other < mine for other in others) or (not held_before and is_held(network, name)):
        raise _refuse(name, team, "was started twice at the same moment", "let the other one run")
    network.declare_token(f"held/{name}")


def is_held(network: ZenohNetwork, name: str) -> bool:
    """Ask the network whether an agent of this name runs, or is about to."""
    return network.is_present(name) or bool(network.list_tokens(f"held/{name}"))


def _refuse(name: str, team: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where=f"team {team}", setting=name, problem=problem, remedy=remedy)
