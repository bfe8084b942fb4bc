"""The network of a team in memory: messages, presence, tokens and questions as over Zenoh, by the clock of a test."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from threading import Event, Thread

from tests.robots.rovers import Wire
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.load_plan import LoadedTeam
from understudy.clock import Clock
from understudy.records.recorder import RunRecorder
from understudy.runtime.agents.network import Inbox, Observe


class MemoryNetwork:
    """A network in which messages arrive at once, and tokens after a while.

    Parameters
    ----------
    clock
        The clock of the test.
    token_s
        The time after which others see a token, s.
    """

    def __init__(self, clock: Clock, *, token_s: float = 0.0) -> None:
        self.clock, self.token_s = clock, token_s
        self.members: list[MemoryAccess] = []

    def join(self) -> MemoryAccess:
        """Join the network."""
        self.members.append(made := MemoryAccess(self))
        return made


class MemoryAccess:
    """An access to a `MemoryNetwork`."""

    def __init__(self, network: MemoryNetwork) -> None:
        self._network = network
        self._inboxes: list[tuple[str, Inbox]] = []
        self._tokens: dict[str, float] = {}
        self._answers: dict[str, Callable[[bytes], bytes]] = {}
        self.is_dead = False
        """Whether its program was killed: its tokens are still there, and it answers nothing."""

    def publish(self, key: str, message: bytes) -> None:
        for member in list(self._network.members):
            for pattern, inbox in list(member._inboxes):
                if fnmatchcase(key, pattern):
                    inbox.add(message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        inbox = Inbox(observe=observe)
        self._inboxes.append((key, inbox))
        return inbox

    def announce(self, name: str) -> None:
        self.declare_token(f"present/{name}")

    @property
    def present(self) -> frozenset[str]:
        return frozenset(key.partition("/")[2] for key in self.list_tokens("present/*"))

    def is_present(self, name: str) -> bool:
        return bool(self.list_tokens(f"present/{name}"))

    def declare_token(self, key: str) -> None:
        self._tokens[key] = self._network.clock()

    def list_tokens(self, key: str) -> list[str]:
        seen_s = self._network.clock() - self._network.token_s
        return [
            token
            for member in list(self._network.members)
            for token, since_s in list(member._tokens.items())
            if fnmatchcase(token, key) and (member is self or since_s <= seen_s)
        ]

    def answer(self, key: str, answer: Callable[[bytes], bytes]) -> None:
        self._answers[key] = answer

    def ask(self, key: str, question: bytes, *, timeout_s: float = 2.0) -> dict[str, bytes]:
        """Ask one after another, in this thread; an answer that takes longer than `timeout_s` does not count."""
        found, clock = dict[str, bytes](), self._network.clock
        for member in [each for each in self._network.members if not each.is_dead]:
            for theirs, answer in list(member._answers.items()):
                if fnmatchcase(theirs, key):
                    until_s = clock() + timeout_s
                    said = answer(question)
                    if clock() <= until_s:
                        found[theirs] = said
        return found

    def close(self) -> None:
        if self in self._network.members:
            self._network.members.remove(self)


class MemoryTeam:
    """Agents of a team in threads of this process, by a simulated clock; robots hang on wires in memory.

    Parameters
    ----------
    team
        The team.
    libraries
        The folder of the library of each agent that has one of its own.
    """

    def __init__(self, team: LoadedTeam, libraries: Mapping[str, Path] | None = None) -> None:
        self.team, self.clock = team, SimulatedClock()
        self.network = MemoryNetwork(self.clock)
        self.visitor = self.network.join()
        self.wires: dict[str, Wire] = {}
        self.agents: dict[str, AgentProcess] = {}
        self._libraries = libraries or {}
        self._ends = Event()

    def make(self, name: str, *, has_robot: bool = True) -> AgentProcess:
        """Make an agent, which does not tick yet."""
        team = replace(self.team, library=self._libraries.get(name, self.team.library))
        made = AgentProcess(
            name,
            team if has_robot else replace(team, robots={}),
            self.network.join(),
            clock=self.clock,
            connect=self._connect,
        )
        self.agents[name] = made
        return made

    def _connect(self, path: Path, *, recorder: RunRecorder | None) -> Fleet:
        file = load_robot(path)
        self.wires[file.name] = wire = Wire()
        return Fleet([Robot(file, wire, path=path, clock=self.clock)], name=file.name)

    @contextmanager
    def run_agents(self) -> Iterator[None]:
        """Let all agents tick, each in a thread."""
        self._ends.clear()
        threads = [
            Thread(target=each.run, kwargs={"until": self._ends.is_set}, daemon=True)
            for each in self.agents.values()
        ]
        for thread in threads:
            thread.start()
        self.clock.expect(len(threads))
        try:
            yield
        finally:
            self._ends.set()
            self.clock.advance(1.0)
            for thread in threads:
                thread.join()

    def close(self) -> None:
        for each in self.agents.values():
            each.close()
