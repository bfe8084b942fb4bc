"""Serving: ports that are taken, tokens for other machines, pages that do not read."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path

import pytest
from tests.make.studios import Wall
from tests.ui.web.simulated_pages import LONGEST_S, SimulatedPage, SimulatedTime, connect_pages

from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web import clients
from understudy.ui.web.access import is_loopback, listen
from understudy.ui.web.clients import Client
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

MOST_FRAMES = 2
"""How many frames may begin before a press is answered: a page that is waited for holds it up forever."""


def test_the_next_free_port(tmp_path: Path) -> None:
    first = listen("127.0.0.1", 0, None)
    second = listen("127.0.0.1", first.port, None)
    assert second.port > first.port
    assert first.link == f"http://127.0.0.1:{first.port}/"
    with socket.create_connection(("127.0.0.1", first.port)):
        taken, _ = first.listener.accept()
        assert taken.proto == socket.IPPROTO_TCP, (
            "asyncio lets answers leave at once where it knows that it is TCP"
        )
        taken.close()
    first.listener.close()
    second.listener.close()


HOSTS = [("127.0.0.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("192.168.1.7", False)]


@pytest.mark.parametrize(("host", "loopback"), HOSTS)
def test_other_machines_need_a_token(host: str, loopback: bool) -> None:
    assert is_loopback(host) is loopback


@pytest.mark.parametrize("given", [None, ""])
def test_a_token_is_made_up(given: str | None) -> None:
    address = listen("0.0.0.0", 0, given)
    assert address.token is not None
    assert len(address.token) >= 20
    assert address.link.endswith(f"?token={address.token}")
    address.listener.close()


def test_an_address_that_is_not_here() -> None:
    with pytest.raises(SettingError, match="--host"):
        listen("203.0.113.77", 0, None)


def test_a_slow_page_misses_frames_and_nothing_else() -> None:
    viewer = Client("key", Wall())
    for number in range(100):
        viewer.show(frame=bytes([number]), news=b"news %d" % number)
    for number in range(5):
        viewer.send_reply(b"answer %d" % number)
    taken = []
    while (found := viewer.next()) is not None:
        taken.append(found)
    assert taken == [
        *((b"answer %d" % number, False) for number in range(5)),
        (b"news 99", False),
        (b"c", True),
    ]
    assert not viewer.closing


def test_a_page_that_never_reads_is_let_go() -> None:
    viewer = Client("key", Wall())
    for _ in range(clients.MOST_WAITING + 1):
        viewer.send_reply(b"answer")
    assert viewer.closing
    assert viewer.next() is None


def test_a_page_that_does_not_read_holds_up_nobody(tmp_path: Path) -> None:
    """One page stops reading while the world runs fast; the director's presses are answered at once all the same."""
    scenario, time = find_scenario("arena"), SimulatedTime()
    kit = make_scenario_kit(scenario)
    behavior = next(iter(kit.behaviors))

    async def drive() -> None:
        made = StudioServer(SessionHost(scenario, tmp_path, kit, wall=time), wall=time, wait=time.wait)
        person, asleep = SimulatedPage(time), SimulatedPage(time)
        async with connect_pages(made, person, asleep):
            await asleep.hear()
            asleep.socket.reads.clear()
            await person.say("speed", speed=16)
            await person.say("new", name="a", states=[behavior], features=["time_in_state"])
            waits = list[int]()
            for _ in range(40):
                answer, frames = await person.say("press", state=behavior)
                assert answer["ms"] == 0.0, "it was in the journal before any time passed"
                waits.append(frames)
                await person.hear_frame()
            assert max(waits) <= MOST_FRAMES, waits
            assert person.frames > 20
            missed = asleep.socket.heard.qsize()
            assert len(made.viewers) == 2
            asleep.socket.reads.set()
            await asleep.hear_frame()
            assert missed + 10 > asleep.frames, "it misses frames, and gets the newest"

    asyncio.run(asyncio.wait_for(drive(), LONGEST_S))


def test_a_port_where_somebody_else_listens(tmp_path: Path) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        address = listen("127.0.0.1", other.getsockname()[1], None)
        assert address.port != other.getsockname()[1]
        address.listener.close()
