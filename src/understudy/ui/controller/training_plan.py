"""The plan of a lesson: what is taught, in which library and world, settled before the first tick."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from understudy.errors import DefinitionError, SessionError, SettingError, UnboundParameter, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.scenario.schema import Scenario
from understudy.storage.library_folder import make_file_stem, normalize_name
from understudy.training.edits import DesignChange, change_design
from understudy.training.lesson_design import new_lesson, parse_feature

NEW_NAME = re.compile(r"[^\W\d_]([\w -]*[\w-])?")
"""What may be the name of something new."""


@dataclass(frozen=True)
class LessonChoices:
    """A person's choices for a lesson; None where nothing was chosen."""

    states: Sequence[str | State] | None = None
    features: Sequence[str | BoundFeature] | None = None
    flags: Sequence[str] | None = None
    parameters: Sequence[str] | None = None
    targets: Mapping[str, str] = field(default_factory=dict)
    renamed: Mapping[str, str] = field(default_factory=dict)
    watched: bool | None = None
    reaction_s: float | None = None
    unlearning: bool | None = None
    live: bool | None = None

    def options(self, former: LearnerOptions) -> LearnerOptions:
        """Return a lesson's options with these choices."""
        return replace(
            former,
            watched=former.watched if self.watched is None else self.watched,
            reaction_s=former.reaction_s if self.reaction_s is None else self.reaction_s,
            unlearning=former.unlearning if self.unlearning is None else self.unlearning,
            live=former.live if self.live is None else self.live,
        )

    def to_design_change(self, former: LearnerOptions) -> DesignChange:
        """Return the change of design that these choices mean for a lesson with these options."""
        choice = DesignChange(
            states=self.states or (),
            features=self.features or (),
            flags=self.flags or (),
            options=self.options(former),
        )
        if self.renamed:
            choice["names"] = self.renamed
        return choice


@dataclass(frozen=True)
class TrainingPlan:
    """One lesson in one world: the automaton's name, its library, and the choices."""

    name: str
    folder: Path
    world: Scenario
    library: Library
    choices: LessonChoices = LessonChoices()
    seed: int = 0

    @property
    def is_known(self) -> bool:
        """Whether the library has the automaton already."""
        return self.name in self.library.taught


@dataclass(frozen=True)
class SessionStart:
    """The data that a session starts with."""

    lesson: Lesson
    targets: Mapping[str, str]


def check_new_name(name: str, what: str) -> None:
    """Raise SessionError if a new automaton, parameter or flag (`what`) may not have this name.

    What has such a name already keeps it: files and programs may use any.
    """
    if name == START.name:
        raise SessionError(
            f"{name!r} cannot be the name of {what}: it is that of the start state; give another"
        )
    if not NEW_NAME.fullmatch(name):
        rule = "starts with a letter and has only letters, digits, _, - and spaces between them"
        raise SessionError(f"{name!r} cannot be the name of {what}: a name {rule}")


def make_session_start(plan: TrainingPlan) -> SessionStart | None:
    """Return the data to start the session with, or None if choices are missing; errors are raised."""
    make_file_stem(plan.name)
    for other in plan.library.taught:
        if other != plan.name and normalize_name(other) == normalize_name(plan.name):
            raise DefinitionError(
                what=f"automaton {plan.name!r}",
                problem=f"the library has {other!r}, which differs only in letter case or Unicode form",
                remedy=f"teach {other!r}, or give another name",
            )
    if plan.is_known:
        return _again(plan)
    check_new_name(plan.name, "an automaton")
    for parameter in plan.choices.parameters or ():
        check_new_name(parameter, "a parameter")
    for flag in plan.choices.flags or ():
        check_new_name(flag, "a flag")
    plan.library.with_automaton(
        TrainedAutomaton(Automaton(plan.name))
    )  # refuses the name of a basic behavior
    lesson = make_planned_lesson(plan, plan.choices)
    settled = plan.choices.states and plan.choices.features
    return SessionStart(lesson, choose_targets(plan, lesson, plan.choices)) if settled else None


def make_planned_lesson(plan: TrainingPlan, choices: LessonChoices) -> Lesson:
    """Make an empty lesson from the choices."""
    lesson = new_lesson(
        plan.library,
        plan.name,
        states=choices.states or (),
        features=choices.features or (),
        flags=choices.flags or (),
        parameters=choices.parameters or (),
        options=choices.options(LearnerOptions()),
        live=choices.live is not False,
    )
    plan.library.with_automaton(TrainedAutomaton(lesson.automaton))  # refuses one that contains itself
    return lesson


def _again(plan: TrainingPlan) -> SessionStart:
    lesson = plan.library.taught[plan.name].lesson
    if lesson is None:
        raise SessionError(
            f"automaton {plan.name!r} in {plan.folder} has no lesson to continue; teach one with another name"
        )
    chosen, parameters = plan.choices, lesson.automaton.parameters
    if chosen.parameters is not None and tuple(chosen.parameters) != parameters:
        raise SettingError(
            where=f"automaton {plan.name!r}",
            setting="--parameters",
            problem=f"cannot be changed after teaching began: they are {', '.join(parameters) or 'none'}",
            remedy="leave the option out, or teach one with another name",
        )
    if chosen.features is not None:
        features = tuple(parse_feature(plan.library, feature) for feature in chosen.features)
        if features != lesson.automaton.features:
            raise SettingError(
                where=f"automaton {plan.name!r}",
                setting="--features",
                problem=f"differ from those of the lesson, {', '.join(map(str, lesson.automaton.features))}",
                remedy="leave the option out, and press c in the trainer to choose others",
            )
    choice = DesignChange(options=chosen.options(lesson.options))
    if chosen.states is not None:
        choice["states"] = chosen.states
    if chosen.flags is not None:
        choice["flags"] = chosen.flags
    stand_for = choose_targets(plan, lesson, chosen)
    return SessionStart(change_design(lesson, plan.library, choice, stand_for), stand_for)


def choose_targets(plan: TrainingPlan, lesson: Lesson, choices: LessonChoices) -> dict[str, str]:
    """Choose the target of each parameter: as given, else as taught last, else the first target."""
    targets = list(plan.library.kit.targets)
    parameters = lesson.automaton.parameters
    for parameter, target in choices.targets.items():
        where = f"automaton {lesson.name!r}"
        if parameter not in parameters:
            raise UnknownName(what="parameter", name=parameter, where=where, known=parameters)
        if target not in targets:
            raise UnknownName(what="target", name=target, where=f"the {plan.world.name} world", known=targets)
    last = lesson.examples[-1].binding if lesson.examples else Binding()
    chosen_targets = {}
    for parameter in parameters:
        target = choices.targets.get(parameter, last.get(parameter, targets[0] if targets else ""))
        if target not in targets:
            raise UnboundParameter(behavior=lesson.name, parameter=parameter, targets=targets)
        chosen_targets[parameter] = target
    return chosen_targets
