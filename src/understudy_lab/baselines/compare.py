"""One teaching of one task, learned by some of the learners, and what came of it at each number of decisions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from understudy_lab.baselines.behavior_cloning import fit_nets
from understudy_lab.baselines.dagger import aggregate_rounds
from understudy_lab.baselines.demonstrations import LibraryAt, record_demonstrations, record_libraries
from understudy_lab.baselines.evaluate import success_of_libraries, success_of_policies
from understudy_lab.baselines.inputs import InputSpec, LabeledTicks, Policy, lesson_of
from understudy_lab.baselines.recording_body import RecordedTicks
from understudy_lab.baselines.sklearn_learners import CLASSICAL
from understudy_lab.baselines.tasks import EXERCISES, BaselineTask

BUDGETS = (10, 25, 50, 100, 200)
"""Decisions of the demonstrator after which everybody is judged."""
WORLDS = 20
ROUND_STEPS = 400
"""How long a net is trained in between, for a round of DAgger."""

Found: TypeAlias = dict[str, Any]

UNDERSTUDY, TREE, NEAREST, PERCEPTRON = "understudy", "tree", "nearest", "perceptron"
CLONING, DAGGER = "cloning", "dagger"
CHOSEN = ", chosen features"
"""What follows the name of a learner that has only the readings which Understudy's teacher chose."""
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
"""What each is given of the demonstrations: the best on tuning seeds."""


def worlds_of(seed: int) -> range:
    """The unseen worlds that all learners of a seed are judged in."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def evaluate_understudy(exercise: BaselineTask, seed: int) -> Found:
    """Taught as a hierarchy; after its teaching it stays as it is."""
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
    """What scikit-learn learns from whole demonstrations; with chosen readings, too, where some were left out."""
    ticks = record_demonstrations(exercise, seed, BUDGETS[-1])
    given = {"": list(range(len(exercise.kinds))), CHOSEN: exercise.chosen}
    if given[CHOSEN] == given[""]:
        del given[CHOSEN]
    return _judged(
        exercise,
        seed,
        {
            name + by: (
                ticks,
                [Policy(each, fit(each, seed), manner, basics=len(exercise.basics)) for each in made],
            )
            for by, chosen in given.items()
            for name, fit in CLASSICAL.items()
            for manner in [MANNERS[exercise.name][name]]
            for made in [_lessons(exercise, ticks, manner, chosen)]
        },
    )


def evaluate_neural(exercise: BaselineTask, seed: int) -> Found:
    """What PyTorch learns from the same demonstrations, and from labels for what it then does itself."""
    cloning, dagger = MANNERS[exercise.name][CLONING], MANNERS[exercise.name][DAGGER]

    def learn(ticks: RecordedTicks) -> Policy:
        lesson = lesson_of(ticks, exercise.kinds, dagger, basics=len(exercise.basics))
        return _policies(exercise, [lesson], seed, dagger, steps=ROUND_STEPS)[0]

    shown = record_demonstrations(exercise, seed, BUDGETS[-1])
    labeled = aggregate_rounds(exercise, seed, learn, rounds=BUDGETS)
    return _judged(
        exercise,
        seed,
        {
            name: (ticks, _policies(exercise, _lessons(exercise, ticks, manner), seed, manner))
            for name, ticks, manner in ((CLONING, shown, cloning), (DAGGER, labeled, dagger))
        },
    )


WITH: Mapping[str, Callable[[BaselineTask, int], Found]] = {
    "understudy": evaluate_understudy,
    "scikit-learn": evaluate_classical,
    "PyTorch": evaluate_neural,
}
"""What learns with what; a piece of work for each."""


def compare_learners(exercise: str, seed: int, *, by: str) -> Found:
    """By learner: success, seconds and ticks at each number of decisions."""
    return WITH[by](EXERCISES[exercise], seed)


def _lessons(
    exercise: BaselineTask, ticks: RecordedTicks, manner: InputSpec, chosen: Sequence[int] | None = None
) -> list[LabeledTicks]:
    kinds, basics = exercise.kinds, len(exercise.basics)
    return [lesson_of(ticks.upto(budget), kinds, manner, basics=basics, chosen=chosen) for budget in BUDGETS]


def _policies(
    exercise: BaselineTask, made: Sequence[LabeledTicks], seed: int, manner: InputSpec, **how: int
) -> list[Policy]:
    basics = len(exercise.basics)
    nets = fit_nets(made, seed, **how)
    return [Policy(lesson, net, manner, basics=basics) for lesson, net in zip(made, nets, strict=True)]


def _judged(
    exercise: BaselineTask, seed: int, learned: Mapping[str, tuple[RecordedTicks, list[Policy]]]
) -> Found:
    """All policies of all learners side by side, and what each was learned from."""
    policies = [policy for _, each in learned.values() for policy in each]
    success = success_of_policies(exercise, policies, worlds_of(seed))
    found: Found = {}
    for k, (name, (ticks, _)) in enumerate(learned.items()):
        parts = [ticks.upto(budget) for budget in BUDGETS]
        found[name] = {
            "success": success[k * len(BUDGETS) : (k + 1) * len(BUDGETS)],
            "seconds": [round(float(part.seconds[-1]), 1) for part in parts],
            "ticks": [len(part) for part in parts],
            "decisions": int(ticks.decisions[-1]),
        }
    return found
