"""The time of learning, and of analyses of a lesson, compared with scikit-learn's DecisionTreeClassifier."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from itertools import cycle
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.verification.check_library import check_library
from understudy.coaching.give_advice import give_advice
from understudy.coaching.reasons_to_ask import UncertaintyModel
from understudy.judging.lesson_replay import replay_lesson
from understudy.learning.change_attribution import attribute_condition_changes
from understudy.learning.explain import explain
from understudy.learning.fit import learn, learn_automaton
from understudy.learning.lesson_change import summarize_lesson_change
from understudy.learning.mislabels import diagnose_correction, find_mislabels
from understudy.learning.pruning_suggestions import suggest_pruning
from understudy.learning.tree_growth import compile_tree_kernels, grow_tree
from understudy.model.automaton import START, Automaton, State
from understudy.model.diff import diff_automata
from understudy.model.features import BoundFeature, Feature
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.value_kinds import BOOLEAN, TAU, Continuous, Kind, Toroidal
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.training.lesson_design import new_lesson
from understudy.training.reaction_time import estimate_reaction_time
from understudy.training.session import Session
from understudy_lab.bench.harness import import_peer, medians
from understudy_lab.bench.wall_following import ACTIONS, drive_along_walls
from understudy_lab.forage.teach import teach

Data = tuple[NDArray[np.float64], NDArray[np.int64]]

SIZES = {20: 300, 100: 300, 1000: 60, 10_000: 9}
"""The numbers of examples, each with the number of repeats."""

STATES = 4
NUMBER = Continuous()


def run() -> dict[str, Any]:
    """Return medians in ms: ours from a lesson, ours from arrays to a Tree, and scikit-learn's `fit` from arrays.

    All are warm, grow until every leaf is pure, and take turns. `from_lesson` includes checking every value
    and making arrays of the Example objects; scikit-learn's fit includes its own checking of the arrays, and
    uses the faster of its criteria. `as_fast` compares arrays with arrays, `as_fast_from_lesson` a lesson
    with arrays.
    """
    peer = import_peer("sklearn.tree", "scikit-learn").DecisionTreeClassifier
    began = perf_counter()
    compile_tree_kernels()
    first_call_ms = (perf_counter() - began) * 1e3
    sizes = []
    for count, repeats in SIZES.items():
        data = continuous(count, noise=0.03)
        lesson = lesson_of(data)
        measured = medians(
            repeats,
            ours=partial(_ours, data, [NUMBER] * 3),
            from_lesson=partial(learn, lesson),
            sklearn_gini=partial(_theirs, peer, "gini", data),
            sklearn_entropy=partial(_theirs, peer, "entropy", data),
        )
        sklearn_ms = min(measured["sklearn_gini_ms"], measured["sklearn_entropy_ms"])
        tree = _ours(data, [NUMBER] * 3)
        sizes.append(
            {
                "examples": count,
                **measured,
                "sklearn_ms": sklearn_ms,
                "as_fast": measured["ours_ms"] <= sklearn_ms,
                "as_fast_from_lesson": measured["from_lesson_ms"] <= sklearn_ms,
                "nodes": len(tree.nodes),
                "depth": tree.depth,
                "sklearn_nodes": int(_theirs(peer, "entropy", data).tree_.node_count),
            }
        )
    toroidal, noisy = circular(400, noise=0.05), continuous(5000, noise=0.05)
    goals = [
        _goal("1 toroidal feature, n = 400", 10.0, 40, toroidal, [Toroidal()]),
        _goal("3 continuous features, n = 5000", 25.0, 11, noisy, [NUMBER] * 3),
    ]
    walls = measure_wall_following(peer)
    return {
        "first_call_ms": first_call_ms,
        "sizes": sizes,
        "goals": goals,
        "wall_following": walls,
        "passed": all(size["as_fast"] for size in sizes) and all(goal["passed"] for goal in [*goals, walls]),
    }


WALL_ROUNDS, FOLDS, MOST_TIMES = 9, 10, 2.0


def measure_wall_following(peer: Any) -> dict[str, Any]:
    """Compare processor time and accuracy in cross-validation on a table like the UCI wall-following data set.

    Of scikit-learn's two criteria the faster one counts, and for accuracy the better one.
    """
    values, outcomes = data = drive_along_walls()
    kinds = [NUMBER] * values.shape[1]
    fits: dict[str, Callable[[Data], Callable[[NDArray[np.float64]], NDArray[np.int64]]]] = {
        "ours": lambda table: _decide_by(_ours(table, kinds)),
        "sklearn_gini": lambda table: _theirs(peer, "gini", table).predict,
        "sklearn_entropy": lambda table: _theirs(peer, "entropy", table).predict,
    }
    times: dict[str, list[float]] = {name: [] for name in fits}
    for _ in range(WALL_ROUNDS + 1):
        for name, fit in fits.items():
            began = process_time()
            fit(data)
            times[name].append((process_time() - began) * 1e3)
    fold = np.random.default_rng(0).permutation(len(outcomes)) % FOLDS
    right: dict[str, float] = {}
    for name, fit in fits.items():
        hits = [
            fit((values[fold != left], outcomes[fold != left]))(values[fold == left])
            == outcomes[fold == left]
            for left in range(FOLDS)
        ]
        right[name] = float(np.concatenate(hits).mean())
    taken = {name: float(np.median(each[1:])) for name, each in times.items()}
    ratio = taken["ours"] / min(taken["sklearn_gini"], taken["sklearn_entropy"])
    best = max(right["sklearn_gini"], right["sklearn_entropy"])
    return {
        "what": f"{len(outcomes)} rows of a wall follower, {len(kinds)} sonars, {len(ACTIONS)} actions",
        "processor_ms": taken,
        "accuracy": right,
        "ratio": ratio,
        "goal_ratio": MOST_TIMES,
        "passed": ratio <= MOST_TIMES and right["ours"] >= best,
    }


def _decide_by(tree: Any) -> Callable[[NDArray[np.float64]], NDArray[np.int64]]:
    return lambda rows: np.array([tree.decide(row) for row in rows.tolist()], np.int64)


def continuous(count: int, *, noise: float, seed: int = 0) -> Data:
    """Draw three continuous features [n, 3], two of which decide between four outcomes [n], some of them random."""
    random = np.random.default_rng(seed)
    values = random.random((count, 3)) * 10
    outcomes = (values[:, 0] > 5).astype(np.int64) + 2 * (values[:, 1] > 3)
    return values, np.where(random.random(count) < noise, random.integers(0, STATES, count), outcomes)


def circular(count: int, *, noise: float, seed: int = 0) -> Data:
    """Draw one toroidal feature [n, 1] with an arc across the seam, with some inverted outcomes [n]."""
    random = np.random.default_rng(seed)
    values = random.random((count, 1)) * TAU
    outcomes = ((values[:, 0] < 0.7) | (values[:, 0] > 5.5)).astype(np.int64)
    return values, np.where(random.random(count) < noise, 1 - outcomes, outcomes)


def lesson_of(data: Data, kind: Kind = NUMBER) -> Lesson:
    """Return a lesson of one state with these examples, all directives."""
    values, outcomes = data
    names = [START.name, *(f"state_{index}" for index in range(1, STATES))]
    features = tuple(
        BoundFeature(Feature(f"x{index}", kind, reading="x")) for index in range(values.shape[1])
    )
    automaton = Automaton("bench", (START, *(State(name, name) for name in names[1:])), features)
    return Lesson(
        automaton,
        tuple(
            Example(number, START.name, tuple(row), names[outcome], ExampleKind.DIRECTIVE)
            for number, (row, outcome) in enumerate(zip(values.tolist(), outcomes.tolist(), strict=True))
        ),
    )


def _ours(data: Data, kinds: Sequence[Kind]) -> Any:
    values, outcomes = data
    return grow_tree(values, outcomes, np.ones(len(outcomes), np.int64), kinds, states=STATES, current=0)


def _theirs(peer: Any, criterion: str, data: Data) -> Any:
    return peer(criterion=criterion, random_state=0).fit(*data)


def _goal(what: str, goal_ms: float, repeats: int, data: Data, kinds: Sequence[Kind]) -> dict[str, Any]:
    lesson = lesson_of(data, kinds[0])
    measured = medians(repeats, ours=lambda: _ours(data, kinds), from_lesson=lambda: learn(lesson))
    return {"what": what, "goal_ms": goal_ms, **measured, "passed": measured["from_lesson_ms"] <= goal_ms}


GOAL_MS, ROUNDS = 50.0, 20
PRESS = "a live press, and the tick that decides by it"
CHECK, CHECK_GOAL_MS, CHECKED = "the check of 20 taught automata", 100.0, 20
WINDOW = 11
KINDS: dict[str, Kind] = {
    "distance": Continuous(),
    "angle": Toroidal(),
    "battery": Continuous(),
    "full": BOOLEAN,
}


def two_hundred() -> Lesson:
    """Return a lesson of 200 examples of turning, driving and stopping, one in twenty of them wrong."""
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
    record = ReadingLog(tuple((name, None) for name in KINDS), np.vstack(rows), seconds)
    return Lesson(Automaton("goto", states, features), tuple(examples), record=record)


def looks(lesson: Lesson) -> Mapping[str, Callable[[], object]]:
    """Return the analyses of a lesson, by name."""
    transitions, first = learn(lesson), lesson.examples[0]
    correction = replace(lesson.examples[-1], correction=True)
    corrected = replace(lesson, examples=(*lesson.examples[:-1], correction))
    doubts = UncertaintyModel(lesson, transitions)
    now, former = TrainedAutomaton(learn_automaton(lesson), lesson), _former(lesson)
    return {
        "who is to blame": lambda: diagnose_correction(corrected, correction),
        "slips": lambda: find_mislabels(lesson),
        "how late presses come": lambda: estimate_reaction_time(lesson),
        "advice": lambda: give_advice(lesson, transitions),
        "doubts": lambda: UncertaintyModel(lesson, transitions),
        "one doubt": lambda: doubts.estimate(first.state, first.values),
        "why": lambda: explain(lesson, first.state, first.values, transitions[first.state]),
        "what changed": lambda: (diff_automata(former, now), attribute_condition_changes(former, now)),
        "what changed, in one line": lambda: summarize_lesson_change(former, now),
        "fewer questions": lambda: suggest_pruning(lesson),
        "moments replayed": lambda: replay_lesson(now, former),
    }


PRESS_GOAL_MS = 10.0
FEATURES = ("distance_to(nearest_food)", "angle_to(nearest_food)", "food_stored", "food_below_me")
NAMES = {"go": "forward", "left": "rotate_left", "right": "rotate_right"}
"""The states of the world by those of the lesson that is measured."""


def make_live_session(lesson: Lesson) -> Session:
    """Return a session that is taught live in the foraging world, with the examples of `lesson`."""
    library = Library(FORAGE_KIT)
    here = new_lesson(
        library,
        "goto",
        states=list(NAMES.values()),
        flags=["done"],
        features=FEATURES,
        options=LearnerOptions(live=True),
    )
    examples = tuple(
        replace(
            each,
            state=NAMES.get(each.state, each.state),
            next=NAMES.get(each.next, each.next),
            moment=None,
            window=0,
        )
        for each in lesson.examples
    )
    return Session(Forage([0]), library, replace(here, examples=examples))


def press_repeatedly(session: Session) -> Callable[[], None]:
    """Return a function that presses another state each time, and runs the tick that learns and decides."""
    states = cycle(NAMES.values())

    def press() -> None:
        session.direct(next(states))
        session.tick()

    return press


def check_repeatedly() -> Callable[[], None]:
    """Return a function that checks the automata of a taught forager until it has checked `CHECKED`."""
    library = teach(901).library
    names = list(library.taught)

    def check() -> None:
        for _ in range(CHECKED // len(names)):
            check_library(library, names, kit_known=True)

    return check


def _former(lesson: Lesson) -> TrainedAutomaton:
    """Return the automaton of ten examples earlier, with one example in twenty different."""
    shown = lesson.examples[:-10]
    before = tuple(replace(each, next=each.state) if each.number % 20 == 0 else each for each in shown)
    former = replace(lesson, examples=before)
    return TrainedAutomaton(learn_automaton(former), former)


def run_looks(*, rounds: int = ROUNDS) -> dict[str, Any]:
    """Return medians in ms with the goal of each, and scikit-learn's fit if it is installed.

    A live press adds an example each time.
    """
    lesson = two_hundred()
    asked = dict(looks(lesson))
    try:
        peer = import_module("sklearn.tree").DecisionTreeClassifier
        values, wishes = [each.values for each in lesson.examples], [each.next for each in lesson.examples]
        asked["scikit-learn fits a tree"] = lambda: peer().fit(values, wishes)
    except ImportError:
        pass
    asked[PRESS] = press_repeatedly(make_live_session(lesson))
    asked[CHECK] = check_repeatedly()
    taken = medians(rounds, **asked)
    special = {PRESS: PRESS_GOAL_MS, CHECK: CHECK_GOAL_MS}
    goals = {what: special.get(what, GOAL_MS) for what in asked}
    rows = [
        {"what": what, "ms": ms, "goal_ms": goal, "passed": ms <= goal}
        for what, goal in goals.items()
        for ms in [taken[f"{what}_ms"]]
    ]
    return {
        "examples": len(lesson.examples),
        "looks": rows,
        "passed": all(row["passed"] for row in rows),
    }
