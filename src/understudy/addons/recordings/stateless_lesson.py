"""Stateless lessons from drives: one tree for all states, learned from what the driver did in any of them.

A few drives show few switches from each state, and some not at all. Where a driver decides by the readings alone, the
examples of all states tell together what those of one state do not. Which of the two a driver does is found by leaving
drives out.
"""

from __future__ import annotations

from dataclasses import replace

from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.rerun_drive import measure_agreement
from understudy.addons.recordings.segment import Segmentation
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import ExampleKind, Lesson

PRUNING = 1.0
"""The least pruning of a stateless lesson: what a single example supports is removed."""


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
    if not isinstance(lesson.options.learner, TreeOptions) or len(segmentation.drive.episodes) < 2:
        return drive_lesson
    shared = replace(drive_lesson, lesson=make_stateless(lesson))
    separate, joint = (measure_agreement(segmentation, each).same_ticks for each in (drive_lesson, shared))
    return shared if joint > separate else drive_lesson


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
