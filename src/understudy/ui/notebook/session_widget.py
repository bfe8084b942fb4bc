"""The widget: a session's driver in the event loop of a notebook's kernel, and its data in the notebook's page."""

from __future__ import annotations

import asyncio
from importlib.resources import files
from weakref import WeakSet

import traitlets
from anywidget import AnyWidget

from understudy.training.session import Session
from understudy.ui.notebook import view_data
from understudy.ui.notebook.session_driver import SessionDriver

BEAT_S, REST_S = 0.01, 0.1
"""How often the driver looks for ticks that are due: while time runs, and while it stands, s."""
_STATIC = files("understudy.ui.notebook") / "static"
_open: WeakSet[SessionWidget] = WeakSet()


class SessionWidget(AnyWidget):
    """A session in a notebook, which runs while the widget is on a screen.

    Its ticks and requests run between the cells of the notebook, in the same thread, so that cells may use the session
    at any time.
    """

    _esm = (_STATIC / "session.js").read_text(encoding="utf-8")
    _css = (_STATIC / "session.css").read_text(encoding="utf-8")
    arena = traitlets.Dict().tag(sync=True)
    lesson = traitlets.Dict().tag(sync=True)
    panel = traitlets.Dict().tag(sync=True)
    moment = traitlets.Dict().tag(sync=True)
    objects: traitlets.List[view_data.PlainData] = traitlets.List().tag(sync=True)
    robots = traitlets.Bytes().tag(sync=True)
    trail = traitlets.Bytes().tag(sync=True)

    def __init__(self, driver: SessionDriver) -> None:
        super().__init__()
        self.driver = driver
        self._loop = asyncio.get_running_loop()
        self._lesson: object = None
        self._version = -1
        self.update()
        _open.add(self)
        self.on_msg(self._hand_over)
        self._task = self._loop.create_task(self._run())

    @property
    def session(self) -> Session:
        """The session that is shown."""
        return self.driver.session

    def _hand_over(self, _: object, content: object, __: object) -> None:
        """Let the kernel's main thread handle a request: with subshells, it arrives in another thread."""
        self._loop.call_soon_threadsafe(self.receive, content)

    def receive(self, content: object) -> None:
        """Handle a request of a view at once, and show the result."""
        self.driver.receive(content)
        self.update()

    async def _run(self) -> None:
        while True:
            stands = self.driver.trainer.paused or self.driver.trainer.suspended
            await asyncio.sleep(REST_S if stands else BEAT_S)
            self.driver.beat()
            self.update()

    def update(self) -> None:
        """Send the views what changed."""
        driver, trainer = self.driver, self.driver.trainer
        if driver.version == self._version:
            return
        self._version = driver.version
        with self.hold_sync():
            self.panel = view_data.describe_panel(trainer, can_save=driver.folder is not None)
            if (lesson := trainer.explainer.learn_lesson()[0]) is not self._lesson:
                self._lesson = lesson
                self.lesson = view_data.describe_lesson_data(trainer)
            view = trainer.view
            self.arena = view_data.describe_arena(trainer, view)  # a few microseconds where it is the same
            self.objects = view_data.describe_objects(view)
            self.robots = view_data.pack_robots(view)
            self.trail = view_data.pack_trail(trainer)
            self.moment = view_data.describe_moment(trainer, view)

    def close(self) -> None:
        """Stop the world and remove all views; the session can be used, and shown again."""
        _open.discard(self)
        self._task.cancel()
        self.driver.hide_all()
        super().close()


def find_widget(session: Session) -> SessionWidget | None:
    """Return the open widget that shows a session, or None: two would run its world twice as fast."""
    return next((widget for widget in _open if widget.session is session), None)
