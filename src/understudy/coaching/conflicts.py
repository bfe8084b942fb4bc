"""Advise on contradicting examples, on likely slips, and on features that would tell examples apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product

import numpy as np

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.lesson_analysis import LessonAnalysis
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
from understudy.training.feature_values import compute_example_values


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
