"""How long it takes whatever looks at a lesson of two hundred examples, beside fitting a tree of scikit-learn to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from understudy.analysis.lesson_replay import replayed
from understudy.coaching.give_advice import advice
from understudy.coaching.uncertainty import Doubts
from understudy.learning.change_attribution import moved
from understudy.learning.correction_diagnosis import judge
from understudy.learning.explain import explain
from understudy.learning.fit import learn, learned
from understudy.learning.mislabels import slips
from understudy.learning.pruning_suggestions import suggestion
from understudy.model.automaton import START, Automaton, State
from understudy.model.diff import changes
from understudy.model.example import Example, ExampleKind
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import BOOLEAN, TAU, Continuous, Kind, Toroidal
from understudy.model.lesson import Lesson, Record
from understudy.model.library import Taught
from understudy.training.reaction_time import lateness
from understudy_lab.bench.learning import medians

GOAL_MS, ROUNDS = 50.0, 20
WINDOW = 11
KINDS: dict[str, Kind] = {
    "distance": Continuous(),
    "angle": Toroidal(),
    "battery": Continuous(),
    "full": BOOLEAN,
}


def two_hundred() -> Lesson:
    """Turns where it should, goes where that is ahead, is done where it is near; one press in twenty is a slip."""
    draws = np.random.default_rng(8)
    before = np.arange(1 - WINDOW, 1)[:, None] / 10
    examples, rows = [], []
    for number in range(200):
        now = np.array([draws.uniform(0, 6), draws.uniform(0, TAU), draws.uniform(0, 100), draws.integers(2)])
        second = now + before * [draws.uniform(-1, 0), draws.uniform(-1, 1), -0.1, 0.0]
        second[:, 1] %= TAU
        rows.append(second)
        state = ("go", "left", "right")[number % 3]
        following = (
            "done" if now[0] < 1 else "left" if 1 < now[1] < 3 else "right" if 3 < now[1] < 5 else "go"
        )
        if draws.random() < 0.05:
            following = ("go", "left", "right")[draws.integers(3)]
        kind = ExampleKind.DIRECTIVE if following != state else ExampleKind.CONFIRMATION
        shown = tuple(second[-1].tolist())
        moment = WINDOW * (number + 1) - 1
        examples.append(Example(number + 1, state, shown, following, kind, moment=moment, window=WINDOW - 1))
    states = (
        START,
        State("go", "forward"),
        State("left", "left"),
        State("right", "right"),
        State("done", flag="done"),
    )
    features = tuple(BoundFeature(Feature(name, kind, reading=name)) for name, kind in KINDS.items())
    seconds = np.concatenate([100 * number + before[:, 0] for number in range(200)])
    record = Record(tuple((name, None) for name in KINDS), np.vstack(rows), seconds)
    return Lesson(Automaton("goto", states, features), tuple(examples), record=record)


def looks(lesson: Lesson) -> Mapping[str, Callable[[], object]]:
    """What people ask of a lesson, by name."""
    transitions, first = learn(lesson), lesson.examples[0]
    correction = replace(lesson.examples[-1], correction=True)
    corrected = replace(lesson, examples=(*lesson.examples[:-1], correction))
    doubts = Doubts(lesson, transitions)
    now, former = Taught(learned(lesson), lesson), _former(lesson)
    return {
        "who is to blame": lambda: judge(corrected, correction),
        "slips": lambda: slips(lesson),
        "how late presses come": lambda: lateness(lesson),
        "advice": lambda: advice(lesson, transitions),
        "doubts": lambda: Doubts(lesson, transitions),
        "one doubt": lambda: doubts.doubt(first.state, first.values),
        "why": lambda: explain(lesson, first.state, first.values, transitions[first.state]),
        "what changed": lambda: (changes(former, now), moved(former, now)),
        "fewer questions": lambda: suggestion(lesson),
        "moments replayed": lambda: replayed(now, former),
    }


def _former(lesson: Lesson) -> Taught:
    """What it was ten examples ago, with one in twenty shown otherwise."""
    shown = lesson.examples[:-10]
    before = tuple(replace(each, next=each.state) if each.number % 20 == 0 else each for each in shown)
    former = replace(lesson, examples=before)
    return Taught(learned(former), former)


def run_looks(*, rounds: int = ROUNDS) -> dict[str, Any]:
    """Medians, ms, and whether each is within the goal; scikit-learn's fit beside them, where it is installed."""
    lesson = two_hundred()
    asked = dict(looks(lesson))
    try:
        peer = import_module("sklearn.tree").DecisionTreeClassifier
        values, wishes = [each.values for each in lesson.examples], [each.next for each in lesson.examples]
        asked["scikit-learn fits a tree"] = lambda: peer().fit(values, wishes)
    except ImportError:
        pass
    taken = medians(rounds, **asked)
    rows = [
        {"what": what, "ms": taken[f"{what}_ms"], "passed": taken[f"{what}_ms"] <= GOAL_MS} for what in asked
    ]
    return {
        "examples": len(lesson.examples),
        "goal_ms": GOAL_MS,
        "looks": rows,
        "passed": all(row["passed"] for row in rows),
    }
