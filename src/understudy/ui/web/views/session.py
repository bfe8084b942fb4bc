"""A picture of the desk as plain data: what a page shows of a session, put together again only where it changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from understudy.learning.report import contradictions
from understudy.model import describe
from understudy.model.automaton import Automaton, State, Transition
from understudy.model.binding import called
from understudy.model.describe import BY_CLASSIFIER, shown
from understudy.model.lesson import Example, Lesson, Trees
from understudy.model.library import Library
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import Vectors, conditions
from understudy.ui.controller.trainer import Desk
from understudy.ui.web.views.scene import Plain, described


class Nested:
    """The trained automata that an automaton runs, directly or through others, each put in words once."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Automaton, Plain]] = {}

    def below(self, automaton: Automaton, library: Library) -> Plain:
        """By name, what a page draws of them."""
        found: Plain = {}
        left = [automaton]
        while left:
            for state in left.pop().states:
                name = state.behavior
                if name is not None and name in library.taught and name not in found:
                    inner = library.automaton(name)
                    found[name] = self._drawn(inner, library)
                    left.append(inner)
        return found

    def _drawn(self, automaton: Automaton, library: Library) -> Plain:
        known = self._known.get(automaton.name)
        if known is None or known[0] is not automaton:
            known = automaton, _drawn(automaton, library, library.taught[automaton.name].lesson)
            self._known[automaton.name] = known
        return known[1]


def _drawn(automaton: Automaton, library: Library, lesson: Lesson | None) -> Plain:
    return {
        "states": [
            {
                "name": state.name,
                "flag": state.flag is not None,
                "runs": None if state.behavior is None else called(state.behavior, state.binding),
                "automaton": state.behavior if state.behavior in library.taught else None,
            }
            for state in automaton.states
        ],
        "edges": [
            {"from": state, "to": following, "when": when}
            for state, function in automaton.transitions.items()
            for following, when in ways(automaton, function, (), shown(lesson, state))
            if following != state
        ],
    }


def ways(
    automaton: Automaton, function: Transition, directed: Sequence[str], vectors: Vectors
) -> Iterator[tuple[str, list[str]]]:
    """Where a transition function learned from such vectors leads, and when; of a classifier, where it was directed."""
    if not isinstance(function, Tree):
        for following in directed:
            yield following, [BY_CLASSIFIER]
        return
    found: Mapping[int, Sequence[Any]] = conditions(function, automaton.features, vectors)
    for outcome, texts in found.items():
        if outcome != STAY:
            yield automaton.state_names[outcome], [describe.signed(text) for text in texts]


class Picture:
    """Pictures of one desk."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._of: Lesson | None = None
        self._lesson: Plain = {}
        self._nested = Nested()

    def take(self) -> Plain:
        """The desk as it is now."""
        desk, screen = self._desk, self._desk.screen
        return {
            "name": desk.name,
            "targets": dict(screen.targets),
            "mode": screen.mode.value,
            "state": screen.state,
            "path": list(screen.path),
            "flag": screen.flag,
            "waiting": screen.waiting,
            "agent": desk.robot,
            "undoable": screen.undoable,
            "redoable": screen.redoable,
            "unsaved": desk.unsaved,
            "taught": screen.examples,
            "watching": desk.session.watching,
            "doubt": _doubt(desk),
            **self._taught(),
        }

    def _taught(self) -> Plain:
        """What changes only with the lesson."""
        lesson, learned = self._desk.why.learned()
        if lesson is not self._of:
            self._of = lesson
            automaton = lesson.automaton
            self._lesson = {
                "parameters": list(automaton.parameters),
                "states": [self._state(state) for state in automaton.states],
                "features": [
                    {"label": str(bound), "unit": bound.feature.unit, **described(bound.kind)}
                    for bound in automaton.features
                ],
                "examples": _examples(lesson),
                "edges": list(_edges(lesson, learned)),
                "nested": self._nested.below(automaton, self._desk.session.library),
                "watched": lesson.options.watched,
                "reaction_s": lesson.options.reaction_s,
                "unlearning": lesson.options.unlearning,
                "flags": list(dict.fromkeys(state.flag for state in automaton.states if state.flag)),
                "outcomes": list(map(str, lesson.outcomes)),
                "pruning": lesson.options.learner.pruning
                if isinstance(lesson.options.learner, Trees)
                else None,
                "edition": self._lesson.get("edition", 0) + 1,
            }
        return self._lesson

    def _state(self, state: State) -> Plain:
        keys, taught = self._desk.keys, self._desk.session.library.taught
        return {
            "name": state.name,
            "key": keys.plain.get(state.name, ""),
            "arrow": keys.arrows.get(state.name),
            "flag": state.flag is not None,
            "runs": None if state.behavior is None else called(state.behavior, state.binding),
            "automaton": state.behavior if state.behavior in taught else None,
        }


def _doubt(desk: Desk) -> Plain | None:
    """What the last correction came to where it raised a doubt that nobody has acted on."""
    judgement = desk.session.judgement
    if judgement is None:
        return None
    held = {example.number for example in desk.session.examples if not example.quarantined}
    suspects = [
        {"number": suspect.example.number, "reason": suspect.reason}
        for suspect in judgement.suspects
        if suspect.example.number in held
    ]
    return {"reason": judgement.reason, "suspects": suspects} if suspects else None


def _examples(lesson: Lesson) -> list[Plain]:
    features = lesson.automaton.features
    against = {
        example.number
        for state in lesson.automaton.state_names
        for group in contradictions(lesson, state)
        for example in group
    }
    return [
        {
            "number": example.number,
            "state": example.state,
            "next": example.next,
            "values": [
                describe.value(bound, value) for bound, value in zip(features, example.values, strict=True)
            ],
            "kind": example.kind.value,
            "correction": example.correction,
            "time_s": _time(lesson, example),
            "contradicts": example.number in against,
            "quarantined": example.quarantined,
        }
        for example in lesson.examples
    ]


def _time(lesson: Lesson, example: Example) -> float | None:
    return None if example.moment is None else float(lesson.record.seconds[example.moment])


def _edges(lesson: Lesson, learned: Mapping[str, Transition]) -> Iterator[Plain]:
    """Where what was learned leads, and when, with the examples that showed it."""
    for state, function in learned.items():
        led: dict[str, list[int]] = {}
        for example in lesson.examples:
            if example.state == state and example.next != state and example.pressed:
                led.setdefault(example.next, []).append(example.number)
        for following, when in ways(lesson.automaton, function, list(led), shown(lesson, state)):
            if following != state:
                yield {"from": state, "to": following, "when": when, "examples": led.get(following, [])}
