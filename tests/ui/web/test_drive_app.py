"""Driving as a page does: messages of the stick, frames and news that come back, and the review of the drive."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect
from tests.make.studios import Wall

from understudy.ui.cli.commands.studio_drive import make_drive_server
from understudy.ui.cli.studio_options import DrivingOptions
from understudy.ui.controller.stick import StickPosition
from understudy.ui.web.drive_app import make_drive_app
from understudy.ui.web.drive_server import DriveServer
from understudy.ui.web.frames import HEADER, ROBOT
from understudy.ui.web.sockets import TAKEN

HERE = "http://127.0.0.1"
FRAME_S = 1 / 60


def make_server(folder: Path, wall: Wall) -> DriveServer:
    options = DrivingOptions(scenario="forage", seed=3, library=folder / "library", no_record=True)
    return make_drive_server(options, wall=wall)[0]


@pytest.fixture
def wall() -> Wall:
    """The clock of the drive, which moves when told."""
    return Wall()


@pytest.fixture
def server(tmp_path: Path, wall: Wall) -> DriveServer:
    return make_server(tmp_path, wall)


@pytest.fixture
def client(server: DriveServer) -> Iterator[TestClient]:
    with TestClient(make_drive_app(server), base_url=HERE) as client:
        yield client


class Driver:
    """A page: what it heard last of each sort."""

    def __init__(self, socket: WebSocketTestSession) -> None:
        self._socket = socket
        self.news: dict[str, Any] = {}
        self.scene: dict[str, Any] = {}
        self.frame = b""

    def send(self, **request: Any) -> None:
        self._socket.send_json(request)

    def hear(self) -> None:
        """Take the next message."""
        message = self._socket.receive()
        if message["type"] == "websocket.close":
            raise WebSocketDisconnect(message["code"])
        if message.get("bytes") is not None:
            self.frame = message["bytes"]
            return
        said = msgspec.json.decode(message["text"])
        if said["is"] == "scene":
            self.scene = said["scene"]
        else:
            self.news = said

    def hear_until(self, **state: Any) -> None:
        """Take messages until the news say this."""
        while any(self.news.get(name) != value for name, value in state.items()):
            self.hear()

    def read_place(self) -> tuple[float, float]:
        robots = memoryview(self.frame)[HEADER.itemsize : HEADER.itemsize + ROBOT.itemsize]
        x, y = robots[:8].cast("f")
        return x, y


@contextmanager
def visit(client: TestClient) -> Iterator[Driver]:
    with client.websocket_connect("ws://127.0.0.1/drive") as socket:
        driver = Driver(socket)
        driver.hear_until(ticks=0)
        while not driver.frame:
            driver.hear()
        yield driver


class Stick:
    """The stick of a page, which is held while simulated time passes."""

    def __init__(self, client: TestClient, server: DriveServer, wall: Wall) -> None:
        self._client, self._server, self._wall = client, server, wall

    def hold(self, driver: Driver, seconds: float, **stick: Any) -> None:
        """Hold the stick for some time, once the server has heard of its position."""
        driver.send(do="steer", **stick)
        heard = StickPosition(stick.get("right", 0.0), stick.get("up", 0.0))
        portal = self._client.portal
        assert portal is not None
        while portal.call(lambda: self._server.live.stick) != heard:
            pass
        for _ in range(round(seconds / FRAME_S)):
            portal.call(self._pass_frame, heard)

    def let_pass(self, seconds: float) -> None:
        """Let time pass with the stick at rest."""
        portal = self._client.portal
        assert portal is not None
        for _ in range(round(seconds / FRAME_S)):
            portal.call(self._pass_frame, None)

    def _pass_frame(self, stick: StickPosition | None) -> None:
        self._wall.now += FRAME_S
        if stick is not None:
            self._server.live.steer(stick)
        self._server.advance()


@pytest.fixture
def stick(client: TestClient, server: DriveServer, wall: Wall) -> Stick:
    return Stick(client, server, wall)


def wait_until_paused(client: TestClient, server: DriveServer) -> None:
    """Wait until the server has noticed that the page has left."""
    assert client.portal is not None
    while client.portal.call(lambda: server.live.driving or server.live.automatic):
        pass


def list_labels(client: TestClient) -> list[str]:
    review = client.get("/review").json()
    return [review["labels"][each["label"]] for each in review["spans"]]


def test_what_a_page_hears_first(client: TestClient) -> None:
    with visit(client) as driver:
        assert (driver.scene["scenario"], driver.scene["seed"]) == ("forage", 3)
        assert driver.news["held"] == ["load_food", "unload_food"]
        assert (driver.news["directions"], driver.news["driving"]) == (["up", "right", "left"], False)
        assert "distance_to(station)" in {each["label"] for each in driver.news["features"]}
    answer = client.get("/review")
    assert (answer.status_code, "nothing was driven yet" in answer.json()["error"]) == (400, True)
    assert client.get("/series").status_code == 400
    assert "Understudy: driving" in client.get("/").text


def test_driven_reviewed_and_learned(client: TestClient, stick: Stick) -> None:
    with visit(client) as driver:
        before = driver.read_place()
        driver.send(do="drive")
        driver.hear_until(driving=True, waiting=True)
        stick.hold(driver, 1.5, up=1.0)
        driver.hear_until(waiting=False)
        refused = client.post("/review", json={"do": "learn"})
        assert (refused.status_code, "pause it" in refused.json()["error"]) == (400, True)
        stick.hold(driver, 1.0, right=-1.0)
        driver.send(do="pause_drive")
        driver.hear_until(driving=False, current=True)
        assert driver.read_place() != before
        assert list_labels(client) == ["forward", "rotate_left"]
        series = client.get("/series").json()
        assert len(series["path"]) == driver.news["ticks"] == len(series["series"][0]["ticks"])
        learned = client.post("/review", json={"do": "learn"}).json()["learned"]
        assert {(each["from"], each["to"]) for each in learned["edges"]} >= {("forward", "rotate_left")}


def test_the_automaton_drives_and_the_stick_takes_over(
    client: TestClient, server: DriveServer, stick: Stick
) -> None:
    with visit(client) as driver:
        driver.send(do="drive")
        driver.hear_until(driving=True)
        stick.hold(driver, 1.5, up=1.0)
        stick.hold(driver, 1.0, right=-1.0)
        driver.send(do="pause_drive")
        driver.hear_until(driving=False, current=True)
        driver.send(do="let_drive")
        while "learn first" not in driver.news["error"]:
            driver.hear()
        learned = client.post("/review", json={"do": "learn"})
        assert learned.status_code == 200, learned.text
        driver.send(do="let_drive")
        driver.hear_until(automatic=True, error="")
        refused = client.post("/review", json={"do": "undo"})
        assert (refused.status_code, "pause it" in refused.json()["error"]) == (400, True)
        before = driver.read_place()
        stick.let_pass(1.0)
        driver.hear_until(state="forward")
        while driver.read_place() == before:
            driver.hear()
        stick.hold(driver, 0.5, right=1.0)
        driver.hear_until(automatic=False, driving=True, state="")
        driver.send(do="let_drive")
        while "pause first" not in driver.news["error"]:
            driver.hear()
        driver.send(do="pause_drive")
        driver.hear_until(driving=False, current=True)
        learned = client.post("/review", json={"do": "learn"})
        assert learned.status_code == 200, learned.text
        driver.send(do="let_drive")
        driver.hear_until(automatic=True)
    wait_until_paused(client, server)
    assert not server.live.automatic


def test_a_page_that_leaves_pauses(client: TestClient, server: DriveServer, stick: Stick) -> None:
    with visit(client) as driver:
        driver.send(do="drive")
        stick.hold(driver, 0.5, up=1.0)
    wait_until_paused(client, server)
    assert not server.live.driving
    assert server.live.stick.is_resting
    assert server.live.ticks > 0


def test_one_page_drives(client: TestClient) -> None:
    with visit(client) as first, visit(client) as second:
        second.send(do="drive")
        second.hear_until(driving=True)
        with pytest.raises(WebSocketDisconnect) as closed:
            first.hear_until(driving=True)
        assert closed.value.code == TAKEN


REFUSED = [  # message, what is said
    ({"do": "steer", "up": 1.5}, "<= 1"),
    ({"do": "dance"}, "dance"),
    ({"do": "drive", "fast": True}, "fast"),
    ({"do": "new_world", "seed": -1}, ">= 0"),
]


@pytest.mark.parametrize(("message", "said"), REFUSED)
def test_refused(client: TestClient, message: dict[str, Any], said: str) -> None:
    with visit(client) as driver:
        driver.send(**message)
        while not driver.news["error"]:
            driver.hear()
        assert said in driver.news["error"]


def test_another_world(client: TestClient) -> None:
    with visit(client) as driver:
        driver.send(do="new_world")
        while driver.scene["seed"] != 4:
            driver.hear()
        driver.send(do="new_world", seed=9)
        while driver.scene["seed"] != 9:
            driver.hear()
        driver.send(do="drive")
        driver.send(do="new_world")
        driver.hear_until(driving=True)
        while not driver.news["error"]:
            driver.hear()
        assert "pause first" in driver.news["error"]


def test_who_may_drive(tmp_path: Path) -> None:
    app = make_drive_app(make_server(tmp_path, Wall()), token="secret", hosts=None)
    with TestClient(app, base_url=HERE) as client:
        for path, status in (("/review", 403), ("/series", 403), ("/review?token=secret", 400)):
            assert client.get(path).status_code == status
        with client.websocket_connect("ws://127.0.0.1/drive") as socket, pytest.raises(WebSocketDisconnect):
            socket.receive_text()
        with client.websocket_connect("ws://127.0.0.1/drive?token=secret") as socket:
            assert socket.receive()["type"] == "websocket.send"
