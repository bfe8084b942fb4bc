"""Demonstrations: complete ones with basic behaviors, labels for a policy that drives, and stages of libraries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.model.library import Library
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.baselines.recording_body import OnboardPolicy, RecordedTicks, RecordingWorld
from understudy_lab.baselines.tasks import BaselineTask
from understudy_lab.teachers.person import Seen, SimulatedPerson
from understudy_lab.teachers.teacher import FIRST_SEED, LOOK_S, ScriptedTeacher, TeachingCost

SAYING_S = 0.5
"""The time in s for which resting is demonstrated at the end."""
LEFT_S = 25.0
"""The time in s without a new label after which a robot driven by a policy is left."""


class Demonstrator:
    """A person who demonstrates a task with basic behaviors, world after world; the same seed gives the same ticks."""

    def __init__(self, exercise: BaselineTask, seed: int) -> None:
        self._exercise, self._topic = exercise, exercise.flat
        self._draws = np.random.default_rng([seed, 2])
        self._person = SimulatedPerson(self._draws)
        self._worlds = 0
        self._recording = RecordingWorld(
            exercise.world,
            [self._seed()],
            exercise.commands,
            count=lambda: self._person.presses,
            spent=lambda: self._person.seconds,
        )
        library = exercise.library()
        self._session = Session(
            self._recording, library, self._topic.choose(library), targets=exercise.targets
        )

    @property
    def presses(self) -> int:
        """The number of presses so far."""
        return self._person.presses

    @property
    def ticks(self) -> RecordedTicks:
        """The ticks recorded so far."""
        return self._recording.ticks()

    def show(self, *, aboard: OnboardPolicy | None = None, most: int = 10**9) -> None:
        """Demonstrate in one world, until the task is done or `most` presses were made in all.

        With a policy `aboard`, presses are only labels, and the world ends when no other label is needed for a while.
        """
        topic, push = self._topic, self._exercise.pushes[self._worlds % len(self._exercise.pushes)]
        self._worlds += 1
        self._recording.aboard = aboard
        self._session.reset(self._seed())
        self._person.seconds += LOOK_S
        if push is not None and aboard is None:
            self._watch(lambda screen: screen.state == push.during or topic.finished(screen))
            self._recording.on = False
            self._person.drive(self._session, push.behavior, push.seconds)
            self._recording.on = True
        pressed = self._person.presses, self._person.seconds

        def enough(screen: SessionView) -> bool:
            nonlocal pressed
            presses, seconds = self._person.presses, self._person.seconds
            if presses > pressed[0]:
                pressed = presses, seconds
            return (
                presses >= most
                or topic.finished(screen)
                or (aboard is not None and seconds - pressed[1] > LEFT_S)
            )

        self._watch(enough)
        if self._exercise.rests and self._session.view().flag is not None:
            self._session.run_for(SAYING_S)
            self._person.seconds += SAYING_S

    def _watch(self, until: Seen) -> None:
        self._person.show(self._session, self._topic.show, until=until, limit_s=self._topic.limit_s)

    def _seed(self) -> int:
        return FIRST_SEED + int(self._draws.integers(2**40))


def record_demonstrations(exercise: BaselineTask, seed: int, decisions: int) -> RecordedTicks:
    """Return whole demonstrations with more than `decisions` presses."""
    demonstrator = Demonstrator(exercise, seed)
    while demonstrator.presses <= decisions:
        demonstrator.show()
    return demonstrator.ticks


@dataclass(frozen=True)
class LibraryAt:
    """A library at one time of its teaching."""

    decisions: int
    seconds: float
    library: Library


def record_libraries(exercise: BaselineTask, seed: int) -> list[LibraryAt]:
    """Return the library after each step of its teaching."""
    stood: list[LibraryAt] = []

    def see(name: str, what: str, account: TeachingCost) -> None:
        accounts = teacher.accounts.values()
        presses, seconds = sum(each.presses for each in accounts), sum(each.seconds for each in accounts)
        stood.append(LibraryAt(presses, seconds, teacher.library))

    teacher = ScriptedTeacher(exercise.library(), exercise.make, seed, options=exercise.options, progress=see)
    teacher.teach(*exercise.topics)
    return stood
