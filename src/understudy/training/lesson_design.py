"""The design of a lesson: its states, features and parameters, given by name.

"goto(nearest_food)" is a state that runs goto with its parameter bound; "distance_to(A)" is a feature of the
parameter A; "range(A) / speed" and "heading - course" are pairs of features.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import accumulate

from understudy.errors import DefinitionError, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, FlagFeature, pair_features
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.reading_pairs import PairOperation

_CALL = re.compile(r"\s*([^\s(),=]+(?:\s+[^\s(),=]+)*)\s*(?:\(([^()]*)\))?\s*")


def new_lesson(
    library: Library,
    name: str,
    *,
    states: Sequence[str | State],
    features: Sequence[str | BoundFeature],
    flags: Sequence[str] = (),
    parameters: Sequence[str] = (),
    stateless: bool = False,
    options: LearnerOptions | None = None,
    live: bool = True,
) -> Lesson:
    """Make an empty lesson, to be taught in a session.

    Parameters
    ----------
    library
        The behaviors and features that names refer to.
    name
        Name of the automaton.
    states
        States besides the start state: "forward", "goto(food)", or "approach=goto(food)" to name one.
    features
        Features of the kit, such as "distance_to(A)", or flags that states raise, such as "done".
    flags
        Flags that the automaton can raise; each gets a state.
    parameters
        Names of the automaton's parameters, such as "A".
    stateless
        Whether one tree decides in all states.
    options
        How the lesson is learned. None: the default `LearnerOptions`.
    live
        Whether the robot decides by itself from the first press on. False: the training mode of the paper, in which
        it does what it was told last. This replaces `options.live`.

    Returns
    -------
    Lesson
        A lesson without examples.

    Raises
    ------
    UnknownName
        If a behavior, a feature or a target does not exist.
    DefinitionError
        If names collide, or a single text is given instead of a list.
    """
    lists = {"states": states, "features": features, "flags": flags, "parameters": parameters}
    refuse_single_texts(name, lists)
    automaton = Automaton(
        name,
        states=(
            START,
            *(parse_state(library, state) for state in states),
            *(State(flag, flag=flag) for flag in flags),
        ),
        features=tuple(parse_feature(library, feature) for feature in features),
        parameters=tuple(parameters),
        stateless=stateless,
    )
    check_binding_names(library, automaton)
    return Lesson(automaton, options=replace(options or LearnerOptions(), live=live))


def refuse_single_texts(lesson: str, choices: Mapping[str, object]) -> None:
    """Refuse a text where a list is expected, since its letters would be taken for names."""
    for what, choice in choices.items():
        if isinstance(choice, str):
            problem = f"its {what} are {choice!r:.60}, a single text"
            remedy = f"give a list: [{choice!r:.60}]"
            raise DefinitionError(what=f"lesson {lesson!r}", problem=problem, remedy=remedy)


def parse_state(library: Library, text: str | State) -> State:
    """Parse a state from the behavior it runs: "forward", "goto(food)", or with a name, "approach=goto(food)"."""
    if isinstance(text, State):
        return text
    name, _, call = text.rpartition("=")
    behavior, arguments = _parse(call, what="state")
    binding = _bound(behavior, library.parameters(behavior), arguments)
    return State(name.strip() or behavior, behavior, binding)


def parse_feature(library: Library, text: str | BoundFeature) -> BoundFeature:
    """Parse a feature of the kit with bound parameters, "distance_to(A)", a flag of a behavior, "done", or a pair.

    A pair is a quotient or a difference of two features that are readings, or of pairs in parentheses:
    "distance_to(A) / speed", "(x_ahead - x) / speed".
    """
    if isinstance(text, BoundFeature):
        return text
    sides = _split_pair(library, text)
    if sides is not None:
        left, operation, right = sides
        return pair_features(operation, parse_feature(library, left), parse_feature(library, right))
    name, arguments = _parse(_strip_parentheses(text), what="feature")
    features = library.features
    if name not in features:
        raise UnknownName(what="feature", name=name, where="the kit", known=list(features))
    feature = features[name]
    return BoundFeature(feature, _bound(name, feature.parameters, arguments))


def _split_pair(library: Library, text: str) -> tuple[str, PairOperation, str] | None:
    """Split a pair at its sign; None if it is none.

    Names may hold the signs, too: without spaces around it, a sign parts the names of two features of the kit only.
    As in arithmetic, differences are split first, and the last sign of several.
    """
    text = _strip_parentheses(text)
    match = _CALL.fullmatch(text)
    if match is not None and match[1] in library.features:
        return None
    depths = list(accumulate((letter == "(") - (letter == ")") for letter in text))
    for operation in (PairOperation.DIFFERENCE, PairOperation.QUOTIENT):
        for place in range(len(text) - 1, -1, -1):
            if text[place] != operation.sign or depths[place] != 0:
                continue
            left, right = text[:place], text[place + 1 :]
            if left.endswith(" ") and right.startswith(" ") and left.strip():
                return left.strip(), operation, right.strip()
            if all(_names_feature(library, each) for each in (left, right)):
                return left, operation, right
    return None


def _names_feature(library: Library, text: str) -> bool:
    """Return whether a text is the name of a feature, with arguments or without, or a pair of such names."""
    match = _CALL.fullmatch(_strip_parentheses(text))
    return (match is not None and match[1] in library.features) or _split_pair(library, text) is not None


def _strip_parentheses(text: str) -> str:
    """Remove parentheses around the whole of a text."""
    text = text.strip()
    depths = list(accumulate((letter == "(") - (letter == ")") for letter in text))
    if text.startswith("(") and depths[-1] == 0 and 0 not in depths[:-1]:
        return _strip_parentheses(text[1:-1])
    return text


def check_binding_names(library: Library, automaton: Automaton) -> None:
    """Refuse an automaton with a binding to something that is neither its parameter nor a target of the kit."""
    targets = library.kit.targets
    for parameter in automaton.parameters:
        if parameter in targets:
            raise DefinitionError(
                what=f"automaton {automaton.name!r}",
                problem=f"its parameter {parameter!r} has the name of a target",
                remedy="rename the parameter",
            )
    for flag in automaton.flags:
        if not isinstance(library.kit.features.get(flag, FlagFeature(flag)), FlagFeature):
            raise DefinitionError(
                what=f"automaton {automaton.name!r}",
                problem=f"its flag {flag!r} has the name of a feature",
                remedy="rename one of the two",
            )
    for user, binding in (
        *((f"state {state.name!r}", state.binding) for state in automaton.states),
        *((f"feature {bound.feature.name!r}", bound.binding) for bound in automaton.features),
    ):
        for name in binding.values():
            if name not in automaton.parameters and name not in targets:
                raise UnknownName(
                    what="parameter or target",
                    name=name,
                    where=f"automaton {automaton.name!r}, for its {user},",
                    known=[*automaton.parameters, *targets],
                )


def check_parameter_targets(
    automaton: Automaton, targets: Mapping[str, str], targets_of_body: Sequence[str]
) -> None:
    """Refuse targets for parameters, if there is no such parameter or target."""
    for parameter, target in targets.items():
        if parameter not in automaton.parameters:
            where, names = f"automaton {automaton.name!r}", automaton.parameters
            raise UnknownName(what="parameter", name=parameter, where=where, known=names)
        if target not in targets_of_body:
            raise UnknownName(what="target", name=target, where="the body", known=targets_of_body)


def _parse(text: str, *, what: str) -> tuple[str, list[str]]:
    match = _CALL.fullmatch(text)
    if match is None:
        raise DefinitionError(what=what, problem=f"{text!r} is not a name", remedy="write name or name(A, B)")
    name, inside = match.groups()
    return name, [argument.strip() for argument in inside.split(",")] if inside else []


def _bound(name: str, parameters: Sequence[str], arguments: Sequence[str]) -> Binding:
    if len(arguments) != len(parameters):
        raise DefinitionError(
            what=name,
            problem=f"it is given {len(arguments)} of its {len(parameters)} parameters",
            remedy=f"write {name}({', '.join(parameters)})" if parameters else f"write {name}",
        )
    return Binding(dict(zip(parameters, arguments, strict=True)))
