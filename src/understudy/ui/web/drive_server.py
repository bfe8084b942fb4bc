"""The server of a drive under way: take the ticks that are due, and exchange messages with the page that drives."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

import msgspec
from msgspec import field

from understudy.clock import REAL_TIME
from understudy.errors import UnderstudyError
from understudy.model.features import BoundFeature
from understudy.model.library import Kit
from understudy.sim.body_world import BodyWorld
from understudy.sim.sensing.sensor_table import list_range_scans
from understudy.storage.json_text import encode_json
from understudy.ui.controller.key_bindings import Arrow
from understudy.ui.controller.live_drive import LiveDrive
from understudy.ui.controller.status import describe_error
from understudy.ui.controller.stick import StickPosition
from understudy.ui.web import frames
from understudy.ui.web.clients import Client, Wait, repeat_each_frame
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.drive import (
    AnyDriveRequest,
    BeginDriving,
    BeginWorld,
    LetAutomatonDrive,
    SteerRobot,
)
from understudy.ui.web.server import PICTURE_S, SceneNewsData
from understudy.ui.web.views.scene import FeatureData, describe_scene

_read = msgspec.json.Decoder(AnyDriveRequest).decode


class DriveNewsData(Data, frozen=True, kw_only=True, tag_field="is", tag="drive"):
    """The state of a drive under way."""

    driving: bool
    waiting: bool
    """Whether the world stands still until the stick is moved."""
    automatic: bool
    """Whether the automaton that was learned drives, until the stick is moved."""
    state: str
    """The state of the automaton that drives; empty if none does."""
    is_current: bool = field(name="current")
    """Whether the review has everything that was driven."""
    version: int
    """Grows whenever the review changes."""
    ticks: int
    """The number of ticks, up to the last pause."""
    directions: list[Arrow]
    """The ways in which the stick commands anything."""
    held: list[str]
    """The names of the behaviors that are carried out while their buttons are held."""
    features: list[FeatureData]
    """The features whose values frames have."""
    folder: str | None
    """The folder in which drives are kept."""
    error: str


class DriveServer:
    """The server of one drive; `folder` is where drives are kept, if they are.

    `wall` is the clock (s) for message rates and pictures; `wait` lets other tasks run until the next frame is due.
    """

    def __init__(
        self,
        live: LiveDrive,
        kit: Kit,
        features: Sequence[BoundFeature],
        *,
        folder: str | None = None,
        wall: Callable[[], float] = REAL_TIME,
        wait: Wait = asyncio.sleep,
    ) -> None:
        self.live = live
        self._kit, self._features, self._folder = kit, features, folder
        self._wall, self._wait = wall, wait
        self._described = [FeatureData.of_kind(each.kind, str(each), each.feature.unit) for each in features]
        self._page: Client | None = None
        self._shown: DriveNewsData | None = None
        self._picture_due_s = 0.0
        world = live.world
        kind = world.names.types[int(world.state.robots["type"][live.agent])]
        scans = list_range_scans(world.scenario.types[kind]) if not isinstance(world, BodyWorld) else ()
        self._beams = [(arc.reading, None) for scan in scans for arc in scan.arcs]

    def connect(self) -> Client:
        """Let a page drive from here on, in place of the former one, and return its client."""
        if self._page is not None:
            self.disconnect(self._page)
        page = self._page = Client("", self._wall)
        self._shown = None
        self.show_world()
        self.show()
        return page

    def disconnect(self, page: Client) -> None:
        """Pause if this page drives: nobody does from here on."""
        page.close()
        if page is self._page:
            self._page = None
            self.live.pause()

    @property
    def is_driven(self) -> bool:
        """Whether any page drives."""
        return self._page is not None

    def hear(self, page: Client, text: str | bytes) -> None:
        """Carry out a message of a page if it is the one that drives, and sends no more than it may."""
        if page.allow_message() and page is self._page:
            self.handle_text("" if isinstance(text, bytes) else text)

    def handle_text(self, text: str) -> None:
        """Carry out a message of the page; what is wrong with it is shown."""
        live = self.live
        try:
            match _read(text):
                case SteerRobot(right=right, up=up, held=held):
                    live.steer(StickPosition(right, up, frozenset(held)))
                    return
                case BeginDriving():
                    live.drive()
                case LetAutomatonDrive():
                    live.let_automaton_drive()
                case BeginWorld(seed=seed):
                    live.begin_world(live.world.seeds[0] + 1 if seed is None else seed)
                    self.show_world()
                case _:
                    live.pause()
        except (UnderstudyError, msgspec.DecodeError) as error:
            live.error = describe_error(error)
        self.show()

    async def run(self) -> None:
        """Run the drive until cancelled, then end it so that it is kept."""
        try:
            await repeat_each_frame(self.advance, clock=self._wall, wait=self._wait)
        finally:
            self.live.close()

    def advance(self) -> None:
        """Take the ticks that are due, and send the page what changed; on an error, pause and show its message."""
        try:
            ticks = self.live.advance()
            self.show()
            if ticks:
                self.show_frame()
        except Exception as error:  # such as of a picture of a body of the user's own
            self.live.pause()
            self.live.error = describe_error(error)

    def show_world(self) -> None:
        """Send the page the scene and the present moment."""
        if self._page is not None:
            scene = describe_scene(self.live.world, self._kit, [])
            self._page.show(scene=encode_json(SceneNewsData(scene=scene)))
        self._picture_due_s = 0.0
        self.show_frame()

    def show_frame(self) -> None:
        """Send the page the present moment."""
        live, page = self.live, self._page
        if page is None:
            return
        world = live.world
        frame = frames.encode_frame(
            world.view(),
            tick=int(world.state.tick[0]),
            agent=live.agent,
            bits=frames.OPEN | frames.PAUSED * (not (live.driving or live.automatic)),
            features=live.list_readings(self._features),
            sonar=[float(live.percept[key][live.agent]) for key in self._beams],
        )
        page.show(frame=frame)
        if isinstance(world, BodyWorld) and world.has_picture and self._wall() >= self._picture_due_s:
            self._picture_due_s = self._wall() + PICTURE_S
            picture = world.render()
            if picture is not None:
                page.show(picture=frames.encode_picture(picture))

    def show(self) -> None:
        """Send the page the state of the drive, if it changed."""
        live, page = self.live, self._page
        if page is None:
            return
        layout = live.layout
        news = DriveNewsData.of(
            live,
            state=live.find_automaton_state(),
            ticks=0 if live.driving else live.ticks,
            directions=layout.list_ways(),
            held=[each.name for each in layout.held],
            features=self._described,
            folder=self._folder,
        )
        if news != self._shown:
            self._shown = news
            page.show(news=encode_json(news))
