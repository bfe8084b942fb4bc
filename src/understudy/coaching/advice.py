"""Advice on a lesson, and the advice on single examples: contradictions, likely slips, and presses that stand alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.coaching.situation_text import Cells, find_cells, make_situation_box
from understudy.errors import UnderstudyError, join_names
from understudy.learning.mislabels import find_mislabels, list_press_examples
from understudy.learning.report import find_contradictions
from understudy.learning.training_set import group_by_feature_vector
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Categorical
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Kit
from understudy.model.tree import Tree
from understudy.model.tree_regions import Box
from understudy.training.feature_values import compute_example_values


class AdviceKind(StrEnum):
    """The subject of advice."""

    CONTRADICTION = "contradiction"  # directives or confirmations of one situation that say different things
    DISAGREEMENT = "disagreement"  # a directive and an automatic default of one situation
    SLIP = "slip"  # a press that the others speak against
    SEPARATING = "separating"  # a feature that would tell contradicting examples apart
    NEVER_LEFT = "never left"
    NEVER_ENTERED = "never entered"
    GAP = "gap"  # a situation near no example
    STRETCHED = "stretched"  # a state is left where what was shown nearest says otherwise
    SINGLE = "single"  # a boundary held up by one example
    IDLE = "idle"  # features that decide nothing
    OUTLOOK = "outlook"  # whether more examples are likely to help
    FEW = "few"  # too little was shown to tell


@dataclass(frozen=True, slots=True)
class Advice:
    """One sentence for a person, and the situation that it refers to.

    `state` is where to demonstrate ("" for the lesson as a whole). `region` has the feature vectors concerned, one part
    for each of the lesson's features (None: no situation in particular), and `at` is one of them that represents it.
    `examples` are the numbers of the examples concerned. `weight` says how useful the advice is, from 0 to 1; it is
    plainly useful above 0.5. `doubt` says how strongly other examples contradict a press that looks like a slip.
    """

    kind: AdviceKind
    sentence: str
    state: str
    weight: float
    region: Box | None = None
    examples: tuple[int, ...] = ()
    at: tuple[float, ...] | None = None
    doubt: float = 0.0


def advise_on_contradictions(survey: LessonAnalysis, kit: Kit | None) -> Iterator[Advice]:
    """Advise on directives and confirmations of equal situations that disagree, with a feature that separates them."""
    for state in survey.learners:
        for group in find_contradictions(survey.lesson, state):
            place = survey.place(state)
            box, when = survey.describe_example(state, group[0])
            numbers = tuple(example.number for example in group)
            yield Advice(
                AdviceKind.CONTRADICTION,
                f"Tell me which is right{_in(place)}{when}: {_wishes(group)}; delete what you did not mean.",
                place,
                0.95,
                box,
                numbers,
                group[0].values,
            )
            if kit is not None:
                for bound in find_separating_features(survey, group, kit)[:1]:
                    yield Advice(
                        AdviceKind.SEPARATING,
                        f"Let me look at {bound}, too: it tells examples {join_names(map(str, numbers))} "
                        "apart, which look the same to me now.",
                        place,
                        0.9,
                        box,
                        numbers,
                    )


def advise_on_overruled_defaults(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise on directives in the very situation of a default: the directive decides, at once."""
    for state, learner in survey.learners.items():
        for group in group_by_feature_vector(learner.examples).values():
            defaults = [example for example in group if example.kind is ExampleKind.DEFAULT]
            leaving = [
                example
                for example in group
                if example.kind is ExampleKind.DIRECTIVE and example.next != example.state
            ]
            if not defaults or not leaving:
                continue
            box, when = survey.describe_example(state, group[0])
            first, stays = leaving[0], defaults[0]
            yield Advice(
                AdviceKind.DISAGREEMENT,
                f"Is it right that I leave {state} for {first.next} at once{when}? Example {first.number} says so, and "
                f"example {stays.number}, recorded in the same situation, says stay; if not, let me look at something "
                "that tells them apart.",
                state,
                0.75,
                box,
                (first.number, stays.number),
                first.values,
            )


def find_separating_features(
    survey: LessonAnalysis, group: Sequence[Example], kit: Kit
) -> list[BoundFeature]:
    """Find features of the kit that the lesson does not use and that separate these examples, the clearest first."""
    lesson = survey.lesson
    steady = frozenset(
        feature.reading or ""
        for feature in kit.features.values()
        if isinstance(feature, Feature) and isinstance(feature.kind, Categorical)
    )
    found = []
    for order, bound in enumerate(_others(survey, kit)):
        automaton = replace(lesson.automaton, features=(bound,))
        asked = replace(lesson, automaton=automaton, examples=())
        try:
            values = [
                compute_example_values(example, asked, lesson.record, steady=steady)[0] for example in group
            ]
        except (UnderstudyError, KeyError):  # it was not recorded then
            continue
        clear = _clearness(bound, values, [example.next for example in group])
        if clear > 0:
            found.append((-clear, order, bound))
    return [bound for _, _, bound in sorted(found, key=lambda each: each[:2])]


def _others(survey: LessonAnalysis, kit: Kit) -> Iterator[BoundFeature]:
    """Yield the kit's features that the lesson does not use, with its parameters or, if it has none, with targets."""
    automaton = survey.lesson.automaton
    names = automaton.parameters or tuple(kit.targets)
    for feature in kit.features.values():
        for chosen in product(names, repeat=len(feature.parameters)):
            bound = BoundFeature(feature, Binding(dict(zip(feature.parameters, chosen, strict=True))))
            if bound not in automaton.features:
                yield bound


def _clearness(bound: BoundFeature, values: Sequence[float], wishes: Sequence[str]) -> float:
    """Return how clearly values separate wishes, from 0 (not at all) to 1."""
    if isinstance(bound.kind, Categorical) or any(value != value for value in values):
        said: dict[str, set[str]] = {}
        for value, wish in zip(values, wishes, strict=True):
            said.setdefault("absent" if value != value else f"{value}", set()).add(wish)
        return 1.0 if len(said) > 1 and all(len(wished) == 1 for wished in said.values()) else 0.0
    pairs = sorted(zip(values, wishes, strict=True))
    parted = [(two[0] - one[0]) for one, two in pairwise(pairs) if one[1] != two[1]]
    spread = pairs[-1][0] - pairs[0][0]
    if spread <= 1e-9 * max(1.0, abs(pairs[-1][0])) or len(parted) != len(set(wishes)) - 1:
        return 0.0
    return 0.99 * float(np.min(parted)) / spread


def _wishes(group: Sequence[Example]) -> str:
    """Format what examples say: "examples 3 and 47 say right and example 71 says left"."""
    by_wish: dict[str, list[str]] = {}
    for example in group:
        by_wish.setdefault(_wish(example), []).append(str(example.number))
    return join_names(
        f"example {numbers[0]} says {wish}"
        if len(numbers) == 1
        else f"examples {join_names(numbers)} say {wish}"
        for wish, numbers in by_wish.items()
    )


def _wish(example: Example) -> str:
    return f"keep {example.next}" if example.next == example.state else example.next


def _in(place: str) -> str:
    return f" in {place}" if place else ""


MOST = 3
"""So many at once: who is asked about more stops reading."""


def advise_on_mislabels(survey: LessonAnalysis, meant: Mapping[int, float]) -> Iterator[Advice]:
    """Advise on directives and confirmations that others contradict, the oddest first (see `learning.mislabels`).

    A press that would be decided as shown without it, too, is rare but not a slip. `meant` has the presses that the
    demonstrator has confirmed, with the doubt at that time.
    """
    if survey.is_scant:
        return
    for suspect in find_mislabels(survey.lesson, meant=meant, most=MOST):
        example = suspect.example
        taught = example.state if example.state in survey.learners else next(iter(survey.learners))
        if _foretold(survey, taught, example):
            continue
        box, when = survey.describe_example(taught, example)
        place = survey.place(example.state)
        yield Advice(
            AdviceKind.SLIP,
            f"Did you mean this{f' in state {place}' if place else ''}{when}? {suspect.reason}",
            place,
            0.15 + 0.6 * min(1.0, suspect.doubt),
            box,
            list_press_examples(survey.lesson, example.number),
            example.values,
            suspect.doubt,
        )


def _foretold(survey: LessonAnalysis, state: str, example: Example) -> bool:
    """Return whether a tree learned without a press decides as it says; other classifiers would take too long."""
    learner = survey.learners[state]
    if not isinstance(survey.transition(state), Tree):
        return False
    row = learner.examples.index(example)
    return bool(
        learner.decide_all(learner.fit_without(row), [example.values])[0] == learner.shown.outcomes[row]
    )


NEARBY = 0.15
"""So near, another example says the same: well within what is far from one."""
MOST_FURTHER = 24
"""So many presses of a large lesson are left out one by one for this, beside those that were already."""
MOST_ADVICE = 2
"""So many of one state."""


def advise_on_isolated_presses(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise, for each state, on presses without similar ones that are decided differently once they are left out.

    Those that affect most situations come first. Classifiers other than trees would take too long.
    """
    if survey.is_scant:
        return
    vectors, left = survey.situations.tolist(), MOST_FURTHER
    for state, learner in survey.learners.items():
        if not isinstance(survey.transition(state), Tree):
            continue
        now = learner.decide_all(survey.transition(state), vectors)
        known = {trial.rows[0]: trial.transition for trial in survey.trials[state] if len(trial.rows) == 1}
        found = []
        for row in _without_fellows(survey, state):
            example, outcome = learner.examples[row], learner.shown.outcomes[row]
            if row not in known:
                if not left:
                    break
                left -= 1
            without = known.get(row) or learner.fit_without(row)
            if learner.decide_all(without, [example.values])[0] != outcome:
                changed = (now == outcome) & (learner.decide_all(without, vectors) != now)
                found.append((-float(changed.mean()) if len(changed) else 0.0, row, changed))
        told: set[str] = set()
        for share, row, changed in sorted(found, key=lambda each: each[:2]):
            example = learner.examples[row]
            if example.next not in told and len(told) < MOST_ADVICE:
                told.add(example.next)
                yield _make_isolated_press_advice(survey, state, example, changed, -share)


def _without_fellows(survey: LessonAnalysis, state: str) -> list[int]:
    """Return the rows of presses that no other nearby press agrees with; otherwise only the exact boundary is open."""
    learner = survey.learners[state]
    rows = np.flatnonzero([example.is_shown for example in learner.examples])
    values, outcomes = learner.shown.values[rows], learner.shown.outcomes[rows]
    near = survey.make_distances(state).compute(values[:, None], values[None]) < NEARBY
    near &= outcomes[:, None] == outcomes[None]
    alone: list[int] = rows[near.sum(axis=1) == 1].tolist()  # itself
    return alone


def _is_alone(survey: LessonAnalysis, state: str, example: Example) -> bool:
    """Return whether no other press leads from the state to the same next state."""
    said = [each for each in survey.learners[state].examples if each.is_shown and each.next == example.next]
    return len(said) == 1


def _make_isolated_press_advice(
    survey: LessonAnalysis, state: str, example: Example, changed: NDArray[np.bool_], share: float
) -> Advice:
    cells = _cells(survey, example, changed)
    said = survey.describe_situation(state, cells)
    place = survey.place(state)
    when = f" when {said}" if said else ""
    if example.next == example.state:
        what = f"to keep {example.state}{when}"
    else:
        what = f"to go from {example.state} to {example.next}{when}" if place else f"{example.next}{when}"
    return Advice(
        AdviceKind.SINGLE,
        f"Only example {example.number} tells me {what}: show me once more, or delete it.",
        place,
        (0.5 if _is_alone(survey, state, example) else 0.25) + 0.2 * min(1.0, share / 0.5),
        make_situation_box(survey.words, cells),
        (example.number,),
        example.values,
    )


def _cells(survey: LessonAnalysis, example: Example, changed: NDArray[np.bool_]) -> Cells:
    """Return the cells of an example and of the situations that depend on it, unless these are all cells."""
    own = find_cells(survey.words, np.array([example.values], np.float64).reshape(1, -1))[0]
    cells = {}
    for feature, word in enumerate(survey.words):
        here = {int(own[feature]), *survey.cells[changed, feature].tolist()}
        if not here >= {*word.cells, *survey.cells[:, feature].tolist()}:
            cells[feature] = frozenset(here)
    return cells
