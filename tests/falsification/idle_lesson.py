"""A forager whose lesson has one mistake, which one press mends: it does not start where it has some 9 m to go."""

from __future__ import annotations

from dataclasses import replace

from tests.make.goto_sessions import Row, make_goto_session
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT

ROWS: tuple[Row, ...] = (  # state, next state, kind, distance in m, bearing in degrees
    ("start", "left", "directive", 1.0, 90),
    ("start", "left", "directive", 8.9, 200),
    ("start", "start", "confirmation", 9.2, 100),  # the mistake
    ("left", "left", "default", 5.0, 90),
    ("left", "left", "confirmation", 5.0, 10),
    ("left", "left", "confirmation", 5.0, 350),
    ("left", "forward", "directive", 5.0, 7),
    ("left", "forward", "directive", 5.0, 353),
    ("forward", "forward", "default", 5.0, 7),
    ("forward", "forward", "default", 5.0, 353),
    ("forward", "forward", "confirmation", 5.0, 18),
    ("forward", "forward", "confirmation", 5.0, 342),
    ("forward", "left", "directive", 5.0, 25),
    ("forward", "left", "directive", 5.0, 335),
    ("forward", "forward", "confirmation", 0.4, 0),
    ("forward", "done", "directive", 0.3, 0),
)


def make_idle_goto() -> TrainedAutomaton:
    """Make the goto of this lesson."""
    lesson = replace(make_goto_session(ROWS), options=LearnerOptions(live=True))
    return TrainedAutomaton(replace(lesson.automaton, transitions=dict(learn(lesson))), lesson)


def make_idle_library() -> Library:
    """Make the library of a forager with this goto."""
    library = Library(FORAGE_KIT).with_automaton(make_idle_goto())
    for automaton in AUTOMATA[1:]:
        library = library.with_automaton(TrainedAutomaton(automaton))
    return library
