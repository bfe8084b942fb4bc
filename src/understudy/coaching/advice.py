"""Advice on a lesson, and the advice on single examples: contradictions, likely slips, and presses that stand alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import LessonAnalysis, MetDecision, StateAnalysis
from understudy.errors import UnderstudyError, join_names
from understudy.learning.mislabels import find_mislabels, list_press_examples
from understudy.learning.report import find_contradictions
from understudy.learning.training_set import group_by_feature_vector
from understudy.model.binding import Binding
from understudy.model.describe import name_examples
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Kit
from understudy.model.tree import Tree
from understudy.model.tree_regions import Box
from understudy.model.value_kinds import Categorical
from understudy.training.feature_values import compute_example_values, list_steady_kit_readings

FEW = 64
"""The number of presses with which a press of a large lesson is compared first."""
MOST_COMPARED = 600
"""The largest number of presses of which each is compared with all others, which takes the cube of their number."""
MOST_SLIPS = 3
"""The number of likely slips that are listed at once: a person who is asked about more stops reading."""
MOST_ADVICE = 2
"""The largest number of pieces of advice of one kind on one state."""
NEARBY = 0.15
"""The distance up to which another example says the same; it is well below the distance that counts as far."""
MOST_FURTHER = 24
"""The number of presses whose effect is tried by leaving each out, beyond those for which that was tried before."""


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
    `evidence` says in another sentence in how many new worlds a behavior went wrong for that; empty if in none.
    """

    kind: AdviceKind
    sentence: str
    state: str
    weight: float
    region: Box | None = None
    examples: tuple[int, ...] = ()
    at: tuple[float, ...] | None = None
    doubt: float = 0.0
    evidence: str = ""


class WrongDecisions(NamedTuple):
    """The decisions of a behavior in the new worlds in which it went wrong.

    `worlds` is the number of worlds in which it ran. `why` says what happened, by the seed of a world in which it went
    wrong, and `met` are the decisions in these worlds.
    """

    worlds: int
    why: Mapping[int, str]
    met: Sequence[MetDecision]


def advise_on_contradictions(analysis: LessonAnalysis, kit: Kit | None) -> Iterator[Advice]:
    """Advise on directives and confirmations of equal situations that disagree, with a feature that separates them."""
    for state in analysis.states.values():
        for group in find_contradictions(analysis.lesson, state.name):
            box, when = state.describe_example(group[0])
            numbers = tuple(example.number for example in group)
            where = f" in {state.place}" if state.place else ""
            sentence = f"Tell me which is right{where}{when}: {_describe_answers(group)}; delete what you did not mean."
            yield Advice(AdviceKind.CONTRADICTION, sentence, state.place, 0.95, box, numbers, group[0].values)
            separating = None if kit is None else find_separating_feature(analysis.lesson, group, kit)
            if separating is not None:
                sentence = (
                    f"Let me look at {separating}, too: it tells {name_examples(numbers)} apart, "
                    "which look the same to me now."
                )
                yield Advice(AdviceKind.SEPARATING, sentence, state.place, 0.9, box, numbers)


def _describe_answers(group: Sequence[Example]) -> str:
    """Describe what examples say: "examples 3 and 47 say right and example 71 says left"."""
    numbers: dict[str, list[int]] = {}
    for example in group:
        answer = f"keep {example.next}" if example.next == example.state else example.next
        numbers.setdefault(answer, []).append(example.number)
    return join_names(
        f"{name_examples(each)} {'say' if len(each) > 1 else 'says'} {answer}"
        for answer, each in numbers.items()
    )


def advise_on_overruled_defaults(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise on directives in the very situation of a default: the directive decides, at once."""
    for state in analysis.states.values():
        for group in group_by_feature_vector(state.examples).values():
            stays = [each.number for each in group if each.kind is ExampleKind.DEFAULT]
            leaves = [
                each for each in group if each.kind is ExampleKind.DIRECTIVE and each.next != each.state
            ]
            if stays and leaves:
                box, when = state.describe_example(group[0])
                first, numbers = leaves[0], (leaves[0].number, stays[0])
                sentence = (
                    f"Is it right that I leave {state.name} for {first.next} at once{when}? Example {numbers[0]} says "
                    f"so, and example {numbers[1]}, recorded in the same situation, says stay; if not, let me look at "
                    "something that tells them apart."
                )
                yield Advice(AdviceKind.DISAGREEMENT, sentence, state.name, 0.75, box, numbers, first.values)


def find_separating_feature(lesson: Lesson, group: Sequence[Example], kit: Kit) -> BoundFeature | None:
    """Find the feature of the kit, not in the lesson, that separates these examples most clearly; None if none does."""
    answers, clear = [example.next for example in group], dict[BoundFeature, float]()
    steady = list_steady_kit_readings(kit)
    for bound in _list_other_features(lesson, kit):
        other = replace(lesson, automaton=replace(lesson.automaton, features=(bound,)), examples=())
        with suppress(UnderstudyError, KeyError):  # it was not recorded then
            values = [compute_example_values(each, other, lesson.record, steady=steady)[0] for each in group]
            clear[bound] = _measure_separation(bound, values, answers)
    return max((bound for bound in clear if clear[bound] > 0.0), key=clear.__getitem__, default=None)


def _list_other_features(lesson: Lesson, kit: Kit) -> Iterator[BoundFeature]:
    """Yield the kit's features that the lesson does not use, with its parameters or, if it has none, with targets."""
    names = lesson.automaton.parameters or tuple(kit.targets)
    for feature in kit.features.values():
        for chosen in product(names, repeat=len(feature.parameters)):
            bound = BoundFeature(feature, Binding(dict(zip(feature.parameters, chosen, strict=True))))
            if bound not in lesson.automaton.features:
                yield bound


def _measure_separation(bound: BoundFeature, values: Sequence[float], answers: Sequence[str]) -> float:
    """Measure how clearly values separate answers, from 0 (not at all) to 1."""
    if isinstance(bound.kind, Categorical) or any(value != value for value in values):
        by_value: dict[str, set[str]] = {}
        for value, answer in zip(values, answers, strict=True):
            by_value.setdefault("absent" if value != value else f"{value}", set()).add(answer)
        return float(len(by_value) > 1 and all(len(each) == 1 for each in by_value.values()))
    pairs = sorted(zip(values, answers, strict=True))
    gaps = [(two[0] - one[0]) for one, two in pairwise(pairs) if one[1] != two[1]]
    spread = pairs[-1][0] - pairs[0][0]
    if spread <= 1e-9 * max(1.0, abs(pairs[-1][0])) or len(gaps) != len(set(answers)) - 1:
        return 0.0
    return 0.99 * float(np.min(gaps)) / spread


def advise_on_mislabels(analysis: LessonAnalysis, meant: Mapping[int, float]) -> Iterator[Advice]:
    """Advise on directives and confirmations that others contradict, the oddest first (see `learning.mislabels`).

    A press that would be decided as shown by a tree learned without it is rare but not a slip; other classifiers would
    take too long. `meant` has the presses that the demonstrator has confirmed, with the doubt at that time.
    """
    if analysis.demonstration_count > MOST_COMPARED:
        sentence = (
            f"I looked for no slips: {analysis.demonstration_count} presses are too many to compare each with all "
            f"others ({MOST_COMPARED} at most)."
        )
        yield Advice(AdviceKind.OUTLOOK, sentence, "", 0.04)
        return
    for suspect in find_mislabels(analysis.lesson, meant=meant, most=MOST_SLIPS):
        example = suspect.example
        state = analysis.states.get(example.state) or next(iter(analysis.states.values()))
        rows = tuple(row for row, each in enumerate(state.examples) if each is example)
        if rows and isinstance(state.transition, Tree) and state.predict_without(rows).all():
            continue
        box, when = state.describe_example(example)
        place = "" if analysis.lesson.automaton.stateless else example.state
        sentence = f"Did you mean this{f' in state {place}' if place else ''}{when}? {suspect.reason}"
        weight = 0.15 + 0.6 * min(1.0, suspect.doubt)
        numbers = list_press_examples(analysis.lesson, example.number)
        yield Advice(AdviceKind.SLIP, sentence, place, weight, box, numbers, example.values, suspect.doubt)


def advise_on_isolated_presses(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise, for each state, on presses without similar ones that are decided differently once they are left out.

    Those that affect most situations come first. Classifiers other than trees would take too long.
    """
    left = MOST_FURTHER
    for state in analysis.states.values():
        if not isinstance(state.transition, Tree):
            continue
        now = state.decide(state.transition, analysis.situations)
        isolated = []
        for row in _list_unsupported_presses(state):
            if (state, (row,)) not in analysis.trials:
                left -= 1
                if left < 0:
                    break
            if not state.predict_without((row,)).all():
                then = state.decide(state.fit_without((row,)), analysis.situations)
                changed = (now == state.shown.outcomes[row]) & (then != now)
                isolated.append((-float(changed.mean()) if len(changed) else 0.0, row, changed))
        advised: set[str] = set()
        for share, row, changed in sorted(isolated, key=lambda each: each[:2]):
            example = state.examples[row]
            if example.next not in advised and len(advised) < MOST_ADVICE:
                advised.add(example.next)
                yield _make_isolated_press_advice(analysis, state, example, changed, -share)


def _list_unsupported_presses(state: StateAnalysis) -> Iterator[int]:
    """Yield the rows of presses that no other nearby press agrees with; otherwise only the exact boundary is open.

    Of many, each is first compared with a few evenly chosen ones, since most have one nearby among these.
    """
    rows = np.array(state.shown_rows, np.int64)
    values, outcomes = state.shown.values[rows], state.shown.outcomes[rows]
    some = np.arange(len(rows))[:: -(-len(rows) // FEW) or 1]

    def is_supported(chosen: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
        near = state.distances.compute(values[chosen, None], values[others]) < NEARBY
        near &= (outcomes[chosen, None] == outcomes[others]) & (chosen[:, None] != others)
        return np.asarray(near.any(axis=1), np.bool_)

    for first in range(0, len(rows), FEW):
        chosen = np.arange(first, min(first + FEW, len(rows)))
        for others in (some, np.arange(len(rows))):
            chosen = chosen[~is_supported(chosen, others)]
        yield from rows[chosen].tolist()


def _make_isolated_press_advice(
    analysis: LessonAnalysis, state: StateAnalysis, example: Example, changed: NDArray[np.bool_], share: float
) -> Advice:
    """Advise on a press without which `changed` situations [M], such a `share` of all, are decided otherwise."""
    cells = {}
    for feature, cell in state.find_cells_around(example.values).items():
        column = analysis.cells[:, feature]
        here = cell | set(column[changed].tolist())
        if not here >= {*state.words[feature].cells, *column.tolist()}:  # unless these are all
            cells[feature] = here
    box, when = state.describe(cells)
    what = f"to go from {example.state} to {example.next}" if state.place else example.next
    if example.next == example.state:
        what = f"to keep {example.state}"
    alone = [state.examples[row].next for row in state.shown_rows].count(example.next) == 1
    return Advice(
        AdviceKind.SINGLE,
        f"Only example {example.number} tells me {what}{when}: show me once more, or delete it.",
        state.place,
        (0.5 if alone else 0.25) + 0.2 * min(1.0, share / 0.5),
        box,
        (example.number,),
        example.values,
    )
