"""A running team as another computer sees it: the status of each agent, its age, and the agents that are missing."""

from __future__ import annotations

import os
import platform
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import inf

import msgspec

from understudy.addons.robots.team_network.agent_questions import (
    AgentAnswer,
    AgentQuestion,
    AgentStatus,
    ask,
    ask_to_arm,
    ask_to_prepare,
)
from understudy.addons.robots.team_network.agent_views import STATUS, VIEWER
from understudy.addons.robots.team_network.load_plan import LoadedTeam
from understudy.addons.robots.team_network.team_access import TeamAccess
from understudy.clock import REAL_TIME, Clock
from understudy.runtime.agents.messages import UNREADABLE

SILENT_S = 0.8
"""The time without a report after which an agent is shown as silent, s; agents report every 0.2 s."""
ASKING = 1000
"""The number of questions whose answers are awaited at the same time, so that none waits for a silent agent."""

NO_ANSWER = "did not answer: look whether it stands"
"""Why an agent did not do something, if nothing was heard of it."""


@dataclass(frozen=True, slots=True)
class WatchedAgent:
    """An agent as it was heard last.

    Attributes
    ----------
    name
        Its name.
    status
        What it said of itself last; None if it was never heard.
    age_s
        How long ago that was, s; infinite if it was never heard.
    is_present
        Whether it is in the network, as far as is known.
    """

    name: str
    status: AgentStatus | None
    age_s: float
    is_present: bool

    @property
    def is_silent(self) -> bool:
        """Whether it has not been heard for a while."""
        return self.age_s > SILENT_S


class TeamWatch:
    """A visitor of a team's network, which receives the status of all agents.

    Parameters
    ----------
    team
        The team.
    network
        The visitor's access to the network.
    clock
        The clock of what is heard, and of robots that are seen here.
    """

    def __init__(self, team: LoadedTeam, network: TeamAccess, *, clock: Clock = REAL_TIME) -> None:
        self.team, self.network, self.clock = team, network, clock
        self._statuses = network.listen(f"{STATUS}/*")
        self._heard: dict[str, tuple[AgentStatus, float]] = {}
        self._asking = ThreadPoolExecutor(ASKING, thread_name_prefix="ask")
        network.announce(f"{VIEWER}{platform.node()}:{os.getpid()}")

    def list_agents(self) -> list[WatchedAgent]:
        """List all agents of the team: robots, then squads bottom-up."""
        self._hear()
        now, present = self.clock(), self.network.present
        agents = []
        for name in self.team.agents:
            status, heard_s = self._heard.get(name, (None, -inf))
            agents.append(WatchedAgent(name, status, now - heard_s, name in present))
        return agents

    def find_agent(self, name: str) -> WatchedAgent:
        """Return one agent of the team."""
        self._hear()
        status, heard_s = self._heard.get(name, (None, -inf))
        return WatchedAgent(name, status, self.clock() - heard_s, name in self.network.present)

    def _hear(self) -> None:
        for data in self._statuses.take_all():
            try:
                status = msgspec.msgpack.decode(data, type=AgentStatus)
            except UNREADABLE:
                continue
            self._heard[status.name] = status, self.clock()

    def order(self, do: str, by: str, name: str) -> str:
        """Ask an agent to make its robot ready, arm or stop it; wait, and return why it did not; empty if it did."""
        if do == "arm":
            answers: dict[str, AgentAnswer] = ask_to_arm(self.network, by, name)
        elif do == "ready":
            answers = ask_to_prepare(self.network, by, name)
        else:
            answers = ask(self.network, AgentQuestion(do, by), agent=name)
        return answers[name].problem if name in answers else NO_ANSWER

    def order_soon(self, do: str, by: str, name: str) -> None:
        """Ask an agent without waiting for its answer, nor for the answers to earlier questions."""
        self._asking.submit(self.order, do, by, name)

    def close(self) -> None:
        """Finish what was asked, and leave the network."""
        self._asking.shutdown()
        self.network.close()
