"""The studio at work: it beats the stage by wall clock, shows it to every page, and answers what they say."""

from __future__ import annotations

import asyncio
from importlib.metadata import PackageNotFoundError, version
from time import monotonic, perf_counter

import msgspec

from understudy.errors import SessionError
from understudy.ui.controller.clock import FASTEST, Wall
from understudy.ui.web.actions.dispatch import obey
from understudy.ui.web.clients import PER_SECOND, Viewer, Viewers
from understudy.ui.web.messages import review as r
from understudy.ui.web.messages import session as m
from understudy.ui.web.messages.coach import Advise
from understudy.ui.web.session_host import Stage, explained
from understudy.ui.web.views.scene import Plain

FRAME_S = 1 / 60
REST_S = 0.002
"""What a beat leaves at least for what pages say, however long it took."""
DESK_S = 1 / 20
"""How often the desk is shown at most, but for what was pressed."""
LEFT = "Nobody directs, so the robot was paused"
LEFT_ROBOTS = "nobody directs in the studio"
LOOKING = (r.Why, r.Test, r.Simplify, r.Versions, r.Changes, Advise, m.Stop)
"""What pages may say that only look on; anybody may stop a robot."""
_encode = msgspec.json.Encoder().encode


class Studio:
    """One stage and the pages that look at it. `wall` is the pages' time, for how fast and when they speak."""

    def __init__(self, stage: Stage, *, wall: Wall = monotonic) -> None:
        self.stage, self.viewers, self._wall = stage, Viewers(wall), wall
        self._frame = b""
        self._moved = self._rebuilt = -1
        self._scene: Plain = {}
        self._library: Plain = {}
        self._shown: Plain = {}
        self._directed: Viewer | None = None
        self._due_s = 0.0

    # Pages

    def arrive(self, key: str | None) -> Viewer:
        """A page connects, and is shown everything."""
        former = self.viewers.director
        viewer = self.viewers.arrive(key)
        if former is not None and viewer is self.viewers.director:
            self.stage.robots.leave(LEFT_ROBOTS)  # it comes again since its connection was lost
        self._see_rebuilt()
        hello = {
            "is": "hello",
            "version": _version(),
            "key": viewer.key,
            "directs": viewer is self.viewers.director,
            "scene": self._scene,
        }
        viewer.tell(_encode(hello))
        self._show_desk()
        viewer.show(desk=self._desk_for(viewer), frame=self.stage.frame())
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """A page is gone; without a director the robot stands still."""
        viewer.close()
        if self.viewers.leave(viewer):
            self.stage.robots.leave(LEFT_ROBOTS)
            self.stage.pause(True, LEFT)
        self.show()

    def hear(self, viewer: Viewer, text: str | bytes) -> None:
        """A page said something: it is done, and answered."""
        began = perf_counter()
        number: int | None = None
        try:
            if not viewer.may_speak() and not _stops(text):
                number = m.number_of(text)
                raise SessionError(f"too many messages: at most {PER_SECOND} a second are heard")
            if isinstance(text, bytes):
                raise m.UnusableMessage(problem="it is binary; send JSON text")
            try:
                message = m.read(text)
            except m.UnusableMessage:
                number = m.number_of(text)
                raise
            number = message.id
            answer = {"re": number, "ok": True, **self._do(viewer, message)}
            if isinstance(message, m.Press | m.Confirm):
                answer["ms"] = round((perf_counter() - began) * 1e3, 3)
        except Exception as error:
            answer = {"re": number, "error": explained(error)}
        viewer.tell(_encode(answer))
        self.show()

    def _do(self, viewer: Viewer, message: m.AnyMessage) -> Plain:
        if isinstance(message, m.Take):
            self.viewers.take(viewer)
            return {}
        if isinstance(message, m.HandOver):
            self.viewers.hand_over(viewer)
            self.stage.robots.leave(LEFT_ROBOTS)
            self.stage.pause(True, LEFT)
            return {}
        if not isinstance(message, LOOKING):
            self.viewers.refuse_others(viewer)
        return obey(self.stage, message)

    # Time

    async def run(self) -> None:
        """Go on until cancelled; the journal is complete at the end."""
        try:
            while True:
                began = perf_counter()
                self.beat()
                await asyncio.sleep(max(REST_S, FRAME_S - (perf_counter() - began)))
        finally:
            self.stage.close()

    def beat(self) -> None:
        """Take the ticks that are due, and show what came of them."""
        self.stage.beat()
        if len(self.viewers):
            self.show(desk=self._wall() >= self._due_s)

    def show(self, *, desk: bool = True) -> None:
        """Show every page what is new; what goes wrong is said, once, and time stands still."""
        try:
            self._show(desk=desk)
        except Exception as error:
            problem = explained(error)
            if self.stage.said.text != problem:
                self.stage.halt(problem)

    def _show(self, *, desk: bool) -> None:
        self._see_rebuilt()
        if desk:
            self._show_desk()
        if self.stage.moved != self._moved:
            self._moved = self.stage.moved
            frame = self.stage.frame()
            if frame != self._frame:
                self._frame = frame
                for viewer in self.viewers:
                    viewer.show(frame=frame)

    def _see_rebuilt(self) -> None:
        if self.stage.rebuilt == self._rebuilt:
            return
        self._rebuilt = self.stage.rebuilt
        scene, self._library = self.stage.scene(), self.stage.library()
        if scene != self._scene:
            self._scene = scene
            for viewer in self.viewers:
                viewer.show(scene=_encode({"is": "scene", "scene": scene}))

    def _show_desk(self) -> None:
        self._due_s = self._wall() + DESK_S
        stage = self.stage
        shown = {
            "is": "desk",
            "library": self._library,
            "desk": stage.picture(),
            "said": {"text": stage.said.text, "tone": stage.said.tone},
            "viewers": len(self.viewers),
            "paused": stage.paused,
            "speed": "fastest" if stage.speed == FASTEST else stage.speed,
            "seed": stage.seed,
            "sort": stage.sort,
            "robots": stage.robots.plain(),
            "run": stage.run,
            "directed": self.viewers.director is not None,
        }
        director = self.viewers.director
        if shown == self._shown and director is self._directed:
            return
        self._shown, self._directed = shown, director
        watching = _encode({**shown, "directs": False})
        for viewer in self.viewers:
            viewer.show(desk=self._desk_for(viewer) if viewer is director else watching)

    def _desk_for(self, viewer: Viewer) -> bytes:
        return _encode({**self._shown, "directs": viewer is self.viewers.director})


def _stops(text: str | bytes) -> bool:
    """Whether a message stops robots, which is heard however many there are."""
    try:
        return isinstance(text, str) and isinstance(m.read(text), m.Stop)
    except m.UnusableMessage:
        return False


def _version() -> str:
    try:
        return version("understudy")
    except PackageNotFoundError:
        return "unknown"
