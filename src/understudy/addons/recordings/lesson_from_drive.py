"""Lessons from segmented drives, which show when the driver switched, and how late the driver's hand answered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from understudy.addons.recordings.automaton_candidate import AutomatonCandidate
from understudy.addons.recordings.candidates import BehaviorCandidate, Candidate, find_original
from understudy.addons.recordings.drive_examples import (
    list_drive_steady_readings,
    make_drive_examples,
    name_state,
)
from understudy.addons.recordings.drive_kit import list_drive_features, make_drive_kit
from understudy.addons.recordings.propose_behaviors import describe_command, discover_behaviors
from understudy.addons.recordings.segment import Segmentation
from understudy.errors import DefinitionError, UnknownName
from understudy.learning.report import learn_and_report
from understudy.model.automaton import State
from understudy.model.behaviors import Behavior
from understudy.model.binding import Binding
from understudy.model.drawing import format_number_of
from understudy.model.example_source import ExampleSource
from understudy.model.features import BoundFeature, FlagFeature
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.training.lesson_design import new_lesson
from understudy.training.reaction_time import (
    SHIFTS_S,
    ReactionEstimate,
    compute_shift_likelihood,
    estimate_reaction_time,
)

CONTRADICTED = 12.0
"""The amount by which each example that the learned rules contradict lowers a reaction time's log likelihood."""


@dataclass(frozen=True, slots=True)
class DriveLesson:
    """A lesson that was made of a drive, or of the drives of several drivers.

    Parameters
    ----------
    lesson
        The lesson. Examples that the drive leaves in doubt are in quarantine, with the reason.
    library
        The library in which its behaviors are found.
    reaction
        The estimate of the driver's reaction time, which the lesson is set to. None: too few switches to tell, or there
        are several drivers, each with a time of their own.
    """

    lesson: Lesson
    library: Library
    reaction: ReactionEstimate | None = None

    @property
    def sources(self) -> Mapping[int, ExampleSource]:
        """The places in recordings that the examples were made from, by number of the example."""
        source_of = {each.number: each.source for each in self.lesson.examples if each.source is not None}
        return MappingProxyType(source_of)

    @property
    def drivers(self) -> tuple[str, ...]:
        """The names of the drivers, in the order of their examples; an empty one for a driver without a name."""
        return tuple(dict.fromkeys(each.driver for each in self.sources.values()))


def to_lesson(
    segmentation: Segmentation,
    *,
    name: str = "driven",
    driver: str = "",
    library: Library | None = None,
    features: Sequence[str | BoundFeature] | None = None,
    targets: Mapping[str, str] = MappingProxyType({}),
    watched: bool = True,
    reaction_s: float | None = None,
    learner: TreeOptions | None = None,
) -> DriveLesson:
    """Make a lesson of a segmented drive, which shows when the driver switched from one behavior to another.

    Parameters
    ----------
    segmentation
        The drive with its labels.
    name
        Name of the automaton.
    driver
        Name of the person who drove, which each example notes.
    library
        The features and behaviors that the automaton uses. None: a feature for each reading, and the candidates.
    features
        Features that decisions depend on, such as "range(ball)". None: all readings of the drive that the kit has, and
        the flags that its automata raise.
    targets
        Targets of the drive that parameters of the automaton stand for, by parameter: {"A": "station"} makes a drive to
        the station teach goto(A).
    watched
        Whether ticks without a switch become watched examples.
    reaction_s
        The driver's reaction time, s. None: estimated from the drive.
    learner
        How trees are learned; long drives give thousands of examples, so that pruning helps. None: as in any lesson.

    Returns
    -------
    DriveLesson
        The lesson, and where its examples come from.

    Raises
    ------
    DefinitionError
        If no candidate explains any tick.
    UnknownName
        If the library does not have a feature or a behavior, or no state or feature names a target.
    """
    drive = segmentation.drive
    used = [
        each for index, each in enumerate(segmentation.candidates) if (segmentation.labels == index).any()
    ]
    if not used:
        recurring = [describe_command(drive.channels, each.command) for each in discover_behaviors(drive)]
        looks = f", which look like {'; '.join(recurring)}" if recurring else ""
        raise DefinitionError(
            what="recording",
            problem=f"none of the candidates explains any of its commands{looks}",
            remedy="give other behaviors, or check scales and signs of the commands",
        )
    library = Library(make_drive_kit(drive, {})) if library is None else library
    library = _with_behaviors(library, used)
    if features is None:
        features = [*list_drive_features(library, drive), *_list_flag_features(library, used)]
    states = [_make_state(each) for each in used]
    empty = new_lesson(
        library,
        name,
        states=states,
        features=features,
        options=LearnerOptions(
            watched=watched, reaction_s=reaction_s or 0.0, learner=learner or TreeOptions()
        ),
        live=False,
    )
    lesson, estimate = make_drive_examples(segmentation, library, empty), None
    if reaction_s is None:
        estimate = estimate_reaction_time(lesson, steady=list_drive_steady_readings(drive))
        if estimate is not None and estimate.reaction_s:
            lesson, estimate = _choose_reaction_time(segmentation, library, lesson, estimate)
    examples = (
        replace(each, source=None if each.source is None else replace(each.source, driver=driver))
        for each in lesson.examples
    )
    parametrized = parametrize_lesson(replace(lesson, examples=tuple(examples)), targets)
    return DriveLesson(parametrized, library, estimate)


def _choose_reaction_time(
    segmentation: Segmentation, library: Library, lesson: Lesson, estimate: ReactionEstimate
) -> tuple[Lesson, ReactionEstimate]:
    """Return the lesson by the estimated reaction time, or by a shorter one that explains the examples better.

    Readings a tick before the right ones are often as close together, but there, drivers went on at other times.
    """
    steps = int(estimate.reaction_s / segmentation.drive.tick_s + 1e-9)
    times = [round(estimate.reaction_s - step * segmentation.drive.tick_s, 3) for step in range(steps + 1)]
    steady = list_drive_steady_readings(segmentation.drive)
    likelihood = np.interp(times, SHIFTS_S, compute_shift_likelihood(lesson, steady=steady))
    # Examples are made again: the reaction time also decides which watched ticks before a press are discarded.
    empty = Lesson(lesson.automaton, options=lesson.options)
    best, score, wrong = 0, -np.inf, dict[int, int]()
    for step in np.argsort(-likelihood, kind="stable").tolist():
        if likelihood[step] <= score:  # even if the rules contradict no example
            continue
        late = replace(empty, options=replace(empty.options, reaction_s=times[step]))
        candidate = make_drive_examples(segmentation, library, late)
        wrong[step] = _count_disagreements(candidate)
        if likelihood[step] - CONTRADICTED * wrong[step] > score:
            best, score, lesson = step, likelihood[step] - CONTRADICTED * wrong[step], candidate
    if best == 0:
        return lesson, estimate
    evidence = (
        f"{estimate.evidence} With {times[best]:g} s, the learned rules contradict "
        f"{format_number_of(wrong[best], 'example')} instead of {wrong[0]}."
    )
    return lesson, replace(estimate, reaction_s=times[best], evidence=evidence)


def _count_disagreements(lesson: Lesson) -> int:
    """Count the examples that the automaton of a lesson decides otherwise than shown."""
    return sum(each.disagreements for each in learn_and_report(lesson).states.values())


def _with_behaviors(library: Library, used: Sequence[Candidate]) -> Library:
    """Return the library with a behavior for each candidate that it lacks, such as a command model."""
    behaviors = dict(library.kit.behaviors)
    for each in map(find_original, used):
        if not isinstance(each, BehaviorCandidate | AutomatonCandidate):
            behaviors.setdefault(each.name, Behavior(each.name))
        elif isinstance(each, BehaviorCandidate):
            behaviors.setdefault(each.ground.behavior.name, each.ground.behavior)
        elif each.behavior not in library.taught:
            where = "the library of the lesson"
            raise UnknownName(what="automaton", name=each.behavior, where=where, known=list(library.taught))
    return replace(library, kit=replace(library.kit, behaviors=MappingProxyType(behaviors)))


def _list_flag_features(library: Library, used: Sequence[Candidate]) -> list[BoundFeature]:
    """List the features of a kit that are flags which automata among the candidates raise, such as "done"."""
    raised = {
        state.flag
        for each in map(find_original, used)
        if isinstance(each, AutomatonCandidate)
        for state in library.taught[each.behavior].automaton.states
    }
    flags = library.kit.features.values()
    return [BoundFeature(each) for each in flags if isinstance(each, FlagFeature) and each.name in raised]


def _make_state(candidate: Candidate) -> State:
    """Make the state of a label; its name is that of the label, without parentheses."""
    name = name_state(candidate.name)
    candidate = find_original(candidate)
    if isinstance(candidate, BehaviorCandidate):
        return State(name, candidate.ground.behavior.name, candidate.ground.binding)
    if isinstance(candidate, AutomatonCandidate):
        return State(name, candidate.behavior, candidate.binding)
    return State(name, candidate.name)


def parametrize_lesson(lesson: Lesson, targets: Mapping[str, str]) -> Lesson:
    """Replace targets that states and features of a lesson name by parameters of its automaton.

    Parameters
    ----------
    lesson
        A lesson whose automaton has no parameters.
    targets
        Target by parameter, such as A for the station.

    Returns
    -------
    Lesson
        The lesson of an automaton with these parameters, which were bound to the targets in all examples.

    Raises
    ------
    UnknownName
        If no state and no feature of the lesson names a target.
    DefinitionError
        If two parameters stand for one target, or a parameter has the name of a target of the lesson.
    """
    if not targets:
        return lesson
    automaton = lesson.automaton
    bindings = [each.binding for each in automaton.states] + [each.binding for each in automaton.features]
    named = {target for each in bindings for target in each.values()}
    what = f"lesson {lesson.name!r}"
    for parameter, target in targets.items():
        if target not in named:
            raise UnknownName(
                what="target", name=target, where=f"the states and features of {what}", known=sorted(named)
            )
        if parameter in named:
            problem = f"its parameter {parameter!r} has the name of a target"
            raise DefinitionError(what=what, problem=problem, remedy="rename the parameter")
    parameters = {target: parameter for parameter, target in targets.items()}
    if len(parameters) < len(targets):
        problem = f"its parameters {', '.join(targets)} stand for one target"
        raise DefinitionError(what=what, problem=problem, remedy="give each parameter a target of its own")
    binding = Binding(targets)
    return replace(
        lesson,
        automaton=replace(
            automaton,
            states=tuple(
                replace(each, binding=each.binding.substitute(parameters)) for each in automaton.states
            ),
            features=tuple(
                replace(each, binding=each.binding.substitute(parameters)) for each in automaton.features
            ),
            parameters=tuple(targets),
        ),
        examples=tuple(replace(each, binding=binding) for each in lesson.examples),
    )
