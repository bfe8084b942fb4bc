"""The trainer as a terminal application, from opening a session to ending it."""

from __future__ import annotations

import signal
from asyncio import get_running_loop
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import ClassVar

from textual import events
from textual.app import App

from understudy.addons.checks.falsification.failing_world import FailingWorld, list_failing_worlds
from understudy.addons.robots.twin import Ground
from understudy.clock import REAL_TIME
from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Kit
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.ui.controller import interrupted_sessions
from understudy.ui.controller.failing_worlds import (
    FOLDER,
    LibrarySource,
    make_draft,
    prepare_failure,
    rerun_all,
)
from understudy.ui.controller.interrupted_sessions import InterruptedSession
from understudy.ui.controller.open_session import OpenSession, begin_session, resume_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.training_plan import (
    LessonChoices,
    SessionStart,
    TrainingPlan,
    make_session_start,
)
from understudy.ui.terminal.dialogs import QuestionDialog
from understudy.ui.terminal.failures_screen import FailuresScreen
from understudy.ui.terminal.lesson_form import LessonForm
from understudy.ui.terminal.main_screen import TeachingScreen

SIGNALED = 128
"""What exit codes of programs begin at that a signal ended."""


@dataclass(frozen=True, slots=True)
class SessionEnd:
    """The end of a session: the number of examples from presses, and whether the library has them."""

    examples: int
    saved: bool
    journal: Path


def _find_kit(plan: TrainingPlan, scenario: Scenario) -> Kit:
    """Return the kit of a scenario: that of the plan for its own world."""
    return plan.library.kit if scenario.name == plan.world.name else make_scenario_kit(scenario)


class TrainerApp(App[SessionEnd | UnderstudyError]):
    """Teaches the automaton of a plan, and returns how the session ended; None if none was begun."""

    ENABLE_COMMAND_PALETTE = False
    ESCAPE_TO_MINIMIZE: ClassVar[bool] = False
    CSS = """
    Screen { background: ansi_default; color: ansi_default; }
    """

    def __init__(
        self,
        plan: TrainingPlan,
        *,
        unfinished: InterruptedSession | None = None,
        wall: Callable[[], float] = REAL_TIME,
        ground: Ground | None = None,
        failures: Path = FOLDER,
    ) -> None:
        super().__init__(ansi_color=True)
        self.ground, self.failures = ground, failures
        self._library = LibrarySource(plan.folder, partial(_find_kit, plan))
        self.plan, self.unfinished, self.wall = plan, unfinished, wall
        self.open_session: OpenSession | None = None
        self.theme = "ansi-dark"  # the terminal's own colors, so that it looks right on light and dark ones

    def on_mount(self) -> None:
        """Offer an interrupted session, or begin."""
        for name in ("SIGTERM", "SIGHUP"):
            with suppress(AttributeError, NotImplementedError, RuntimeError, ValueError):
                get_running_loop().add_signal_handler(getattr(signal, name), self._cut_off, name)
        if self.unfinished is None:
            self._begin()
            return
        found = self.unfinished
        question = (
            f"A session of {self.plan.name} was interrupted. It began on {found.began:%d %B at %H:%M} and has "
            f"{found.examples} example{'s' * (found.examples != 1)}; the last step was “{found.steps}”."
        )
        ways = {"enter": "resume it", "n": "discard it, and start from the library", "escape": "quit"}
        self.push_screen(QuestionDialog(question, ways), self._answered)

    def _cut_off(self, name: str) -> None:
        """End on a signal of the system: the journal is complete, and the session is offered next time."""
        if self.open_session is not None:
            self.open_session.close()
        self.exit(None, return_code=SIGNALED + getattr(signal, name))

    def _answered(self, way: str | None) -> None:
        if self.unfinished is None or way == "escape":
            self.exit(None)
        elif way == "enter":
            self._teach(partial(resume_session, self.plan, self.unfinished.path, self.wall, body=self.ground))
        else:
            interrupted_sessions.finish_journal(self.unfinished.path, self.plan.folder, self.plan.name)
            self._begin()

    def _begin(self) -> None:
        start = make_session_start(self.plan)
        if start is None:
            self.push_screen(LessonForm.for_new_lesson(self.plan), self._chosen)
        else:
            self._start(start)

    def _chosen(self, choices: LessonChoices | None) -> None:
        if choices is None:
            self.exit(None)
            return
        self.plan = replace(self.plan, choices=choices)
        start = make_session_start(self.plan)
        if start is not None:
            self._start(start)

    def _start(self, start: SessionStart) -> None:
        self._teach(partial(begin_session, self.plan, start, self.wall, body=self.ground))

    def _teach(self, opening: Callable[[], OpenSession]) -> None:
        try:
            self.open_session = opening()
        except UnderstudyError as error:
            self.exit(error)
            return
        screen = TeachingScreen(self.open_session.trainer, show_failures=self._show_failures, wall=self.wall)
        self.push_screen(screen, self._ended)

    def _show_failures(self) -> None:
        """Show the failing worlds; SessionError if the robots are real or the body is the user's own."""
        if self.open_session is None:
            return
        trainer = self.open_session.trainer
        if not isinstance(trainer.body, World):
            raise SessionError("failing worlds can be opened in simulated worlds only")
        worlds, problems = list_failing_worlds(self.failures)
        rerun = partial(rerun_all, worlds, self._library, make_draft(trainer))
        self.push_screen(FailuresScreen(worlds, problems, rerun), partial(self._open_failure, worlds))

    def _open_failure(self, worlds: Sequence[FailingWorld], name: str | None) -> None:
        """Replace the session by one in a failing world, which goes on with what is in training."""
        failing = next((each for each in worlds if each.folder.name == name), None)
        left = self.open_session
        if failing is None or left is None or not isinstance(self.screen, TeachingScreen):
            return
        try:
            opening = prepare_failure(failing, self._library, make_draft(left.trainer))
            opened = opening.begin(self.wall)
        except UnderstudyError as error:
            left.trainer.status = StatusMessage(str(error), "error")
            self.screen.draw()
            return
        left.close()
        interrupted_sessions.finish_journal(left.journal, self.plan.folder, self.plan.name)
        self.plan, self.open_session = opening.plan, opened
        self.screen.replace_trainer(opened.trainer)

    def _ended(self, _: str | None) -> None:
        """End because the person left: the journal is complete, and is not needed to continue."""
        if self.open_session is None:
            return
        self.open_session.close()
        trainer = self.open_session.trainer
        kept = interrupted_sessions.finish_journal(
            self.open_session.journal, self.plan.folder, self.plan.name
        )
        self.exit(
            SessionEnd(
                trainer.session_view.examples,
                not trainer.has_unsaved_changes and bool(trainer.session.examples),
                kept,
            )
        )

    async def on_event(self, event: events.Event) -> None:
        """Escape stops real robots whatever lies on top of their screen, and does what else it does there."""
        if isinstance(event, events.Key) and event.key == "escape" and not event.is_forwarded:
            for screen in self.screen_stack:
                if isinstance(screen, TeachingScreen):
                    screen.action_stop()
        await super().on_event(event)

    async def action_quit(self) -> None:
        """Ctrl-Q: the same as q, so that nothing is lost unasked."""
        if isinstance(self.screen, TeachingScreen):
            self.screen.action_leave()
        elif self.open_session is None:
            self.exit(None)
