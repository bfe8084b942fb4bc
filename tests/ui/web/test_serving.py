"""Serving: ports that are taken, tokens for other machines, pages that do not read."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from pathlib import Path
from statistics import median
from typing import Any

import pytest
from tests.ui.web.pages import Served, Wall
from websockets.asyncio.client import connect

from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web import clients
from understudy.ui.web.access import is_loopback, listen
from understudy.ui.web.clients import Client
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost


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
        viewer.show(frame=bytes([number]), news=b"desk %d" % number)
    for number in range(5):
        viewer.send_reply(b"answer %d" % number)
    taken = []
    while (found := viewer.next()) is not None:
        taken.append(found)
    assert taken == [
        *((b"answer %d" % number, False) for number in range(5)),
        (b"desk 99", False),
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
    scenario = find_scenario("arena")
    kit = make_scenario_kit(scenario)
    made = StudioServer(SessionHost(scenario, tmp_path, kit))
    behavior, feature = next(iter(kit.behaviors)), "time_in_state"

    async def drive(address: str) -> tuple[list[float], list[float], int]:
        async with connect(address, max_size=None) as person, connect(address, max_queue=1) as asleep:
            asleep.transport.pause_reading()
            waited, server_ms, frames, number = list[float](), list[float](), 0, 0

            async def say(message: dict[str, Any]) -> dict[str, Any]:
                nonlocal number, frames
                number += 1
                await person.send(json.dumps({"id": number, **message}))
                while True:
                    received = await asyncio.wait_for(person.recv(), 10)
                    if isinstance(received, bytes):
                        frames += 1
                        continue
                    answer: dict[str, Any] = json.loads(received)
                    if answer.get("re") == number:
                        assert answer.get("ok"), answer
                        return answer

            await say({"do": "speed", "speed": 16})
            await say({"do": "new", "name": "a", "states": [behavior], "features": [feature]})
            until = time.monotonic() + 2.0
            while time.monotonic() < until:
                began = time.monotonic()
                answer = await say({"do": "press", "state": behavior})
                server_ms.append(answer["ms"])
                waited.append(time.monotonic() - began)
                await asyncio.sleep(0.05)
            asleep.transport.abort()
            return waited, server_ms, frames

    with Served(made) as address:
        waited, server_ms, frames = asyncio.run(drive(address))
    # A page that is waited for holds up every press until it is given up, after seconds; how quick a press is
    # otherwise is measured by `understudy bench looks`.
    assert median(server_ms) < 500
    assert median(waited) < 0.5
    assert frames > 20


def test_a_port_where_somebody_else_listens(tmp_path: Path) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        address = listen("127.0.0.1", other.getsockname()[1], None)
        assert address.port != other.getsockname()[1]
        address.listener.close()
