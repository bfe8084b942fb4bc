"""What the tests of the trainer share: a clock that moves when told, a plan, and a person's eye for GoTo."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from math import pi, tau
from pathlib import Path

import numpy as np
import pytest
from textual.pilot import Pilot

from understudy.addons.checks.falsification.new_worlds import Mistake, NewWorlds, NewWorldsResult
from understudy.addons.robots.twin import Ground
from understudy.errors import UnderstudyError
from understudy.learning.fit import learn
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.library_folder import open_library
from understudy.training.trainee import Mode, SessionView
from understudy.ui.controller import interrupted_sessions
from understudy.ui.controller.keep_going import count_presses
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan
from understudy.ui.terminal.app import SessionEnd, TrainerApp
from understudy.ui.terminal.main_screen import TeachingScreen

GOTO = LessonChoices(
    live=False,
    states=["forward", "rotate_left", "rotate_right"],
    features=["distance_to(A)", "angle_to(A)"],
    flags=["done"],
    parameters=["A"],
    targets={"A": "station"},
)


class Wall:
    """A clock that moves when told."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def make_plan(folder: Path, name: str = "goto", choices: LessonChoices = GOTO, seed: int = 0) -> TrainingPlan:
    library = open_library(folder, FORAGE_KIT, learn).library if folder.exists() else Library(FORAGE_KIT)
    return TrainingPlan(name, folder, find_scenario("forage"), library, choices, seed)


class Hand:
    """A trainer that runs, and somebody who does nothing but press keys and wait."""

    def __init__(self, app: TrainerApp, pilot: Pilot[SessionEnd | UnderstudyError], wall: Wall) -> None:
        self.app, self.pilot, self.wall = app, pilot, wall

    @property
    def trainer(self) -> Trainer:
        assert self.app.open_session is not None
        return self.app.open_session.trainer

    @property
    def teach_screen(self) -> TeachingScreen:
        assert isinstance(self.app.screen, TeachingScreen), self.app.screen
        return self.app.screen

    @property
    def status_text(self) -> str:
        return self.trainer.status.text

    async def press(self, *keys: str) -> None:
        await self.pilot.press(*keys)

    async def wait(self, seconds: float = 0.1) -> None:
        """So much time passes."""
        for _ in range(round(seconds / 0.1)):
            self.wall.now += 0.1
            self.teach_screen.run_due_ticks()

    def read_part(self, part: str) -> str:
        """The text of a part of the screen."""
        return self.teach_screen._drawn[part].plain

    async def show(self, *, worlds: int, limit_s: float = 60.0) -> None:
        """Show GoTo from here, and in the next worlds."""
        for world in range(worlds):
            if world:
                await self.press("n")
            await self.guide(limit_s)

    async def guide(self, limit_s: float = 60.0) -> int:
        """Press what is right wherever it does wrong, until it is done; how many presses that took."""
        presses = 0
        for _ in range(round(limit_s / 0.1)):
            view = self.trainer.session_view
            wanted = right(view) if view.mode is Mode.TRAINING else tolerable(view)
            if wanted is None:
                return presses
            if wanted != view.state and view.waiting is None:
                await self.press(self.trainer.keys.plain[wanted])
                presses += 1
            await self.wait()
        raise AssertionError(f"not done after {limit_s} s: {self.trainer.session_view}")


def right(view: SessionView) -> str | None:
    """What a robot on its way to A should do; None where it has said that it is there, and is."""
    distance = view.features["distance_to(A)"]
    bearing = (view.features["angle_to(A)"] + pi) % tau - pi
    if distance < 0.4:
        return None if view.flag else "done"
    if view.flag:
        return "forward"
    if view.state.startswith("rotate"):
        turned = bearing if view.state == "rotate_left" else -bearing
        return "forward" if turned < 0.12 else view.state
    if abs(bearing) > 0.6:
        return "rotate_left" if bearing > 0 else "rotate_right"
    return "forward"


def tolerable(view: SessionView) -> str | None:
    """What it should do in testing, where only what is plainly wrong is corrected."""
    distance = view.features["distance_to(A)"]
    bearing = (view.features["angle_to(A)"] + pi) % tau - pi
    if view.flag:
        return None if distance < 0.5 else "forward"
    if view.state == "forward" and (distance < 0.3 or abs(bearing) > 1.2):
        return right(view)
    if view.state == "rotate_left" and -2.0 < bearing < -0.6:
        return "forward"
    if view.state == "rotate_right" and 0.6 < bearing < 2.0:
        return "forward"
    return view.state


@asynccontextmanager
async def make_trainer(
    made: TrainingPlan,
    *,
    size: tuple[int, int] = (80, 24),
    offer: bool = False,
    ground: Ground | None = None,
) -> AsyncIterator[Hand]:
    """The trainer on a screen nobody sees."""
    wall = Wall()
    left = (
        interrupted_sessions.find_interrupted_session(made.folder, made.name, made.world.name, made.library)
        if offer
        else None
    )
    app = TrainerApp(made, unfinished=left, wall=wall, ground=ground)
    try:
        async with app.run_test(size=size) as pilot:
            await pilot.pause()
            yield Hand(app, pilot, wall)
    finally:
        if app.open_session is not None:
            app.open_session.close()


def fail_by_presses(monkeypatch: pytest.MonkeyPatch, failed: Mapping[int, float]) -> None:
    """Let goto fail in a share of new worlds, by the number of presses of its lesson."""

    def run(
        worlds: NewWorlds, library: Library, name: str, binding: Mapping[str, str], **_: object
    ) -> NewWorldsResult:
        lesson = library.taught[name].lesson
        assert lesson is not None
        works = np.arange(len(worlds.seeds)) >= round(failed[count_presses(lesson)] * len(worlds.seeds))
        wrong = [seed for seed, each in zip(worlds.seeds, works, strict=True) if not each]
        mistakes = tuple(Mistake(seed, binding, 2.0, "done too early") for seed in wrong)
        return NewWorldsResult(works, np.where(works, 1.0, np.nan), mistakes)

    monkeypatch.setattr(NewWorlds, "run", run)
