"""Random steps of a session, the same for the same seed; a step that the session refuses changes nothing."""

from __future__ import annotations

from random import Random
from typing import Any, TypeAlias

from understudy.errors import UnderstudyError
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.training.session import Session

Step: TypeAlias = tuple[Any, ...]
"""A method of the session with its arguments, or `tick` with how many."""

AS_IN_0_1 = TreeOptions(order="gain first")
"""How 0.1.0 learned, so that what it wrote is written again."""

STATES = ("forward", "left", "right", "done", "start")
FEATURES = ("range_of(ball)", "bearing_of(goal)", "load", "seen", "time_in_state", "done", "watch")


def draw_step(
    random: Random,
    states: tuple[str, ...] = STATES,
    features: tuple[str, ...] = FEATURES,
    *,
    more: tuple[Step, ...] = (),
) -> Step:
    """One step: mostly presses and ticks. Without `more` steps to draw from, draws are those of version 0.1.0."""
    some = random.sample(features, random.randint(1, 3))
    return random.choice(
        [
            *[("direct", random.choice(states))] * 6,
            ("confirm",),
            *[("tick", random.randint(1, 12))] * 8,
            *[("undo",)] * 2,
            ("redo",),
            *[("test",)] * 2,
            ("train",),
            ("restart",),
            ("reset", random.randrange(100)),
            ("note_moved",),
            ("drive", "forward"),
            ("drive", None),
            ("watching", random.random() < 0.7),
            ("delete", random.randint(1, 8)),
            ("edit", random.randint(1, 8), random.choice(states)),
            ("choose", {"features": some}),
            ("choose", {"states": random.sample(states[:3], random.randint(1, 3))}),
            (
                "choose",
                {"options": LearnerOptions(random.choice([0.0, 0.2, 0.5]), random.random() < 0.7, AS_IN_0_1)},
            ),
            *more,
        ]
    )


def do(session: Session, step: Step) -> None:
    """Take one step."""
    what, *arguments = step
    try:
        if what == "tick":
            for _ in range(arguments[0]):
                session.tick()
        elif what == "watching":
            session.is_watching = arguments[0]
        elif what == "edit":
            session.edit(arguments[0], next=arguments[1])
        elif what == "choose":
            session.change_design(**arguments[0])
        else:
            getattr(session, what)(*arguments)
    except UnderstudyError:
        pass


def describe_acknowledged(session: Session) -> str:
    """What must outlast a kill: everything acknowledged, absent equal to absent."""
    lesson = session._log.lesson
    return repr((lesson.automaton, lesson.options, lesson.examples))
