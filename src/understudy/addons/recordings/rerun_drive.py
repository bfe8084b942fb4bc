"""Automata run over the readings of a drive, to compare what they would have done with its labels.

How well an automaton repeats the driver is measured on ticks that it was not learned from: each drive is left out of
learning in turn, or, where there is only one, each of several blocks of its time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType

import numpy as np

from understudy.addons.recordings.drive_examples import name_state
from understudy.addons.recordings.drive_kit import remove_functions
from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.segment import Segmentation
from understudy.learning.fit import learn_automaton
from understudy.model.example_source import ExampleSource
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.records.record import Episode, Ints, Record, fill_readings, select_episode
from understudy.records.replay import ReplayBody
from understudy.runtime.feature_columns import FeatureColumns
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import Program, link

OTHER = -1
"""The index of a state that is no label, such as start or a flag."""
MOST_PARTS = 10
"""The largest number of parts that drives are left out in, and the number of blocks of a single drive."""


class LeftOut(StrEnum):
    """What an automaton was not learned from, where it is compared with a driver."""

    NOTHING = "nothing"
    DRIVES = "drives"
    BLOCKS = "blocks of time"


@dataclass(frozen=True, slots=True)
class EpisodeAgreement:
    """How many ticks of an episode an automaton repeats.

    Parameters
    ----------
    source
        Name of the file of the episode.
    from_s
        Time of its first tick, s.
    repeated
        Ticks at which the automaton is in the state of the label.
    ticks
        Ticks with a label; those that nothing explains do not count.
    """

    source: str
    from_s: float
    repeated: int
    ticks: int


@dataclass(frozen=True, slots=True)
class Agreement:
    """How many ticks of a drive an automaton repeats, and what was left out of learning.

    Parameters
    ----------
    repeated
        Ticks at which the automaton is in the state of the label.
    ticks
        Ticks with a label.
    left_out
        What each tick was left out of learning with.
    episodes
        The ticks of each episode, in the order of the drive.
    """

    repeated: int
    ticks: int
    left_out: LeftOut
    episodes: tuple[EpisodeAgreement, ...]

    @property
    def share(self) -> float:
        """The share of ticks that are repeated, from 0 to 1; 1 without any tick that counts."""
        return self.repeated / self.ticks if self.ticks else 1.0

    def __str__(self) -> str:
        """Say it in a sentence: "900 of 1000 ticks that were left out of learning (blocks of time in turn)"."""
        how = (
            ""
            if self.left_out is LeftOut.NOTHING
            else f" that were left out of learning ({self.left_out} in turn)"
        )
        worst = min(self.episodes, key=lambda each: each.repeated / max(1, each.ticks))
        sentence = f"{self.repeated} of {self.ticks} ticks{how}"
        if len(self.episodes) > 1:
            place = f"{worst.source} from {worst.from_s:g} s"
            sentence += f"; fewest in {place}, {worst.repeated} of {worst.ticks}"
        return sentence


def run_over_drive(
    library: Library,
    automaton: str,
    drive: Record,
    names: tuple[str, ...],
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
) -> Ints:
    """Run an automaton over the readings of a drive, restarted at each episode.

    Nothing moves the robot: at each tick the readings are the recorded ones; decisions of the automaton have no effect.

    Parameters
    ----------
    library
        The library with the automaton.
    automaton
        Its name.
    drive
        The drive.
    names
        The labels, whose states are named as `to_lesson` names them.
    targets
        Targets of the automaton's parameters, by parameter.

    Returns
    -------
    array, shape [T]
        Index of the label whose state the automaton is in at each tick; `OTHER` for other states.
    """
    program = link(remove_functions(library), automaton, targets)
    states = np.full(drive.ticks, OTHER, np.int64)
    for episode in drive.episodes:
        states[episode.ticks] = _run_ticks(program, drive, episode, names)
    return states


def _run_ticks(
    program: Program,
    drive: Record,
    ticks: Episode,
    names: Sequence[str],
    before: Sequence[StackFrame] = (),
) -> list[int]:
    """Run a program over ticks in a row, from its start, or from a state that it is in before them."""
    part = fill_readings(select_episode(drive, ticks))
    sensing = FeatureColumns(program.features, ReplayBody([part]), agents=part.ticks)
    indices = {name_state(name): index for index, name in enumerate(names)}
    times = part.times.tolist()
    interpreter = Interpreter(program, now=times[0])
    if before:
        interpreter.restore(before, now=times[0])
    states = []
    for row, now in zip(sensing.columns(part.values).T.tolist(), times, strict=True):
        interpreter.pulse(row, now)
        states.append(indices.get(interpreter.path[0], OTHER))
    return states


def measure_agreement(
    segmentation: Segmentation,
    drive_lesson: DriveLesson,
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
) -> Agreement:
    """Measure how many ticks automata repeat that were learned without them.

    Each episode is left out of learning in turn, or, if there are more than `MOST_PARTS`, several at once. A single
    episode is left out in blocks of time, in each of which the automaton begins in the state of the driver.

    Parameters
    ----------
    segmentation
        The drive that the lesson was made of, with its labels.
    drive_lesson
        The lesson.
    targets
        Targets of the automaton's parameters, by parameter.

    Returns
    -------
    Agreement
        The ticks of each episode, and what was left out.
    """
    left_out = LeftOut.DRIVES if len(segmentation.drive.episodes) > 1 else LeftOut.BLOCKS
    return count_repeated(segmentation, run_left_out(segmentation, drive_lesson, targets=targets), left_out)


def run_left_out(
    segmentation: Segmentation,
    drive_lesson: DriveLesson,
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
) -> Ints:
    """Run automata over the parts of a drive that they were not learned from, as `measure_agreement` says.

    Parameters
    ----------
    segmentation
        The drive that the lesson was made of, with its labels.
    drive_lesson
        The lesson.
    targets
        Targets of the automaton's parameters, by parameter.

    Returns
    -------
    array, shape [T]
        Index of the label whose state the automaton is in at each tick; `OTHER` for other states.
    """
    drive, names = segmentation.drive, tuple(each.name for each in segmentation.candidates)
    states = np.full(drive.ticks, OTHER, np.int64)
    for part in _divide_drive(drive):
        rest = leave_out(drive_lesson.lesson, drive, part)
        program = _link_lesson(rest, drive_lesson.library, targets)
        for piece in part:
            is_block = len(drive.episodes) == 1
            before = _find_state_before(segmentation, piece, rest.name) if is_block else ()
            states[piece.ticks] = _run_ticks(program, drive, piece, names, before)
    return states


def count_repeated(
    segmentation: Segmentation, states: Ints, left_out: LeftOut = LeftOut.NOTHING
) -> Agreement:
    """Count the ticks at which an automaton was in the state of the label.

    Parameters
    ----------
    segmentation
        The labels; ticks that nothing explains do not count.
    states
        What `run_over_drive` returned.
    left_out
        What each tick was left out of learning with.

    Returns
    -------
    Agreement
        The ticks of each episode.
    """
    drive, labels = segmentation.drive, segmentation.labels
    counted = labels < len(segmentation.candidates)
    repeated = counted & (states == labels)
    return Agreement(
        int(repeated.sum()),
        int(counted.sum()),
        left_out,
        tuple(
            EpisodeAgreement(
                each.source,
                float(drive.times[each.first]),
                int(repeated[each.ticks].sum()),
                int(counted[each.ticks].sum()),
            )
            for each in drive.episodes
        ),
    )


def leave_out(lesson: Lesson, drive: Record, episodes: Sequence[Episode]) -> Lesson:
    """Return a lesson without the examples that were made from several episodes of a drive.

    Parameters
    ----------
    lesson
        The lesson.
    drive
        The drive that it was made of.
    episodes
        Episodes of the drive, or parts of them.

    Returns
    -------
    Lesson
        The lesson with the other examples.
    """
    spans = [
        (Path(each.source).name, drive.times[each.first], drive.times[each.end - 1]) for each in episodes
    ]
    others = (each for each in lesson.examples if not _is_within(each.source, spans))
    return replace(lesson, examples=tuple(others))


def _is_within(source: ExampleSource | None, spans: Sequence[tuple[str, float, float]]) -> bool:
    """Return whether an example was made from one of several spans: a file, and the times of its ends, s."""
    return source is not None and any(
        source.file == file and first <= source.time_s <= last for file, first, last in spans
    )


def _divide_drive(drive: Record) -> list[Sequence[Episode]]:
    """Divide a drive into parts that are left out of learning in turn: episodes, or blocks of a single one."""
    if len(drive.episodes) > 1:
        parts = min(len(drive.episodes), MOST_PARTS)
        return [drive.episodes[part::parts] for part in range(parts)]
    (whole,) = drive.episodes
    blocks = np.array_split(np.arange(whole.first, whole.end), MOST_PARTS)
    return [[Episode(whole.source, int(each[0]), int(each[-1]) + 1)] for each in blocks if len(each)]


def _find_state_before(segmentation: Segmentation, block: Episode, name: str) -> tuple[StackFrame, ...]:
    """Find the state of the driver before a block of an episode: the last label, or else the first in the block.

    Only the beginning of the drive shows what the driver does first, so what is learned without it cannot know.
    """
    drive, labels = segmentation.drive, segmentation.labels
    explained = np.flatnonzero(labels[: block.end] < len(segmentation.candidates))
    if not len(explained):
        return ()
    before = explained[explained < block.first]
    tick = int(before[-1]) if len(before) else int(explained[0])
    runs = drive.find_episode(tick).list_runs(labels)
    begun = next(first for first, end in runs if first <= tick < end)
    stayed_s = max(0.0, float(drive.times[block.first] - drive.times[begun]))
    return (StackFrame(name, name_state(segmentation.candidates[labels[tick]].name), stayed_s),)


def _link_lesson(lesson: Lesson, library: Library, targets: Mapping[str, str]) -> Program:
    """Learn an automaton from a lesson, and make it ready to run over readings."""
    learned = library.with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))
    return link(remove_functions(learned), lesson.name, targets)
