"""Stateless lessons from drives: one tree for all states, learned from what the driver did in any of them.

A few drives show few switches from each state, and some not at all. Where a driver decides by the readings alone, the
examples of all states tell together what those of one state do not. Which of the two a driver does is found by leaving
drives out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.recorded_drive import DriveEpisode, Ints, RecordedDrive
from understudy.addons.recordings.rerun_drive import OTHER, measure_agreement, run_over_drive
from understudy.addons.recordings.segment import Segmentation
from understudy.learning.fit import learn_automaton
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton

PRUNING = 1.0
"""The least pruning of a stateless lesson: what a single example supports is removed."""
MOST_PARTS = 10
"""The largest number of parts that drives are left out in."""


def choose_stateless(segmentation: Segmentation, drive_lesson: DriveLesson) -> DriveLesson:
    """Make a lesson stateless if automata then agree with the labels of left-out drives at more ticks.

    Parameters
    ----------
    segmentation
        The drive that the lesson was made of, with its labels.
    drive_lesson
        The lesson.

    Returns
    -------
    DriveLesson
        The stateless lesson; the one given if that is no better, or if it is not learned with trees. A drive with a
        single episode tells nothing.
    """
    lesson = drive_lesson.lesson
    if not isinstance(lesson.options.learner, TreeOptions):
        return drive_lesson
    shared = make_stateless(lesson)
    shares = [
        measure_agreement(segmentation, _run_left_out(segmentation, each, drive_lesson.library))
        for each in (lesson, shared)
    ]
    return replace(drive_lesson, lesson=shared) if shares[1] > shares[0] else drive_lesson


def make_stateless(lesson: Lesson) -> Lesson:
    """Make a lesson stateless, with ticks at which the driver went on as confirmations.

    Stateless lessons learn from directives and confirmations only. A tree that decides for all states needs to know
    where a behavior goes on. A driver steers all the time, so each tick without a switch is as deliberate as a switch.

    Parameters
    ----------
    lesson
        A lesson that is learned with trees.

    Returns
    -------
    Lesson
        The lesson; its pruning is at least `PRUNING`.
    """
    learner, options = lesson.options.learner, lesson.options
    if isinstance(learner, TreeOptions):
        options = replace(options, learner=replace(learner, pruning=max(learner.pruning, PRUNING)))
    return replace(
        lesson,
        automaton=replace(lesson.automaton, stateless=True),
        options=options,
        examples=tuple(
            replace(each, kind=ExampleKind.CONFIRMATION) if each.kind is ExampleKind.WATCHED else each
            for each in lesson.examples
        ),
    )


def leave_out(lesson: Lesson, drive: RecordedDrive, episodes: Sequence[DriveEpisode]) -> Lesson:
    """Return a lesson without the examples that were made from several episodes of a drive.

    Parameters
    ----------
    lesson
        The lesson.
    drive
        The drive that it was made of.
    episodes
        Episodes of the drive.

    Returns
    -------
    Lesson
        The lesson with the other examples.
    """
    others = (each for each in lesson.examples if not _is_from(each, drive, episodes))
    return replace(lesson, examples=tuple(others))


def _run_left_out(segmentation: Segmentation, lesson: Lesson, library: Library) -> Ints:
    """Run automata over the episodes that they were not learned from; return the index of the label at each tick."""
    drive = segmentation.drive
    labels = np.full(drive.ticks, OTHER, np.int64)
    parts = min(len(drive.episodes), MOST_PARTS)
    names = tuple(each.name for each in segmentation.candidates)
    for part in range(parts):
        out = drive.episodes[part::parts]
        rest = leave_out(lesson, drive, out)
        learned = library.with_automaton(TrainedAutomaton(learn_automaton(rest), rest))
        states = run_over_drive(learned, lesson.name, replace(drive, episodes=tuple(out)), names)
        for episode in out:
            labels[episode.ticks] = states[episode.ticks]
    return labels


def _is_from(example: Example, drive: RecordedDrive, episodes: Sequence[DriveEpisode]) -> bool:
    """Return whether an example was made from one of several episodes of a drive."""
    source = example.source
    return source is not None and any(
        source.file == Path(each.source).name
        and drive.times[each.first] <= source.time_s <= drive.times[each.end - 1]
        for each in episodes
    )
