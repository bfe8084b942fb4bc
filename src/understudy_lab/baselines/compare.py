"""Comparison of learners on one task with one seed: success at each number of decisions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from understudy.model.features import Percept
from understudy.runtime.body import Commands, list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy_lab.baselines.demonstrations import (
    RESTING,
    Demonstrator,
    LibraryAt,
    OnboardPolicy,
    RecordedTicks,
    record_demonstrations,
    record_libraries,
)
from understudy_lab.baselines.flat_learners import (
    CLASSICAL,
    InputSpec,
    LabeledTicks,
    Policy,
    fit_nets,
    lesson_of,
)
from understudy_lab.baselines.tasks import EXERCISES, BaselineTask

Learn: TypeAlias = Callable[[RecordedTicks], OnboardPolicy]

MOST_WORLDS = 25
"""The largest number of worlds in a round."""


def aggregate_rounds(
    exercise: BaselineTask, seed: int, learn: Learn, *, rounds: Sequence[int]
) -> RecordedTicks:
    """Return all ticks of rounds that each end at a number of decisions; the first round is demonstrated.

    In later rounds the policy drives in every other world and is labeled; the teacher demonstrates in the others,
    because a policy that makes no progress reveals nothing of the rest.
    """
    demonstrator = Demonstrator(exercise, seed)
    for decisions in rounds:
        policy = learn(demonstrator.ticks) if demonstrator.presses else None
        for world in range(MOST_WORLDS):
            demonstrator.show(aboard=policy if world % 2 == 0 else None, most=decisions)
            if demonstrator.presses >= decisions:
                break
    return demonstrator.ticks


def success_of_policies(
    exercise: BaselineTask, policies: Sequence[Policy], seeds: Sequence[int]
) -> list[float]:
    """Return the share of worlds in which each policy succeeds."""
    world = exercise.world([seed for _ in policies for seed in seeds])
    keys, each = list_reading_keys(world), len(seeds)
    channels = [channel.name for channel in world.channels]
    table = np.zeros((len(exercise.basics) + 1, len(channels)))  # the last one rests
    for row, commands in zip(table, exercise.commands, strict=False):
        for name, value in commands.items():
            row[channels.index(name)] = value

    def decide(percept: Percept) -> Commands:
        raw = np.stack([percept[key] for key in keys], axis=1)
        chosen = np.concatenate(
            [policy.decide(raw[k * each : (k + 1) * each]) for k, policy in enumerate(policies)]
        )
        return dict(zip(channels, table[np.where(chosen == RESTING, len(table) - 1, chosen)].T, strict=True))

    return _shares(exercise.judge(world, decide, keys), len(policies))


def success_of_libraries(
    exercise: BaselineTask, taught: Sequence[LibraryAt], seeds: Sequence[int]
) -> list[float]:
    """Return the share of worlds in which each library succeeds; 0 without an automaton for the whole task."""
    root = exercise.topics[-1].name
    whole = [each for each in taught if root in each.library.taught]
    if not whole:
        return [0.0] * len(taught)
    world = exercise.world([seed for _ in whole for seed in seeds])
    programs = [link(each.library, root, exercise.targets) for each in whole]
    engine = Engine(world, [program for program in programs for _ in seeds])
    shares = _shares(exercise.judge(world, engine.decide, engine.keys), len(whole))
    return [0.0] * (len(taught) - len(whole)) + shares


def _shares(well: np.ndarray[tuple[int], np.dtype[np.bool_]], parts: int) -> list[float]:
    return [round(float(part.mean()), 4) for part in np.split(well, parts)]


BUDGETS = (10, 25, 50, 100, 200)
"""The numbers of the demonstrator's decisions after which all learners are tested."""
WORLDS = 20
ROUND_STEPS = 400
"""The training steps of a net for a round of DAgger."""

Found: TypeAlias = dict[str, Any]

UNDERSTUDY, TREE, NEAREST, PERCEPTRON = "understudy", "tree", "nearest", "perceptron"
CLONING, DAGGER = "cloning", "dagger"
CHOSEN = ", chosen features"
"""The suffix of learners that get only the features which Understudy's teacher chose."""
LEARNERS = (UNDERSTUDY, TREE, NEAREST, PERCEPTRON, CLONING, DAGGER, *(name + CHOSEN for name in CLASSICAL))
NEURAL = (PERCEPTRON, CLONING, DAGGER, PERCEPTRON + CHOSEN)

NOW = InputSpec(advance=2)
EARLIER = InputSpec(advance=2, lags=(2, 4))
REMEMBERED = InputSpec(advance=2, lags=(2, 4), before=True)
WEIGHED = InputSpec(advance=2, lags=(2, 4), weigh=True)
DRAWN = InputSpec(advance=2, lags=(2, 4), drawn=True)
MANNERS: Mapping[str, Mapping[str, InputSpec]] = {
    "goto": dict.fromkeys(LEARNERS, EARLIER),
    "forage": {TREE: WEIGHED, **dict.fromkeys((NEAREST, *NEURAL), DRAWN)},
    "servoing": dict.fromkeys(LEARNERS, REMEMBERED),
    "walls": dict.fromkeys(LEARNERS, NOW),
}
"""The input encoding of each learner by task, the best on tuning seeds."""


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds in which all learners of a seed are tested."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def evaluate_understudy(exercise: BaselineTask, seed: int) -> Found:
    """Teach the task as a hierarchy and test it; after the end of the teaching the library does not change."""
    stood = record_libraries(exercise, seed)
    nothing = LibraryAt(0, 0.0, exercise.library())
    points = [[nothing, *(each for each in stood if each.decisions <= budget)][-1] for budget in BUDGETS]
    return {
        UNDERSTUDY: {
            "success": success_of_libraries(exercise, points, worlds_of(seed)),
            "seconds": [round(point.seconds, 1) for point in points],
            "ticks": [round(point.seconds / 0.1) for point in points],
            "decisions": stood[-1].decisions,
        }
    }


def evaluate_classical(exercise: BaselineTask, seed: int) -> Found:
    """Test what scikit-learn learns from whole demonstrations, also with only the chosen features."""
    ticks = record_demonstrations(exercise, seed, BUDGETS[-1])
    features_by_choice = {"": list(range(len(exercise.kinds))), CHOSEN: exercise.chosen}
    if features_by_choice[CHOSEN] == features_by_choice[""]:
        del features_by_choice[CHOSEN]
    return _judged(
        exercise,
        seed,
        {
            name + by: (
                ticks,
                [Policy(each, fit(each, seed), manner, basics=len(exercise.basics)) for each in labeled],
            )
            for by, chosen in features_by_choice.items()
            for name, fit in CLASSICAL.items()
            for manner in [MANNERS[exercise.name][name]]
            for labeled in [_lessons(exercise, ticks, manner, chosen)]
        },
    )


def evaluate_neural(exercise: BaselineTask, seed: int) -> Found:
    """Test what PyTorch learns from the same demonstrations, and with labels for its own actions (DAgger)."""
    cloning, dagger = MANNERS[exercise.name][CLONING], MANNERS[exercise.name][DAGGER]

    def learn(ticks: RecordedTicks) -> Policy:
        lesson = lesson_of(ticks, exercise.kinds, dagger, basics=len(exercise.basics))
        return _policies(exercise, [lesson], seed, dagger, steps=ROUND_STEPS)[0]

    demonstrations = record_demonstrations(exercise, seed, BUDGETS[-1])
    labeled = aggregate_rounds(exercise, seed, learn, rounds=BUDGETS)
    return _judged(
        exercise,
        seed,
        {
            name: (ticks, _policies(exercise, _lessons(exercise, ticks, manner), seed, manner))
            for name, ticks, manner in ((CLONING, demonstrations, cloning), (DAGGER, labeled, dagger))
        },
    )


WITH: Mapping[str, Callable[[BaselineTask, int], Found]] = {
    "understudy": evaluate_understudy,
    "scikit-learn": evaluate_classical,
    "PyTorch": evaluate_neural,
}
"""The families of learners; each is a task of its own."""


def compare_learners(exercise: str, seed: int, *, by: str) -> Found:
    """Return success, seconds and ticks at each number of decisions, by learner of one family."""
    return WITH[by](EXERCISES[exercise], seed)


def _lessons(
    exercise: BaselineTask, ticks: RecordedTicks, manner: InputSpec, chosen: Sequence[int] | None = None
) -> list[LabeledTicks]:
    kinds, basics = exercise.kinds, len(exercise.basics)
    return [lesson_of(ticks.upto(budget), kinds, manner, basics=basics, chosen=chosen) for budget in BUDGETS]


def _policies(
    exercise: BaselineTask, lessons: Sequence[LabeledTicks], seed: int, manner: InputSpec, **how: int
) -> list[Policy]:
    basics = len(exercise.basics)
    nets = fit_nets(lessons, seed, **how)
    return [Policy(lesson, net, manner, basics=basics) for lesson, net in zip(lessons, nets, strict=True)]


def _judged(
    exercise: BaselineTask, seed: int, learned: Mapping[str, tuple[RecordedTicks, list[Policy]]]
) -> Found:
    """Test all policies of all learners together, and return the results with the data each was learned from."""
    policies = [policy for _, each in learned.values() for policy in each]
    success = success_of_policies(exercise, policies, worlds_of(seed))
    judged: Found = {}
    for k, (name, (ticks, _)) in enumerate(learned.items()):
        parts = [ticks.upto(budget) for budget in BUDGETS]
        judged[name] = {
            "success": success[k * len(BUDGETS) : (k + 1) * len(BUDGETS)],
            "seconds": [round(float(part.seconds[-1]), 1) for part in parts],
            "ticks": [len(part) for part in parts],
            "decisions": int(ticks.decisions[-1]),
        }
    return judged
