"""Lessons of several drivers merged into one, in which each example says who showed it.

Each driver is segmented apart, with a noise, a quickness and a reaction time of their own. When their reaction times
differ, the examples keep them, so that features that are added later are read as early as each driver decided.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from types import MappingProxyType
from typing import TypeVar

import numpy as np

from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.errors import DefinitionError, join_names
from understudy.model.automaton import Automaton, State
from understudy.model.features import format_reading_label
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.model.library import Kit, Library
from understudy.training.feature_values import list_steady_kit_readings, recompute_example_values

T = TypeVar("T")


def merge_driver_lessons(lessons: Sequence[DriveLesson]) -> DriveLesson:
    """Merge lessons of several drivers into one; examples are renumbered, and say who drove.

    Parameters
    ----------
    lessons
        At least one lesson, each made by `to_lesson` with the name of its driver. States and features are those that
        any of them has, and other options than the reaction time are those of the first.

    Returns
    -------
    DriveLesson
        The lesson. If the reaction times of the drivers differ, each example made by a press has its driver's, and the
        lesson has their median, for presses that come later.

    Raises
    ------
    DefinitionError
        If there is no lesson, a driver has no name or two lessons, the robots have different readings, or a state runs
        different behaviors.
    """
    _check_drivers(lessons)
    _check_readings(lessons)
    automaton = _merge_automata([each.lesson.automaton for each in lessons])
    library = _merge_libraries([each.library for each in lessons])
    parts = [_compute_values(each.lesson, automaton, library.kit) for each in lessons]
    times = [each.options.reaction_s for each in parts]
    if len(set(times)) > 1:
        parts = [_keep_reaction_time(each) for each in parts]
    record = ReadingLog(
        parts[0].record.keys,
        np.vstack([each.record.values for each in parts]),
        np.concatenate([each.record.seconds for each in parts]),
    )
    lesson = replace(
        parts[0],
        examples=tuple(_renumber(parts)),
        options=replace(parts[0].options, reaction_s=round(float(np.median(times)), 3)),
        record=record,
    )
    return DriveLesson(lesson, library, lessons[0].reaction if len(lessons) == 1 else None)


def _check_drivers(lessons: Sequence[DriveLesson]) -> None:
    what = "lessons of drivers"
    if not lessons:
        raise DefinitionError(what=what, problem="there are none", remedy="give at least one")
    names = [name for each in lessons for name in each.drivers]
    if "" in names:
        remedy = "give to_lesson(..., driver=NAME), so that each example says who showed it"
        raise DefinitionError(what=what, problem="one has no name of its driver", remedy=remedy)
    for name in names:
        if names.count(name) > 1:
            remedy = "segment all recordings of a driver together: segment([recording, recording], ...)"
            raise DefinitionError(what=what, problem=f"two are of driver {name!r}", remedy=remedy)


def _check_readings(lessons: Sequence[DriveLesson]) -> None:
    for first, other in pairwise(lessons):
        ours, theirs = (list(map(format_reading_label, each.lesson.record.keys)) for each in (first, other))
        if ours != theirs:
            raise DefinitionError(
                what=f"lesson of {join_names(other.drivers)}",
                problem=f"its readings are {join_names(theirs)}, but those of {join_names(first.drivers)} are "
                f"{join_names(ours)}",
                remedy="learn from recordings of different robots one by one",
            )


def _merge_automata(automata: Sequence[Automaton]) -> Automaton:
    """Return the first automaton with the states and features of all; refuse states that run different behaviors."""
    states: dict[str, State] = {}
    for state in chain.from_iterable(each.states for each in automata):
        if states.setdefault(state.name, state) != state:
            raise DefinitionError(
                what=f"state {state.name!r}",
                problem="it runs another behavior in the lesson of another driver",
                remedy="give candidates with the same names and behaviors for all drivers",
            )
    features = dict.fromkeys(chain.from_iterable(each.features for each in automata))
    return replace(automata[0], states=tuple(states.values()), features=tuple(features))


def _merge_libraries(libraries: Sequence[Library]) -> Library:
    """Return a library with what any of the libraries has; of things with one name, those of the first."""
    kits = [each.kit for each in libraries]
    kit = Kit(
        _merge_mappings(each.features for each in kits),
        _merge_mappings(each.behaviors for each in kits),
        _merge_mappings(each.targets for each in kits),
    )
    return replace(libraries[0], kit=kit, taught=_merge_mappings(each.taught for each in libraries))


def _merge_mappings(mappings: Iterable[Mapping[str, T]]) -> Mapping[str, T]:
    merged: dict[str, T] = {}
    for name, part in chain.from_iterable(each.items() for each in mappings):
        merged.setdefault(name, part)
    return MappingProxyType(merged)


def _compute_values(lesson: Lesson, automaton: Automaton, kit: Kit) -> Lesson:
    """Return a lesson for the merged automaton, with values of the features that only other drivers' lessons have."""
    merged = replace(lesson, automaton=automaton)
    if lesson.automaton.features == automaton.features:
        return merged
    return recompute_example_values(lesson, merged, lesson.record, steady=list_steady_kit_readings(kit))


def _keep_reaction_time(lesson: Lesson) -> Lesson:
    """Return the lesson with its reaction time in each example made by a press that has none of its own."""
    reaction_s = lesson.options.reaction_s
    examples = (
        replace(each, reaction_s=reaction_s) if each.is_from_press and each.reaction_s is None else each
        for each in lesson.examples
    )
    return replace(lesson, examples=tuple(examples))


def _renumber(parts: Sequence[Lesson]) -> Iterator[Example]:
    """Yield the examples of all lessons with numbers, and rows of the joined record, after those before."""
    number = row = 0
    for part in parts:
        for each in part.examples:
            moment = None if each.moment is None else each.moment + row
            yield replace(each, number=each.number + number, moment=moment)
        number += max((each.number for each in part.examples), default=0)
        row += len(part.record)
