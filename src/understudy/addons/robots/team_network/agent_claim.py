"""The claim of an agent on its name: of two that are started at the same moment, one remains."""

from __future__ import annotations

from secrets import token_hex

from understudy.addons.robots.team_network.team_access import TeamAccess
from understudy.clock import REAL_TIME, Clock
from understudy.errors import SettingError

HEARD_S = 0.3
"""The time in s in which two agents that have joined the network hear of each other's claims."""
ALIVE_S = 2.0
"""The longest time in s to wait for the answer of an agent that holds a name; one that does not answer has died."""


def claim_name(network: TeamAccess, name: str, *, team: str, clock: Clock = REAL_TIME) -> None:
    """Claim the name of an agent, and from then on answer all agents that ask whether it is taken.

    Each claim has a random number: of two at the same moment, the smaller one wins. An agent whose computer has died
    keeps its claim in the network for some seconds, but does not answer: such a claim does not count.

    Parameters
    ----------
    network
        The agent's access to the network.
    name
        The name of the agent.
    team
        The name of the team.
    clock
        What it waits by for the claims of others.

    Raises
    ------
    SettingError
        If another agent of this name is running or starting.
    """
    former = _list_claims(network, name)
    was_held = bool(former) or is_held(network, name)
    if was_held and network.ask(f"claim/{name}/*", b"", timeout_s=ALIVE_S):
        raise _refuse(name, team, "is running already", "stop the other one first")
    mine = token_hex(8)
    came_first = was_held and bool(_list_claims(network, name) - former)  # while the dead were asked
    if not came_first:
        network.answer(f"claim/{name}/{mine}", lambda question: b"")
        network.declare_token(f"claim/{name}/{mine}")
        clock.sleep(HEARD_S)
        others = _list_claims(network, name) - former
        came_first = any(other < mine for other in others) or (not was_held and is_held(network, name))
    if came_first:
        raise _refuse(name, team, "was started twice at the same moment", "let the other one run")
    network.declare_token(f"held/{name}")


def _list_claims(network: TeamAccess, name: str) -> set[str]:
    return {key.rpartition("/")[2] for key in network.list_tokens(f"claim/{name}/*")}


def is_held(network: TeamAccess, name: str) -> bool:
    """Ask the network whether an agent of this name runs, or is about to."""
    return network.is_present(name) or bool(network.list_tokens(f"held/{name}"))


def _refuse(name: str, team: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where=f"team {team}", setting=name, problem=problem, remedy=remedy)
