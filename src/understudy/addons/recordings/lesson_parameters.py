"""Parameters of lessons from drives: a drive to the station teaches how to drive to any target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from understudy.errors import DefinitionError, UnknownName
from understudy.model.binding import Binding
from understudy.model.lesson import Lesson


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
