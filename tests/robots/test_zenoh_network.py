"""Agents over Zenoh: messages, presence and questions; and a coordinator that is killed, as over a local network."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Barrier, Event, Thread

import msgspec
import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")

from tests.robots.routers import Router, free_port
from tests.robots.test_load_plan import write_team
from tests.runtime.agents.test_lost_agents import NAMES, leaders, make_team

from understudy.errors import SettingError
from understudy.robots.team_network.agent_claim import claim_name
from understudy.robots.team_network.agent_process import AgentProcess
from understudy.robots.team_network.agent_questions import AgentAnswer, AgentQuestion, ask
from understudy.robots.team_network.load_plan import load_team_plan
from understudy.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions, complete_address
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.network import Inbox, LocalNetwork

WAIT_S = 20.0


def wait_until(seen: Callable[[], bool]) -> None:
    until = time.monotonic() + WAIT_S
    while not seen():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.02)


@contextmanager
def networks(*names: str) -> Iterator[dict[str, ZenohNetwork]]:
    """An access for each, on this machine."""
    where = {name: f"udp/127.0.0.1:{free_port()}" for name in names}
    made = {
        name: ZenohNetwork("test", ZenohOptions(connect=list(where.values()), listen=[mine], multicast=False))
        for name, mine in where.items()
    }
    try:
        for name, network in made.items():
            network.announce(name)
        for network in made.values():
            wait_until(partial(_sees, network, names))
        yield made
    finally:
        for network in made.values():
            network.close()


def _sees(network: ZenohNetwork, names: tuple[str, ...]) -> bool:
    return network.present >= set(names)


def test_a_message_reaches_all_who_listen_and_who_left_is_gone() -> None:
    with networks("one", "two", "three") as of:
        inboxes = [of[name].listen("order/pair") for name in ("two", "three", "three")]
        other = of["two"].listen("order/other")
        wait_until(lambda: _is_heard(of["one"], inboxes[0]))
        for inbox in inboxes:
            inbox.take_all()
        of["one"].publish("order/pair", b"go")
        for inbox in inboxes:
            wait_until(partial(_has_come, inbox, b"go"))
        assert other.take_all() == []
        of["two"].close()
        wait_until(lambda: of["one"].present == {"one", "three"})


def _is_heard(network: ZenohNetwork, inbox: Inbox) -> bool:
    network.publish("order/pair", b"?")
    time.sleep(0.05)
    return bool(inbox.take_all())


def _has_come(inbox: Inbox, message: bytes) -> bool:
    return message in inbox.take_all()


def test_each_agent_answers_for_itself() -> None:
    with networks("one", "two") as of:
        for name in of:
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


def test_a_question_does_not_wait_for_the_answer_to_another_one() -> None:
    """A robot must be stopped even if its program answers nothing else any more."""
    with networks("one", "two") as of:
        stopped = Event()

        def answer(data: bytes) -> bytes:
            if data == b"stop":
                stopped.set()
            return b"" if stopped.wait(WAIT_S) else b"late"

        of["one"].answer("agent/one", answer)
        wait_until(lambda: bool(of["two"].ask("agent/one", b"stop")))
        stopped.clear()
        said: list[bytes] = []
        asking = Thread(
            target=lambda: said.extend(of["two"].ask("agent/one", b"?", timeout_s=WAIT_S).values())
        )
        asking.start()
        time.sleep(0.2)
        assert of["two"].ask("agent/one", b"stop", timeout_s=WAIT_S / 2) == {"agent/one": b""}
        asking.join()
        assert said == [b""]


class ZenohAgents(LocalNetwork):
    """The network of a `LocalTeam` whose agents speak over Zenoh."""

    def __init__(self, of: dict[str, ZenohNetwork]) -> None:
        super().__init__()
        self.of = of

    def join(self, name: str) -> ZenohNetwork:  # type: ignore[override]
        return self.of[name]

    def leave(self, name: str) -> None:
        """As if its program had been killed; it is not there yet when the team is made."""
        if self.step_number:
            self.of[name].close()

    def step(self) -> None:
        self.step_number += 1
        time.sleep(0.05)


def _all_go(team: LocalTeam) -> bool:
    team.tick()
    return team.paths == [("go", "forward")] * len(NAMES)


def test_a_killed_coordinator_is_replaced_over_zenoh() -> None:
    names = ("pair_0", *NAMES)
    with networks(*names) as of:
        team = make_team(ZenohAgents(of), near=-1e9)
        wait_until(partial(_all_go, team))
        assert leaders(team) == ["pair_0"]
        team.stop("pair_0")
        paths = set()
        for _ in range(40):
            team.tick()
            paths |= set(team.paths)
        (deputy,) = leaders(team)  # the first, unless its messages are late on a busy machine
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


@pytest.mark.parametrize("number", ["0" * 16, "f" * 16])
def test_an_agent_that_was_killed_does_not_keep_its_name(tmp_path: Path, number: str) -> None:
    """Others believe for some seconds that it is there; it answers nothing."""
    address = f"udp/127.0.0.1:{free_port()}"
    team = load_team_plan(write_team(tmp_path))
    killed = ZenohNetwork(team.name, ZenohOptions(listen=[address], multicast=False))
    again = ZenohNetwork(team.name, ZenohOptions(connect=[address], multicast=False))
    try:
        killed.announce("patrol_0")
        killed.declare_token(f"claim/patrol_0/{number}")
        killed.declare_token("held/patrol_0")
        wait_until(lambda: again.is_present("patrol_0") and bool(again.list_tokens("held/patrol_0")))
        process = AgentProcess("patrol_0", team, again)
        assert process.name == "patrol_0"
        process.close()
    finally:
        again.close()
        killed.close()


def test_a_second_agent_of_one_name_is_refused(tmp_path: Path) -> None:
    address = f"tcp/127.0.0.1:{free_port()}"
    file = write_team(tmp_path)
    team = load_team_plan(file)
    first = ZenohNetwork(team.name, ZenohOptions(listen=[address], multicast=False))
    second = ZenohNetwork(team.name, ZenohOptions(connect=[address], multicast=False))
    try:
        claim_name(first, "patrol_0", team=team.name)
        wait_until(lambda: bool(second.list_tokens("held/patrol_0")))
        third = ZenohNetwork(team.name, ZenohOptions(connect=[address], multicast=False))
        try:
            with pytest.raises(SettingError, match="patrol_0 is running already"):
                AgentProcess("patrol_0", team, third)
        finally:
            third.close()
    finally:
        second.close()
        first.close()


def test_of_two_that_are_started_at_the_same_moment_one_remains(tmp_path: Path) -> None:
    team = load_team_plan(write_team(tmp_path))
    address = f"tcp/127.0.0.1:{free_port()}"
    meeting = ZenohNetwork(team.name, ZenohOptions(listen=[address], multicast=False))
    networks = [ZenohNetwork(team.name, ZenohOptions(connect=[address], multicast=False)) for _ in range(4)]
    refused: list[str] = []
    running: list[AgentProcess] = []
    together = Barrier(len(networks))

    def start(network: ZenohNetwork) -> None:
        together.wait()
        try:
            running.append(AgentProcess("patrol_0", team, network))
        except SettingError as error:
            refused.append(str(error))

    try:
        starting = [Thread(target=start, args=(network,)) for network in networks]
        for each in starting:
            each.start()
        for each in starting:
            each.join()
        assert len(running) == 1
        assert len(refused) == len(networks) - 1
        together_or_later = (
            "patrol_0 was started twice at the same moment; let the other one run",
            "patrol_0 is running already; stop the other one first",
        )
        assert all(any(each in said for each in together_or_later) for said in refused), refused
    finally:
        for network in (*networks, meeting):
            network.close()


def test_a_coordinator_without_members_says_whom_it_never_heard(tmp_path: Path) -> None:
    team = load_team_plan(write_team(tmp_path))
    network = ZenohNetwork(team.name, ZenohOptions(multicast=False))
    process = AgentProcess("patrol_0", team, network)
    try:
        until = time.monotonic() + 0.8
        process.run(until=lambda: time.monotonic() > until)
        said = process.describe()
        assert said.leads == {}  # there is nobody to lead
        assert said.missing == dict.fromkeys(("pioneer_1", "pioneer_2", "pioneer_3"), "was never heard")
        assert said.unfit == ""
    finally:
        process.close()


def test_clients_hear_each_other_through_a_router() -> None:
    """As docs/agents.md has it for large teams: no connections among agents."""
    with Router() as router:
        client = {"mode": "client", "listen/endpoints": []}
        options = ZenohOptions(connect=[router.endpoint], multicast=False, config=client)
        one, two = ZenohNetwork("test", options), ZenohNetwork("test", options)
        try:
            one.announce("one")
            wait_until(lambda: "one" in two.present)
            inbox = two.listen("order/pair")
            wait_until(lambda: _is_heard(one, inbox))
        finally:
            one.close()
            two.close()
