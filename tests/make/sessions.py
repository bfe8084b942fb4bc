"""Sessions with the scripted body, and their examples as rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tests.bodies import Scripted, kit
from tests.make.programs import make_automaton

from understudy.model.automaton import Automaton
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.library import Library
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

ROBOT = Library(kit)
WITH_GO = Library.from_automata(
    kit,
    make_automaton(
        "go",
        ["lap"],
        {"start": lambda d: "lap", "lap": lambda d: "done" if d <= 98 else None},
        flags=["done"],
        features=["range_of(ball)"],
    ),
)
"""A kit, and one with an automaton that runs from the start, and is done at 98 m: at tick 2."""

Row = tuple[Any, ...]


def make_session(
    states: Sequence[str] = ("forward", "left", "right"),
    features: Sequence[str] = ("range_of(ball)",),
    *,
    flags: Sequence[str] = (),
    parameters: Sequence[str] = (),
    library: Library = ROBOT,
    options: LearnerOptions = LearnerOptions(),
    stateless: bool = False,
    body: Scripted | None = None,
    targets: dict[str, str] | None = None,
    clock: Callable[[], float] | None = None,
    journal: Path | str | None = None,
) -> Session:
    lesson = new_lesson(
        library,
        "taught",
        states=states,
        features=features,
        flags=flags,
        parameters=parameters,
        stateless=stateless,
        options=options,
        live=options.live,
    )
    return Session(body or Scripted(), library, lesson, targets=targets, clock=clock, journal=journal)


def make_row(example: Example) -> Row:
    """What one example says: state, values, next state, kind."""
    values = tuple(round(value, 6) for value in example.values)
    return (example.state, *values, example.next, str(example.kind))


def list_rows(of: Session | Lesson) -> list[Row]:
    """A session's or lesson's examples as rows of a table."""
    return [make_row(example) for example in of.examples]


def ticks(session: Session, count: int) -> Session:
    for _ in range(count):
        session.tick()
    return session


def play(session: Session, *steps: str | int) -> Session:
    """Ticks (a number), directives (a state's name), `confirm`, or any other method without arguments."""
    for step in steps:
        if isinstance(step, int):
            ticks(session, step)
        elif step in session.automaton.state_names:
            session.direct(step)
        else:
            getattr(session, step)()
    return session


def decide_once(automaton: Automaton, state: str, *values: float) -> str:
    """What a state's transition function answers for a feature vector."""
    answer = automaton.transitions[state].decide(values)
    return automaton.state_names[answer] if answer >= 0 else state
