"""Access of agents and visitors to the network of a team: messages, presence, names that are taken, and questions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from understudy.runtime.agents.network import Network


class TeamAccess(Network, Protocol):
    """An access to the network of a team, on which names are claimed and questions asked."""

    def declare_token(self, key: str) -> None:
        """Let others see a key, until `close` or the end of this program."""
        ...

    def list_tokens(self, key: str) -> list[str]:
        """Ask the network which keys are declared; `*` stands for any part of the key."""
        ...

    def is_present(self, name: str) -> bool:
        """Ask the network whether an agent is there."""
        ...

    def answer(self, key: str, answer: Callable[[bytes], bytes]) -> None:
        """Answer questions to a key from now on; `answer` may be called in other threads."""
        ...

    def ask(self, key: str, question: bytes, *, timeout_s: float = 2.0) -> dict[str, bytes]:
        """Ask all agents that answer questions to a key; return the answers by the key of the agent that gave each."""
        ...
