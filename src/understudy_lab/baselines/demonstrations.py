"""Demonstrations: complete ones with basic behaviors, labels for a policy that drives, and stages of libraries.

Their ticks are recorded by a body that a session drives like any other. With a policy aboard (DAgger, Ross et al.
2011) the robot does what the policy decides, and presses are only labels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.library import Library
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands, list_reading_keys
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.sim.walker import Walker
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import Seen, SimulatedPerson
from understudy_lab.teachers.teacher import FIRST_SEED, LOOK_S, ScriptedTeacher, TeachingCost

if TYPE_CHECKING:
    from understudy_lab.baselines.tasks import BaselineTask

Robots: TypeAlias = World | Walker

Ints = NDArray[np.int64]
Raw = NDArray[np.float64]
"""Sensor values [N, K], NaN where absent."""

RESTING = -1
"""The index that stands for no behavior, with every channel at rest."""


class OnboardPolicy(Protocol):
    """A policy that drives the robot instead of the person."""

    def begin(self) -> None:
        """Clear the memory, because the robot was put into another world."""
        ...

    def decide(self, raw: Raw) -> Ints:
        """Return the index of the behavior to run, or RESTING, for each row of sensor values."""
        ...


@dataclass(frozen=True)
class RecordedTicks:
    """T recorded ticks, in order."""

    raw: Raw  # [T, K]
    wanted: Ints  # [T] the behavior the demonstrator wanted, by its index, or RESTING
    before: Ints  # [T] what the robot did at the tick before
    decisions: Ints  # [T] how many presses had been made
    episode: Ints  # [T] in which world, counted
    seconds: Column  # [T] what had been spent of the demonstrator's time, s

    def __len__(self) -> int:
        return len(self.wanted)

    def upto(self, decisions: int) -> Self:
        """Return the ticks recorded with at most `decisions` presses."""
        count = int(np.searchsorted(self.decisions, decisions, side="right"))
        return self[:count]

    def __getitem__(self, part: slice) -> Self:
        return type(self)(*(getattr(self, name)[part] for name in self.__dataclass_fields__))

    def advanced(self, ticks: int) -> Ints:
        """Return the behavior wanted `ticks` ticks later in the same world, because people press late."""
        later = np.minimum(np.arange(len(self)) + ticks, len(self) - 1)
        return np.where(self.episode[later] == self.episode, self.wanted[later], self.wanted)


class RecordingWorld(BodyWrapper[Robots]):
    """A world of one robot whose ticks are recorded from the first press on.

    `make` makes a world from a seed; `basics` are the commands of the basic behaviors; `count` returns the number of
    presses so far, `spent` the seconds they took.
    """

    def __init__(
        self,
        make: Callable[[Sequence[int]], Robots],
        seeds: Sequence[int],
        basics: Sequence[Mapping[str, float]],
        *,
        count: Callable[[], int],
        spent: Callable[[], float],
    ) -> None:
        super().__init__(make(seeds))
        self._make, self._count, self._spent = make, count, spent
        self._basics = {_spelled(commands): index for index, commands in enumerate(basics)}
        self._commands = [dict(commands) for commands in basics]
        self._keys = list_reading_keys(self)
        self._rows: list[tuple[list[float], int, int, int, int, float]] = []
        self._episode = 0
        self.aboard: OnboardPolicy | None = None
        self.on = True
        self._begin()

    def reset(self, seeds: Sequence[int]) -> None:
        """Start another world and another episode."""
        self._stand_on(self._make(seeds))
        self._episode += 1
        self._begin()

    def _begin(self) -> None:
        self._pressed, self._did = self._count(), RESTING
        if self.aboard is not None:
            self.aboard.begin()

    def act(self, commands: Commands) -> None:
        """Record the tick, and execute the pressed command or that of the policy aboard."""
        percept = self.sense(self._keys)
        raw = [float(percept[key][0]) for key in self._keys]
        wanted = self._basics.get(
            _spelled({name: float(column[0]) for name, column in commands.items()}), RESTING
        )
        if self.on and self._count() > self._pressed:
            spent = self._spent()
            self._rows.append((raw, wanted, self._did, self._count(), self._episode, spent))
        if self.aboard is None:
            self._did = wanted
            super().act(commands)
            return
        self._did = int(self.aboard.decide(np.array([raw]))[0])
        doing = self._commands[self._did] if self._did != RESTING else {}
        super().act({name: np.array([value]) for name, value in doing.items()})

    def ticks(self) -> RecordedTicks:
        """Return the recorded ticks."""
        raw, wanted, before, decisions, episode, seconds = zip(*self._rows, strict=True)
        return RecordedTicks(
            np.array(raw),
            np.array(wanted, np.int64),
            np.array(before, np.int64),
            np.array(decisions, np.int64),
            np.array(episode, np.int64),
            np.array(seconds, np.float64),
        )


def _spelled(commands: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    return tuple(sorted((name, value) for name, value in commands.items() if value))


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
