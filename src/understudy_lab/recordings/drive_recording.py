"""Recordings of simulated drivers with a stick, lessons from them, and how well labels fit what the driver meant."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.drive_kit import list_drive_features, make_candidates
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.learning.fit import learn_automaton
from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import TreeOptions
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.records.record import Episode, Record
from understudy.runtime.body import Body
from understudy.training.lesson_design import parse_feature


@dataclass(frozen=True, slots=True)
class StickSettings:
    """Settings of a hand that moves a stick.

    Parameters
    ----------
    gain
        Share of the way to its aim that it moves in a tick.
    noise
        Standard deviation of its position, where full deflection is 1.
    dead_ticks
        Ticks from a decision to the first motion.
    overshoot
        By how much, as a share of the way, it goes too far when the aim changes, for `OVERSHOOT_TICKS`.
    slowest
        The smallest share of full speed at which the driver drives or turns; each episode has its own speed.
    """

    gain: float
    noise: float
    dead_ticks: int
    overshoot: float
    slowest: float


OVERSHOOT_TICKS = 2


def draw_stick_settings(seed: int) -> StickSettings:
    """Draw how one of the hands of the experiment moves a stick; the same seed gives the same hand."""
    random = np.random.default_rng([seed, 16])
    return StickSettings(
        gain=float(random.uniform(0.4, 1.0)),
        noise=float(random.uniform(0.01, 0.08)),
        dead_ticks=int(random.integers(0, 3)),
        overshoot=float(random.uniform(0.0, 0.2)),
        slowest=float(random.uniform(0.7, 1.0)),
    )


class Stick:
    """A stick with C axes that one driver holds in each of N worlds.

    Axes among `buttons` are buttons, which are pressed or not. To press one, drivers let the stick go, which springs to
    its center.
    """

    def __init__(
        self,
        hand: StickSettings,
        worlds: int,
        axes: int,
        random: np.random.Generator,
        *,
        buttons: Sequence[int] = (),
    ) -> None:
        self._hand, self._random, self._buttons = hand, random, list(buttons)
        self._speed = random.uniform(hand.slowest, 1.0, (worlds, 1))
        self._queue = deque([np.zeros((worlds, axes))] * hand.dead_ticks)
        self._aim, self._place = np.zeros((worlds, axes)), np.zeros((worlds, axes))
        self._jump, self._since = np.zeros((worlds, axes)), np.full((worlds, 1), OVERSHOOT_TICKS)

    def move(self, aims: Floats) -> Floats:
        """Move the stick toward aims [N, C], and return its position, between -1 and 1."""
        self._queue.append(aims * self._speed)
        aim = self._queue.popleft()
        changed = (aim != self._aim).any(axis=1, keepdims=True)
        self._jump = np.where(changed, aim - self._aim, self._jump)
        self._since = np.where(changed, 0, self._since + 1)
        self._aim = aim
        beyond = np.where(self._since < OVERSHOOT_TICKS, self._hand.overshoot * self._jump, 0.0)
        self._place = self._place + self._hand.gain * (aim + beyond - self._place)
        noise = self._hand.noise * self._random.standard_normal(aim.shape)
        commands: Floats = np.clip(self._place + noise, -1.0, 1.0)
        if self._buttons:
            pressed = (aim[:, self._buttons] > 0.0).astype(np.float64)
            free = pressed.any(axis=1)
            self._place[free] = commands[free] = 0.0
            commands[:, self._buttons] = pressed
        return commands


Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class DriverStep(NamedTuple):
    """What drivers do in a tick in N worlds.

    `meant` is the index of the behavior that a driver means, `aimed` that of the basic behavior that the hand aims at
    for it, and `over` is true where the recording ends after this tick.
    """

    meant: Ints
    aimed: Ints
    over: NDArray[np.bool_]


class DriverProgram(Protocol):
    """A program by which drivers decide, from readings alone, in N worlds."""

    @property
    def keys(self) -> Sequence[ReadingKey]:
        """The readings that the drivers see, which are recorded."""
        ...

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick."""
        ...


class MeantDrive(NamedTuple):
    """A recording, and the index of the behavior that the driver meant in each tick [T]."""

    recording: Record
    meant: Ints


def list_aims(kit: Kit, moves: Sequence[str], channels: Sequence[str]) -> Floats:
    """Return the commands [M, C] of basic behaviors, which the hand aims at."""
    return np.array([[kit.behaviors[name].command.get(each, 0.0) for each in channels] for name in moves])


def record_drives(
    body: Body,
    program: DriverProgram,
    hand: StickSettings,
    moves: Sequence[str],
    *,
    kit: Kit,
    seconds: float,
    seeds: Sequence[int],
    place: str,
    buttons: Sequence[str] = (),
    pushes: Floats | None = None,
) -> MeantDrive:
    """Drive all robots of a body at once; return one recording with an episode for each.

    Parameters
    ----------
    body
        A body with a robot for each driver.
    program
        What the drivers decide.
    hand
        How they move the stick.
    moves
        The basic behaviors that the hand aims at, by the index that the program gives.
    kit
        The kit that has the commands of these behaviors.
    seconds
        The longest drive, s.
    seeds
        A seed for each robot, by which its episode is called; the first one is also that of the noise.
    place
        Name of what has a seed, such as "room".
    buttons
        The channels that are commanded by buttons.
    pushes
        What is added to the commands of robots that are pushed, which is not recorded, shape [ticks, N, C].

    Returns
    -------
    MeantDrive
        The recording, and what the driver meant in each tick.
    """
    keys, agents = list(program.keys), body.agents
    channels = [each.name for each in body.channels]
    aims, random = list_aims(kit, moves, channels), np.random.default_rng([seeds[0], 17])
    stick = Stick(hand, agents, len(channels), random, buttons=[channels.index(each) for each in buttons])
    ticks = round(seconds / body.tick_s)
    rows, meant, commands, ends = [], [], [], np.full(agents, ticks)
    for tick in range(ticks):
        percept = body.sense(keys)
        rows.append([percept[key].copy() for key in keys])
        step = program.decide(percept)
        stick_commands = stick.move(aims[step.aimed])
        meant.append(step.meant.copy())
        commands.append(stick_commands)
        ends = np.where(step.over & (ends == ticks), tick + 1, ends)
        if (ends < ticks).all():
            break
        obeyed = stick_commands if pushes is None else stick_commands + pushes[tick]
        body.act({name: obeyed[:, index].copy() for index, name in enumerate(channels)})
    table, stops = np.array(rows), ends.tolist()
    firsts = np.cumsum([0, *stops]).tolist()

    def join(columns: Floats) -> Floats:
        return np.concatenate([columns[:end, world] for world, end in enumerate(stops)])

    recording = Record(
        np.concatenate([np.arange(end) * body.tick_s for end in stops]),
        {key: join(table[:, index]) for index, key in enumerate(keys)},
        join(np.array(commands)),
        tuple(body.channels),
        tuple(each for each in body.readings if each.name in {name for name, _ in keys}),
        tuple(dict.fromkeys(target for _, target in keys if target is not None)),
        body.tick_s,
        tuple(Episode(f"{place} {seed}", a, a + n) for seed, a, n in zip(seeds, firsts, stops, strict=False)),
    )
    return MeantDrive(recording, join(np.array(meant)).astype(np.int64))


Flags = NDArray[np.bool_]

LEARNER = TreeOptions(pruning=3.0)
NEAR_S = 0.3


@dataclass(frozen=True, slots=True)
class LabelHits:
    """The labels of a drive that are right.

    `ticks` [T] are those labelled as the driver meant, `answered` [T] as the hand answered, which is later by the dead
    time, and `switches` [S] those found within 0.3 s of where the driver decides.
    """

    ticks: Flags
    answered: Flags
    switches: Flags

    def __add__(self, other: LabelHits) -> LabelHits:
        """Return the hits of two drives."""
        pairs = [
            (self.ticks, other.ticks),
            (self.answered, other.answered),
            (self.switches, other.switches),
        ]
        return LabelHits(*map(np.concatenate, pairs))

    def score(self) -> dict[str, float]:
        """Return the share of each, from 0 to 1."""
        hits = {"ticks": self.ticks, "answered": self.answered, "switches": self.switches}
        return {name: float(each.mean()) for name, each in hits.items()}


@dataclass(frozen=True, slots=True)
class DrivenLesson:
    """The labels of a drive, and the library that it teaches."""

    hits: LabelHits
    library: Library


def learn_from_drive(
    drive: MeantDrive,
    hand: StickSettings,
    library: Library,
    name: str,
    behaviors: Sequence[str],
    *,
    features: Sequence[str] | None = None,
    targets: Mapping[str, str] = MappingProxyType({}),
    learner: TreeOptions = LEARNER,
) -> DrivenLesson:
    """Segment a drive with behaviors as candidates, and learn an automaton from the labels.

    Parameters
    ----------
    drive
        The recording, and what the driver meant, as an index of the behaviors.
    hand
        The driver's hand, whose dead time the scores allow for.
    library
        The behaviors, to which the automaton is added.
    name
        Name of the automaton.
    behaviors
        The candidates, such as "forward".
    features
        Names of the features that decisions depend on. None: all readings of the recording that the kit has.
    targets
        Targets that parameters of the automaton stand for.
    learner
        How trees are learned.

    Returns
    -------
    DrivenLesson
        The labels, and the automaton.
    """
    recording = drive.recording
    used = (
        list_drive_features(library, recording)
        if features is None
        else [parse_feature(library, each) for each in features]
    )
    segmentation = segment(recording, make_candidates(library, recording, behaviors), features=used)
    drive_lesson = to_lesson(
        segmentation, name=name, library=library, features=used, targets=targets, learner=learner
    )
    learned = drive_lesson.library.with_automaton(
        TrainedAutomaton(learn_automaton(drive_lesson.lesson), drive_lesson.lesson)
    )
    return DrivenLesson(judge_labels(segmentation, drive.meant, hand), learned)


def judge_labels(segmentation: Segmentation, meant: NDArray[np.int64], hand: StickSettings) -> LabelHits:
    """Compare the labels of a drive with what its driver meant."""
    recording = segmentation.drive
    late = np.arange(recording.ticks)
    for episode in recording.episodes:
        late[episode.ticks] = np.maximum(late[episode.ticks] - hand.dead_ticks, episode.first)
    return LabelHits(
        segmentation.labels == meant,
        segmentation.labels == meant[late],
        find_switches(segmentation.labels, meant, recording),
    )


def find_switches(labels: NDArray[np.int64], meant: NDArray[np.int64], recording: Record) -> Flags:
    """Return for each true switch whether there is one to the same label within 0.3 s."""
    hits = []
    for episode in recording.episodes:
        truth, ours = meant[episode.ticks], labels[episode.ticks]
        switches = np.flatnonzero(np.diff(ours)) + 1
        for tick in (np.flatnonzero(np.diff(truth)) + 1).tolist():
            near = switches[np.abs(switches - tick) * recording.tick_s <= NEAR_S + 1e-9]
            hits.append(bool((ours[near] == truth[tick]).any()))
    return np.array(hits, np.bool_)
