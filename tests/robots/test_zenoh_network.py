"""Agents over Zenoh: messages, presence and questions; and a coordinator that is killed, as over a local network."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Condition, Event, Thread
from typing import Any

import msgspec
import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")

from tests.robots.routers import Router, free_port
from tests.robots.test_load_plan import write_team
from tests.runtime.agents.test_lost_agents import NAMES, leaders, make_team
from tests.waiting import BOUND_S, wait_until

from understudy.addons.robots.team_network.agent_claim import claim_name
from understudy.addons.robots.team_network.agent_process import AgentProcess
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion, ask
from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions, complete_address
from understudy.errors import SettingError
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.network import Inbox, LocalNetwork, Observe

LOST_S = 0.5
"""A message that has not arrived after so long counts as lost, s."""


@contextmanager
def networks(*names: str) -> Iterator[dict[str, ZenohNetwork]]:
    """An access for each, on this machine."""
    made: dict[str, ZenohNetwork] = {}
    listening: list[str] = []
    for name in names:  # each connects to those before it: there is no waiting for those that come later
        mine = f"udp/127.0.0.1:{free_port()}"
        made[name] = ZenohNetwork(
            "test", ZenohOptions(connect=list(listening), listen=[mine], multicast=False)
        )
        listening.append(mine)
    with all_there(made):
        yield made


@contextmanager
def clients(*names: str) -> Iterator[dict[str, ZenohNetwork]]:
    """An access for each through a router, as docs/agents.md has it for large teams: no connections among agents."""
    with Router() as router:
        client = {"mode": "client", "listen/endpoints": []}
        options = ZenohOptions(connect=[router.endpoint], multicast=False, config=client)
        with all_there({name: ZenohNetwork("test", options) for name in names}) as made:
            yield made


@contextmanager
def all_there(made: dict[str, ZenohNetwork]) -> Iterator[dict[str, ZenohNetwork]]:
    """Announce all, wait until they see each other, and close them in the end."""
    try:
        for name, network in made.items():
            network.announce(name)
        for network in made.values():
            wait_until(partial(_sees, network, set(made)))
        yield made
    finally:
        for network in reversed(made.values()):  # before those to which it would connect again
            network.close()


def _sees(network: ZenohNetwork, names: set[str]) -> bool:
    return network.present >= names


@pytest.mark.timed
@pytest.mark.parametrize("joined", [networks, clients])
def test_messages_reach_all_who_listen_and_each_agent_answers_for_itself(joined: Any) -> None:
    with joined("one", "three", "two") as of:
        inboxes = [of[name].listen("order/pair") for name in ("two", "three", "three")]
        other = of["two"].listen("order/other")
        for inbox in inboxes:
            wait_until(partial(_is_heard, of["one"], inbox))
        for inbox in inboxes:
            inbox.take_all()
        of["one"].publish("order/pair", b"go")
        for inbox in inboxes:
            wait_until(partial(_has_come, inbox, b"go"))
        assert other.take_all() == []
        check_answers(of)
        check_parallel_questions(of)
        of["two"].close()
        wait_until(lambda: of["one"].present == {"one", "three"})


def _is_heard(network: ZenohNetwork, inbox: Inbox) -> bool:
    network.publish("order/pair", b"?")
    time.sleep(0.01)
    return bool(inbox.take_all())


def _has_come(inbox: Inbox, message: bytes) -> bool:
    return message in inbox.take_all()


def check_answers(of: dict[str, ZenohNetwork]) -> None:
    for name in ("one", "two"):
        answer = msgspec.msgpack.encode(AgentAnswer(log=[name]))
        of[name].answer(f"agent/{name}", partial(_answer, answer))
    of["two"].answer("agent/three", lambda data: b"\xc1")  # not to be understood
    wait_until(lambda: len(ask(of["one"], AgentQuestion("logs"))) == 2)
    assert {name: answer.log for name, answer in ask(of["one"], AgentQuestion("logs")).items()} == {
        "one": ["one"],
        "two": ["two"],
    }
    assert list(ask(of["one"], AgentQuestion("logs"), agent="two")) == ["two"]


def _answer(answer: bytes, question: bytes) -> bytes:
    return answer


def check_parallel_questions(of: dict[str, ZenohNetwork]) -> None:
    """A robot must be stopped even if its program answers nothing else any more."""
    asked, stopped = Event(), Event()

    def answer(data: bytes) -> bytes:
        if data == b"stop":
            stopped.set()
        asked.set()
        return b"" if stopped.wait(BOUND_S) else b"late"

    of["one"].answer("agent/busy", answer)
    wait_until(lambda: bool(of["two"].ask("agent/busy", b"stop")))
    asked.clear()
    stopped.clear()
    said: list[bytes] = []
    asking = Thread(
        target=lambda: said.extend(of["two"].ask("agent/busy", b"?", timeout_s=BOUND_S).values()), daemon=True
    )
    asking.start()
    assert asked.wait(BOUND_S)
    assert of["two"].ask("agent/busy", b"stop", timeout_s=BOUND_S) == {"agent/busy": b""}
    asking.join()
    assert said == [b""]


class CountedAccess:
    """One agent's access over Zenoh; the messages that are sent and that arrive are counted."""

    def __init__(self, network: ZenohNetwork, team: ZenohAgents) -> None:
        self._network, self._team = network, team
        self.keys: list[str] = []
        self.is_open = True

    def publish(self, key: str, message: bytes) -> None:
        self._team.expected += sum(
            each.keys.count(key) for each in self._team.joined.values() if each.is_open
        )
        self._network.publish(key, message)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        self.keys.append(key)
        return self._network.listen(key, self._team.count)

    def announce(self, name: str) -> None:
        """All have been announced."""

    @property
    def present(self) -> frozenset[str]:
        return self._network.present

    def close(self) -> None:
        self.is_open = False
        self._network.close()


class ZenohAgents(LocalNetwork):
    """The network of a `LocalTeam` whose agents speak over Zenoh; a step lasts until its messages have arrived."""

    def __init__(self, of: dict[str, ZenohNetwork]) -> None:
        super().__init__()
        self.joined = {name: CountedAccess(network, self) for name, network in of.items()}
        self.expected, self._arrived, self._changed = 0, 0, Condition()

    def count(self, message: bytes) -> None:
        with self._changed:
            self._arrived += 1
            self._changed.notify_all()

    def join(self, name: str) -> CountedAccess:  # type: ignore[override]
        return self.joined[name]

    def leave(self, name: str) -> None:
        """As if its program had been killed; it is not there yet when the team is made."""
        if self.step_number:
            self.joined[name].close()

    def step(self) -> None:
        """Some are lost at the beginning, while Zenoh does not know yet who listens."""
        self.step_number += 1
        with self._changed:
            self._changed.wait_for(lambda: self._arrived >= self.expected, LOST_S)
            self.expected = self._arrived = 0


def _all_go(team: LocalTeam) -> bool:
    team.tick()
    return team.paths == [("go", "forward")] * len(NAMES)


@pytest.mark.timed
def test_a_killed_coordinator_is_replaced_over_zenoh() -> None:
    names = (*NAMES, "pair_0")
    with networks(*names) as of:
        team = make_team(ZenohAgents(of), near=-1e9)
        wait_until(partial(_all_go, team))
        assert leaders(team) == ["pair_0"]
        team.stop("pair_0")
        paths = set()
        for _ in range(40):
            team.tick()
            paths |= set(team.paths)
        (deputy,) = leaders(team)
        assert deputy in NAMES
        assert paths == {("go", "forward")}  # nobody was restarted, and nobody was alone


ADDRESSES = [
    ("tcp/10.0.0.1:7447", "tcp/10.0.0.1:7447"),
    ("udp/10.0.0.1:7447", "udp/10.0.0.1:7447?rel=1;mixed_rel=1"),
    ("udp/10.0.0.1:7447#iface=eth0", "udp/10.0.0.1:7447?rel=1;mixed_rel=1#iface=eth0"),
    ("udp/10.0.0.1:7447?rel=0", "udp/10.0.0.1:7447?rel=0"),
    ("quic/10.0.0.1:7447", "quic/10.0.0.1:7447?mixed_rel=1"),
]


@pytest.mark.parametrize(("address", "complete"), ADDRESSES)
def test_datagrams_are_asked_for_where_zenoh_has_them(address: str, complete: str) -> None:
    assert complete_address(address) == complete


@pytest.mark.timed
def test_names_are_claimed_over_zenoh(tmp_path: Path) -> None:
    """That of an agent that answers nothing is free, and of those that are started later none gets it."""
    team = load_team_plan(write_team(tmp_path))
    with networks("second", "first", "killed") as of:
        of["killed"].declare_token("claim/patrol_0/0123456789abcdef")
        of["killed"].declare_token("held/patrol_0")
        wait_until(lambda: bool(of["first"].list_tokens("held/patrol_0")))
        assert not of["first"].is_present("patrol_0")
        process = AgentProcess("patrol_0", team, of["first"])
        wait_until(lambda: of["second"].is_present("patrol_0"))
        with pytest.raises(SettingError, match="patrol_0 is running already"):
            claim_name(of["second"], "patrol_0", team=team.name)
        assert process.ticks == 0
