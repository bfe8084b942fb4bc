"""The studio's server: run the ticks that are due, update every connected page, and answer its messages."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from enum import StrEnum

import msgspec
from msgspec import UNSET, UnsetType

from understudy import __version__
from understudy.addons.robots.team_network.team_watch import TeamWatch
from understudy.clock import REAL_TIME
from understudy.errors import SessionError
from understudy.sim.world import World
from understudy.storage.json_text import encode_json
from understudy.ui.controller.arming import RobotStatus
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.web.actions import handler_table
from understudy.ui.web.background import SlowAction, SlowActions
from understudy.ui.web.clients import PER_SECOND, Client, Clients, Wait, repeat_each_frame
from understudy.ui.web.failure_results import FailuresData
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.base import Data, Message
from understudy.ui.web.places import PlacesData
from understudy.ui.web.property_list import LibraryPropertiesData
from understudy.ui.web.rewind import RunData
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.exports import ExportTargetData, describe_export_targets
from understudy.ui.web.views.library import LibraryData
from understudy.ui.web.views.scene import SceneData
from understudy.ui.web.views.session import SessionData
from understudy.ui.web.views.watched_team import TeamData, describe_team, drive_trained_robots

PICTURE_S = 1 / 30
"""The least time (s) between two pictures of a body that draws itself."""
SESSION_S = 1 / 20
"""The least time (s) between two updates of the session, except after a message."""
TEAM_S = 1 / 10
"""The least time (s) between two updates of a team that is watched."""
LEFT = "Paused: no page is in control"
RETURNED = "Going on: the page is here again"
RETURN_S = 30.0
"""How long after a page in control left the run goes on when it comes back, s."""
LEFT_ROBOTS = "no page is in control in the studio"


class Offer(StrEnum):
    """What not every place can do beside letting a person teach."""

    RUNS = "runs"
    """Runs in other worlds beside the one on the page: tests, scores, failing worlds and properties."""


class HelloData(Data, frozen=True, kw_only=True, tag_field="is", tag="hello"):
    """The first message to a page that connects."""

    version: str
    key: str
    """The key that gives control back to this page after a lost connection."""
    has_control: bool
    exports: list[ExportTargetData]
    """The targets that automata can be exported to."""
    offers: list[Offer]
    """What can be done here; the page leaves out the rest."""
    storage_note: str
    """Where the library is kept, if that is not in files; else empty."""
    closed: str
    """Why no page can take control; empty if one can."""
    scene: SceneData
    team: TeamData | UnsetType = UNSET
    """The running team that is watched, if there is one."""


class SceneNewsData(Data, frozen=True, kw_only=True, tag_field="is", tag="scene"):
    """A change of the scene."""

    scene: SceneData


class TeamNewsData(Data, frozen=True, kw_only=True, tag_field="is", tag="team"):
    """A change of the running team that is watched."""

    team: TeamData


class SessionNewsData(Data, frozen=True, kw_only=True, tag_field="is", tag="session"):
    """The state of the open session, the library, the run and the connected pages."""

    library: LibraryData
    session: SessionData | None
    message: StatusMessage
    message_number: int
    """Grows with every message, so that one that says the same as the last is known for a new one."""
    viewers: int
    paused: bool
    speed: m.SpeedFactor
    seed: int | None
    sort: str | None
    """The sort of squads whose coordinator is in training; null for a robot."""
    robots: list[RobotStatus]
    """The states of the real robots; empty in simulation."""
    run: RunData
    places: PlacesData
    failures: FailuresData | None
    """The failing worlds; null where there can be none."""
    properties: LibraryPropertiesData | None
    """The properties of the library's file; null where the world is not simulated."""
    is_controlled: bool
    """Whether any client has control."""
    can_take_control: bool
    """Whether a page that asks for control gets it."""
    has_control: bool
    """Whether this page has control."""


class AnswerData(Data, frozen=True, kw_only=True):
    """The answer to a request: whether it succeeded, or the error message."""

    re: int | None
    """The number of the request; null if it could not be read."""
    ok: bool | UnsetType = UNSET
    error: str | UnsetType = UNSET
    ms: float | UnsetType = UNSET
    """The time from receiving a press until it was in the journal, ms."""


class StudioServer:
    """The server of one session host and all connected pages.

    `wall` is the clock (s) for message rates and updates; `wait` lets other tasks run until the next frame is due.
    `storage_note` says where the library is kept, if that is not in files; `closed` says why no page may take control,
    if none may.
    """

    def __init__(
        self,
        host: SessionHost,
        *,
        wall: Callable[[], float] = REAL_TIME,
        wait: Wait = asyncio.sleep,
        watch: TeamWatch | None = None,
        storage_note: str = "",
        closed: str = "",
    ) -> None:
        self.host, self.viewers, self._wall, self._wait = host, Clients(wall, closed), wall, wait
        self._storage_note = storage_note
        self._watch = watch
        self._team: TeamData | None = None if watch is None else describe_team(watch)
        self._team_due_s = 0.0
        self._frame = b""
        self._moved = self._rebuilt = self._pictured = -1
        self._picture_due_s = 0.0
        self._seen: tuple[SceneData, LibraryData] | None = None
        self._shown: SessionNewsData | None = None
        self._directed: Client | None = None
        self._places = self._list_places()
        self._said, self._said_number = host.status, 0
        self._slow = SlowActions(host.beside.at_once)
        self._left: tuple[str, float] | None = None  # key of the page whose leaving stopped the run, and when
        self._due_s = 0.0

    # Pages

    def connect(self, key: str | None) -> Client:
        """Register a page that connects, queue the scene, session and frame for it, and return its client."""
        former = self.viewers.director
        viewer = self.viewers.connect(key)
        if former is not None and viewer is self.viewers.director:
            self.host.robots.disarm(LEFT_ROBOTS)  # it comes again since its connection was lost
        scene, library = self._see_rebuilt()
        has_control = viewer is self.viewers.director
        if has_control:
            self._resume_after(viewer)
        hello = HelloData(
            version=__version__,
            key=viewer.key,
            has_control=has_control,
            exports=describe_export_targets(),
            offers=[] if self.host.beside.begin is None else [Offer.RUNS],
            storage_note=self._storage_note,
            closed=self.viewers.closed,
            scene=scene,
            team=UNSET if self._team is None else self._team,
        )
        viewer.send_reply(encode_json(hello))
        news = self._show_session(library)
        viewer.show(news=encode_json(_to(news, has_control=has_control)), frame=self.host.frame())
        self._pictured = -1
        return viewer

    def disconnect(self, viewer: Client) -> None:
        """Remove a page; if it was in control, pause and disarm real robots."""
        viewer.close()
        if self.viewers.disconnect(viewer):
            ran = not self.host.paused and not self.host.robots.list_statuses()
            self._left = (viewer.key, self._wall()) if ran else None
            self.host.robots.disarm(LEFT_ROBOTS)
            self.host.pause(True, LEFT)
        self.show()

    def _resume_after(self, viewer: Client) -> None:
        """Let the run go on if it was stopped because this page left a moment ago; real robots wait for a person."""
        left, self._left = self._left, None
        if left is not None and left[0] == viewer.key and self._wall() - left[1] <= RETURN_S:
            self.host.pause(False, RETURNED)

    def handle_text(self, viewer: Client, text: str | bytes) -> None:
        """Execute the message of a page and queue the answer; that of a slow action follows at its end."""
        began_s = self._wall()
        number: int | None = None
        try:
            if not viewer.allow_message() and not _stops(text):
                number = m.find_message_number(text)
                raise SessionError(f"too many messages: at most {PER_SECOND} per second are accepted")
            if isinstance(text, bytes):
                raise m.InvalidMessage(problem="it is binary; send JSON text")
            try:
                message = m.parse_message(text)
            except m.InvalidMessage:
                number = m.find_message_number(text)
                raise
            number = message.id
            reply = self._do(viewer, message)
            if isinstance(reply, SlowAction):
                self._slow.begin(reply, viewer, number)
                self.show()
                return
            timed = isinstance(message, m.PressState | m.Confirm)
            ms = round((self._wall() - began_s) * 1e3, 3) if timed else UNSET
            answer = AnswerData(re=number, ok=True, ms=ms)
        except Exception as error:
            answer, reply = AnswerData(re=number, error=describe_error(error)), None
        viewer.send_reply(encode_json(answer, reply or {}))
        self.show()

    def answer_slow_actions(self) -> None:
        """Finish the slow actions whose work is done, and queue the answers."""
        for each in self._slow.take_done():
            try:
                self.host.status = each.finish()
                answer = AnswerData(re=each.number, ok=True)
            except Exception as error:
                answer = AnswerData(re=each.number, error=describe_error(error))
            each.viewer.send_reply(encode_json(answer))

    def _do(self, viewer: Client, message: Message) -> Data | SlowAction | None:
        """Execute a message and return the fields of the answer, or what is left to do in another thread.

        Raises UnderstudyError if it cannot be executed.
        """
        if isinstance(message, m.TakeControl):
            self.viewers.take_control(viewer)
            self._left = None
            return None
        if isinstance(message, m.ReleaseControl):
            self.viewers.hand_over_control(viewer)
            self.host.robots.disarm(LEFT_ROBOTS)
            self.host.pause(True, LEFT)
            return None
        if not message.by_anyone:
            self.viewers.refuse_others(viewer)
        result = handler_table.HANDLERS[type(message)](self.host, message)
        if isinstance(result, StatusMessage):
            self.host.status = result
            return None
        if isinstance(result, SlowAction):
            self.host.status = result.status
        return result

    # Time

    async def run(self) -> None:
        """Run the studio until cancelled, then close the session so that its journal is complete."""
        try:
            await repeat_each_frame(self.run_due_ticks, clock=self._wall, wait=self._wait)
        finally:
            self.host.close()

    def run_due_ticks(self) -> None:
        """Run the ticks that are due and send the changes to the pages."""
        self.answer_slow_actions()
        if self._watch is not None:
            drive_trained_robots(self.host)
            self._show_team(self._watch)
        self.host.run_due_ticks()
        if len(self.viewers):
            self.show(session=self._wall() >= self._due_s)

    def _show_team(self, watch: TeamWatch) -> None:
        """Send every page what the agents of the team do, if it changed."""
        if self._wall() < self._team_due_s:
            return
        self._team_due_s = self._wall() + TEAM_S
        team = describe_team(watch)
        if team != self._team:
            self._team = team
            for viewer in self.viewers:
                viewer.show(team=encode_json(TeamNewsData(team=team)))

    def show(self, *, session: bool = True) -> None:
        """Send every page the changes; on a new error, pause and show its message."""
        try:
            self._show(session=session)
        except Exception as error:
            problem = describe_error(error)
            if self.host.status.text != problem:
                self.host.halt(problem)

    def _show(self, *, session: bool) -> None:
        _, library = self._see_rebuilt()
        if session:
            self._show_session(library)
        if self.host.frame_version != self._moved:
            self._moved = self.host.frame_version
            frame = self.host.frame()
            if frame != self._frame:
                self._frame = frame
                for viewer in self.viewers:
                    viewer.show(frame=frame)
        self._show_picture()

    def _show_picture(self) -> None:
        """Send every page the picture of a body that draws itself, if it may have changed."""
        if self.host.frame_version == self._pictured or self._wall() < self._picture_due_s:
            return
        self._pictured, self._picture_due_s = self.host.frame_version, self._wall() + PICTURE_S
        picture = self.host.picture()
        if picture is not None:
            for viewer in self.viewers:
                viewer.show(picture=picture)

    def _see_rebuilt(self) -> tuple[SceneData, LibraryData]:
        """Return the present scene and library; send pages the scene if it changed."""
        if self._seen is None or self.host.scene_version != self._rebuilt:
            self._rebuilt = self.host.scene_version
            before, self._seen = self._seen, (self.host.scene(), self.host.library())
            self._places = self._list_places()
            scene, _ = self._seen
            if before is None or scene != before[0]:
                for viewer in self.viewers:
                    viewer.show(scene=encode_json(SceneNewsData(scene=scene)))
        return self._seen

    def _list_places(self) -> PlacesData:
        """Return the worlds and libraries that can be chosen; in reality there is one world."""
        host = self.host
        return host.places.data(host.scenario, host.folder, saves=isinstance(host.world, World))

    def _show_session(self, library: LibraryData) -> SessionNewsData:
        """Send the session's data to every page if it changed, and return it."""
        self._due_s = self._wall() + SESSION_S
        host, director = self.host, self.viewers.director
        if host.status is not self._said:
            self._said, self._said_number = host.status, self._said_number + 1
        news = SessionNewsData.of(
            host,
            library=library,
            session=host.session_data(),
            message=host.status,
            message_number=self._said_number,
            viewers=len(self.viewers),
            speed="fastest" if host.speed == FASTEST else host.speed,
            robots=host.robots.list_statuses(),
            places=self._places,
            failures=host.failures.data(host.scenario, host.trainer),
            properties=host.properties.data(host.trainer) if isinstance(host.world, World) else None,
            is_controlled=director is not None,
            can_take_control=self.viewers.can_be_taken,
            has_control=False,
        )
        if news != self._shown or director is not self._directed:
            self._shown, self._directed = news, director
            watching = encode_json(news)
            for viewer in self.viewers:
                viewer.show(news=encode_json(_to(news, has_control=True)) if viewer is director else watching)
        return news


def _to(news: SessionNewsData, *, has_control: bool) -> SessionNewsData:
    """Return a copy of the session news for a page that is in control, or is not."""
    return msgspec.structs.replace(news, has_control=has_control)


def _stops(text: str | bytes) -> bool:
    """Return whether a message is an emergency stop, which is accepted above the message rate, too."""
    try:
        return isinstance(text, str) and isinstance(m.parse_message(text), m.EmergencyStop)
    except m.InvalidMessage:
        return False
