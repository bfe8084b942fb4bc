"""What the tests of the studio share: a studio in a folder, and a page that says things and hears the answers."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

import msgspec
from starlette.testclient import TestClient, WebSocketTestSession

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web.app import make_app
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

PICTURE = 2
"""The first byte of a picture."""
HOME = "http://127.0.0.1"
GOTO: dict[str, Any] = {
    "do": "new",
    "name": "goto",
    "states": ["forward", "rotate_left", "rotate_right"],
    "features": ["distance_to(A)", "angle_to(A)"],
    "parameters": ["A"],
    "flags": ["done"],
    "targets": {"A": "station"},
    "live": False,
}


class Wall:
    """A clock that moves when told, and a little whenever it is looked at."""

    def __init__(self, glance: float = 0.0) -> None:
        self.now, self.glance = 0.0, glance

    def __call__(self) -> float:
        self.now += self.glance
        return self.now


def to_json(data: object) -> Any:
    """Data of the studio as a page gets it."""
    return msgspec.to_builtins(data)


def make_studio(
    folder: Path, *, world: str = "forage", seed: int = 0, wall: Wall | None = None
) -> StudioServer:
    """A studio whose world moves only when told, and where pages may speak as fast as they like."""
    scenario = find_scenario(world)
    host = SessionHost(scenario, folder, make_scenario_kit(scenario), seed=seed, wall=wall or Wall())
    return StudioServer(host, wall=wall or Wall(glance=0.01))


@dataclass
class Frame:
    """A frame read without the code that wrote it."""

    kind: int
    bits: int
    time_s: float
    state: int
    agent: int
    tick: int
    robots: list[tuple[Any, ...]]
    objects: list[tuple[Any, ...]]
    features: list[float]
    sonar: list[float]
    delivered: int

    @classmethod
    def read(cls, data: bytes) -> Frame:
        kind, bits, robots, objects, features, time_s, state, agent, tick = struct.unpack_from(
            "<BBHHHdHHI", data
        )
        at = 24
        rows = [struct.unpack_from("<fffHH", data, at + 16 * row) for row in range(robots)]
        at += 16 * robots
        things = [struct.unpack_from("<HHffHH", data, at + 16 * row) for row in range(objects)]
        at += 16 * objects
        values = list(struct.unpack_from(f"<{features}f", data, at))
        at += 4 * features
        (sonars,) = struct.unpack_from("<H", data, at)
        sonar = list(struct.unpack_from(f"<{sonars}f", data, at + 2))
        at += 2 + 4 * sonars
        (delivered,) = struct.unpack_from("<I", data, at)
        assert len(data) == at + 4
        return cls(kind, bits, time_s, state, agent, tick, rows, things, values, sonar, delivered)


@dataclass
class Page:
    """A page: it says things and keeps what it was shown."""

    socket: WebSocketTestSession
    hello: dict[str, Any] = field(default_factory=dict)
    scene: dict[str, Any] = field(default_factory=dict)
    news: dict[str, Any] = field(default_factory=dict)
    frame: Frame | None = None
    picture: bytes | None = None
    answers: dict[int | None, dict[str, Any]] = field(default_factory=dict)
    numbers: Iterator[int] = field(default_factory=lambda: count(1))

    def hear(self) -> dict[str, Any]:
        """Take in the next thing the studio sends."""
        received = self.socket.receive()
        if received["type"] == "websocket.close":
            raise ConnectionError(received)
        if (data := received.get("bytes")) is not None and data[0] == PICTURE:
            self.picture = data[1:]
            return {"is": "picture"}
        if received.get("bytes") is not None:
            self.frame = Frame.read(received["bytes"])
            return {"is": "frame"}
        said: dict[str, Any] = json.loads(received["text"])
        if "re" in said:
            self.answers[said["re"]] = said
        elif said["is"] == "hello":
            self.hello, self.scene = said, said["scene"]
        elif said["is"] == "scene":
            self.scene = said["scene"]
        else:
            self.news = said
        return said

    def say(self, do: str, **fields: Any) -> dict[str, Any]:
        """Say something, and wait for its answer."""
        return self.send({"do": do, **fields})

    def send(self, message: dict[str, Any]) -> dict[str, Any]:
        number = next(self.numbers)
        self.socket.send_text(json.dumps({"id": number, **message}))
        return self.answer(number)

    def answer(self, number: int | None) -> dict[str, Any]:
        while number not in self.answers:
            self.hear()
        return self.answers.pop(number)

    def done(self, do: str, **fields: Any) -> dict[str, Any]:
        """Say something that must work."""
        answer = self.say(do, **fields)
        assert answer.get("ok") is True, answer
        return answer

    def wait_for_news(self) -> dict[str, Any]:
        """Wait until the state of the session is sent."""
        while self.hear().get("is") != "session":
            pass
        return self.news


@contextmanager
def open_page(client: TestClient, query: str = "") -> Iterator[Page]:
    with client.websocket_connect(f"ws://127.0.0.1/ws{query}") as socket:
        arrived = Page(socket)
        while not (arrived.hello and arrived.news and arrived.frame):
            arrived.hear()
        yield arrived


@contextmanager
def serve_studio(made: StudioServer) -> Iterator[TestClient]:
    with TestClient(make_app(made), base_url=HOME) as client:
        yield client


def teach(person: Page, *states: str) -> None:
    """Pause, then press each state, with a tick after each."""
    person.done("pause", paused=True)
    for state in states:
        person.done("press", state=state)
        person.done("step")
