"""Run a session in real time while a view of it is on a screen; independent of notebooks and browsers.

A view that is on a screen reports it every `REPORT_S`. While no view is, the world stands still: nothing happens that
the person cannot see, and nothing is learned from silence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import msgspec
from msgspec import Meta, Struct

from understudy.addons.checks.falsification.lesson_score import ScoreChange
from understudy.addons.robots.twin import DigitalTwin
from understudy.coaching.questions import QueryPolicy
from understudy.errors import SessionError, SettingError
from understudy.training.session import Session
from understudy.ui.controller import coach
from understudy.ui.controller.clock import RealTimeClock, check_speed
from understudy.ui.controller.open_session import find_ground
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.controller.trainer import Trainer

REPORT_S = 2.0
"""How often a view that is on a screen reports it, s; the page's script has the same number."""
SILENT_S = 3 * REPORT_S
"""The time without a report after which a view counts as hidden, s."""


Action: TypeAlias = Literal[
    "press", "confirm", "toggle_mode", "pause", "step", "restart", "new_world", "undo", "redo", "ask", "save",
    "toggle_score", "show", "hide",
]  # fmt: skip


class WidgetRequest(Struct, frozen=True, forbid_unknown_fields=True):
    """A request of a view. `state` is the state that was pressed, `view` the view that is shown or hidden."""

    action: Action
    state: Annotated[str, Meta(max_length=150)] = ""
    view: Annotated[str, Meta(max_length=50)] = ""


def parse_request(content: object) -> WidgetRequest:
    """Parse a request; SessionError if it is not one, as from a page of another version."""
    try:
        return msgspec.convert(content, WidgetRequest)
    except msgspec.ValidationError as error:
        raise SessionError(
            f"the notebook's page sent a request that cannot be understood ({error}): restart the kernel and reload "
            "the page, so that both have the same version"
        ) from None


def toggle_questions(trainer: Trainer) -> None:
    """Let the robot pause and ask where it is unsure, or no longer."""
    asks = trainer.coach.asking.when is QueryPolicy.PAUSE
    coach.change_query_policy(trainer, QueryPolicy.NEVER if asks else QueryPolicy.PAUSE)


ACTIONS: Mapping[str, Callable[[Trainer], object]] = {
    "confirm": lambda trainer: coach.press_or_answer(trainer, None),
    "toggle_mode": Trainer.toggle_mode,
    "pause": Trainer.pause,
    "step": Trainer.step,
    "restart": Trainer.restart,
    "new_world": Trainer.new_world,
    "undo": Trainer.undo,
    "redo": Trainer.redo,
    "ask": toggle_questions,
    "save": Trainer.save,
    "toggle_score": Trainer.toggle_score,
}
"""What the trainer does on a request that has neither state nor view."""


class SessionDriver:
    """A session with its trainer, its clock, and the views that are on a screen.

    `version` grows whenever there may be something new to see.
    """

    def __init__(
        self, session: Session, *, speed: float, folder: Path | None, wall: Callable[[], float]
    ) -> None:
        ground = find_ground(session.body)
        if isinstance(ground, DigitalTwin):
            raise SessionError(
                "a notebook cannot stop real robots while a cell runs: teach them in the studio, with understudy "
                "robots studio FILE"
            )
        self.session, self.folder, self._wall = session, folder, wall
        self._tick_s = _check_tick(session)
        pace = RealTimeClock(wall, tick_s=self._tick_s)
        pace.speed = check_speed(speed, "show_session")
        taught = session.library.taught.get(session.automaton.name)
        self.trainer = Trainer(
            session,
            ground,
            pace,
            folder=folder or Path(),
            seed=ground.seeds[0],
            saved=None if taught is None or folder is None else taught.lesson,
        )
        self.trainer.status = StatusMessage(_welcome(self.trainer))
        self.trainer.suspend(True)
        self.version = 0
        self._views: dict[str, float] = {}
        self._score: tuple[ScoreChange | None, str, bool] = (None, "", False)
        self._seen = self._note()

    @property
    def is_shown(self) -> bool:
        """Whether a view is on a screen."""
        return bool(self._views)

    def receive(self, content: object) -> None:
        """Do what a view asks for; where that is impossible, the status says why, and nothing is changed."""
        try:
            self._notice_changes()
            self._handle(parse_request(content))
        except Exception as error:
            self.trainer.status = StatusMessage(describe_error(error), "error")
        self.version += 1
        self._seen = self._note()

    def _handle(self, request: WidgetRequest) -> None:
        if request.action == "press":
            coach.press_or_answer(self.trainer, request.state)
        elif request.action == "show":
            self._views[request.view] = self._wall()
            self._suspend_unseen()
        elif request.action == "hide":
            self._views.pop(request.view, None)
            self._suspend_unseen()
        elif request.action == "save" and self.folder is None:
            raise SessionError(
                "no folder to save in was given: use show_session(session, library_folder=...), or save_automaton"
            )
        else:
            ACTIONS[request.action](self.trainer)

    def beat(self) -> None:
        """Take the ticks that are due; on an error, pause, and let the status say why."""
        try:
            self._notice_changes()
            self._notice_score()
            self._suspend_unseen()
            for _ in self.trainer.ticks():
                self.version += 1
                self._check_clock()
        except Exception as error:
            self.version += 1
            self.session.paused = True
            self.trainer.suspend(self.trainer.suspended)
            self.trainer.status = StatusMessage(describe_error(error), "error")
        self._seen = self._note()

    def hide_all(self) -> None:
        """Note that no view is on a screen any more."""
        self._views.clear()
        self._suspend_unseen()

    def _suspend_unseen(self) -> None:
        now = self._wall()
        self._views = {view: heard for view, heard in self._views.items() if now - heard <= SILENT_S}
        if self.trainer.suspended is self.is_shown:
            self.trainer.suspend(not self.is_shown)
            self.version += 1

    def _notice_changes(self) -> None:
        """Show what a cell of the notebook has changed in the session since the last beat."""
        if self._note() != self._seen:
            self.version += 1
            self.trainer.seed = self.trainer.body.seeds[0]
            self.trainer.refresh_view()
            self.trainer.suspend(self.trainer.suspended)  # it may be paused now, or no longer

    def _notice_score(self) -> None:
        """Show a score that was taken since the last beat, in a thread of its own."""
        score, (change, *others) = self.trainer.score, self._score
        if score.change is not change or [score.problem, score.is_running] != others:
            self._score = score.change, score.problem, score.is_running
            self.version += 1

    def _note(self) -> tuple[object, ...]:
        """Return what differs after every change of the session."""
        session = self.session
        return (
            id(session.examples),
            id(session.automaton),
            id(session.trainee),
            session.trainee.press,
            session.mode,
            session.paused,
            session.body.time_s,
        )

    def _check_clock(self) -> None:
        """Raise SessionError if the body's clock did not go on with its last tick."""
        self._seen, before = self._note(), self._seen
        if (now := self.session.body.time_s) == before[-1] and not self.session.paused:
            raise SessionError(
                f"the body stands still at {now:g} s: its act must let time_s grow by tick_s, {self._tick_s:g} s"
            )


def _check_tick(session: Session) -> float:
    tick_s = session.body.tick_s
    if not tick_s > 0:
        raise SettingError(
            where=type(session.body).__name__,
            setting="tick_s",
            problem=f"is {tick_s!r:.60}",
            remedy="give the length of a tick in seconds, above 0",
        )
    return tick_s


def _welcome(trainer: Trainer) -> str:
    if trainer.session.examples:
        return f"Press a state where {trainer.name} is wrong, or Try to see what it learned"
    return f"Press a state to direct the robot: each press teaches {trainer.name}"
