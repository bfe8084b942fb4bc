"""Splits of states: a state that ends in two ways, which no feature tells apart, but the state before does.

A driver may do the same for two reasons, such as backing off from a wall and backing out of a dock. One state for both
has examples that contradict each other; two states, entered from different ones, do not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.candidates import SplitState, find_original
from understudy.addons.recordings.drive_examples import name_state
from understudy.addons.recordings.segment import UNEXPLAINED, Segmentation
from understudy.errors import DefinitionError, UnknownName, join_names
from understudy.learning.fit import learn_state
from understudy.model.automaton import START, name_next_state
from understudy.model.lesson import Example, ExampleKind, Lesson

FOLDS = 5
"""The number of parts into which stays are dealt; each is judged by trees that are learned from the others."""
TOLERANCE_S = 0.5
"""The time, s, before a switch in which it does not count as wrong to switch already."""
MOST_BY_CHANCE = 0.01
"""The probability up to which a split may be better by chance; shared by all splits of a state that are tried."""
MOST_FORMER = 5
"""The largest number of states before for which all splits in two are tried."""


@dataclass(frozen=True, slots=True)
class SplitProposal:
    """A state to be split in two, by the states from which it was entered.

    Parameters
    ----------
    state
        Name of the state.
    entered_from
        The states before, after which it is to be a state of its own.
    stays
        The number of stays in it that were judged.
    wrong_together
        The number of stays that one state ends wrongly: too early, too late, or in the wrong state.
    wrong_apart
        The number of stays that two states end wrongly.
    chance
        The probability that two states are as much better by chance.
    """

    state: str
    entered_from: tuple[str, ...]
    stays: int
    wrong_together: int
    wrong_apart: int
    chance: float

    def __str__(self) -> str:
        former = " or ".join(self.entered_from)
        return (
            f"{self.state} ends differently after {former}, and no feature tells why: as one state it ends wrongly in "
            f"{self.wrong_together} of {self.stays} stays, as two in {self.wrong_apart}"
        )


@dataclass(frozen=True, slots=True)
class _Stay:
    """A stay in a state: the state before, and its examples, the last of which is the switch to another state."""

    former: str
    examples: tuple[Example, ...]


def propose_splits(lesson: Lesson) -> tuple[SplitProposal, ...]:
    """Propose states to be split in two because they end in ways that only the state before tells.

    Each stay in a state is judged by trees that were learned from other stays, once with all of them, and once only
    with those that were entered from the same states.

    Parameters
    ----------
    lesson
        The lesson that was made of a drive.

    Returns
    -------
    tuple
        The proposals, at most one for each state, those that make the most stays right first.
    """
    proposals = []
    for state in lesson.automaton.states[1:]:
        best = _find_best_split(lesson, state.name, _list_stays(lesson, state.name))
        if best is not None:
            proposals.append(best)
    return tuple(sorted(proposals, key=lambda each: each.wrong_apart - each.wrong_together))


def _list_stays(lesson: Lesson, state: str) -> list[_Stay]:
    """List the stays in a state that lessons are sure of, without watched examples that are just before their end."""
    seconds = lesson.record.seconds
    switches = [
        (each, each.moment) for each in lesson.examples if each.moment is not None and not each.quarantined
    ]
    switches.sort(key=lambda pair: pair[1])
    stays: list[_Stay] = []
    former: str | None = None
    inside: list[tuple[Example, int]] = []
    for example, moment in switches:
        is_switch = example.kind is ExampleKind.DIRECTIVE and example.next != example.state
        if former is not None and example.state == state:
            if is_switch:
                early = seconds[moment] - TOLERANCE_S
                sure = (each for each, row in inside if each.is_from_press or seconds[row] < early)
                stays.append(_Stay(former, (*sure, example)))
            elif example.kind is ExampleKind.DEFAULT and inside:
                former = None  # another stay, of which it is not known what was before
            else:
                inside.append((example, moment))
        if is_switch:
            former, inside = (example.state if example.next == state else None), []
    return stays


def _find_best_split(lesson: Lesson, state: str, stays: Sequence[_Stay]) -> SplitProposal | None:
    """Return the split in two that makes the most stays right, if that can hardly be chance."""
    formers = sorted({stay.former for stay in stays})
    if not 2 <= len(formers) <= MOST_FORMER:
        return None
    together = _judge_stays(lesson, state, stays)
    best: SplitProposal | None = None
    splits = list(_split_in_two(formers))
    for apart in splits:
        halves = [
            [index for index, stay in enumerate(stays) if (stay.former in apart) is side]
            for side in (False, True)
        ]
        right = np.zeros(len(stays), np.bool_)
        for half in halves:
            right[half] = _judge_stays(lesson, state, [stays[index] for index in half])
        better, worse = int((right & ~together).sum()), int((together & ~right).sum())
        chance = min(1.0, len(splits) * _sign_test(better, worse))
        wrong = int((~right).sum())
        if chance <= MOST_BY_CHANCE and (best is None or wrong < best.wrong_apart):
            best = SplitProposal(state, apart, len(stays), int((~together).sum()), wrong, chance)
    return best


def _split_in_two(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield one side of each split of names in two: the smaller one, never with the first name of halves."""
    for count in range(1, len(names) // 2 + 1):
        for side in combinations(names, count):
            if 2 * count < len(names) or names[0] not in side:
                yield side


def _sign_test(better: int, worse: int) -> float:
    """Return the p-value of a sign test: the probability of at least `better` better cases if both are as likely."""
    count = better + worse
    return float(sum(comb(count, each) for each in range(better, count + 1)) / 2**count)


def _judge_stays(lesson: Lesson, state: str, stays: Sequence[_Stay]) -> NDArray[np.bool_]:
    """Return for each stay whether a tree that was learned from others stays and ends as the driver did."""
    right = np.zeros(len(stays), np.bool_)
    for fold in range(FOLDS):
        others = [example for at, stay in enumerate(stays) if at % FOLDS != fold for example in stay.examples]
        if not any(each.next != state for each in others):
            continue
        decide = learn_state(lesson, state, tuple(others)).decide
        for at in range(fold, len(stays), FOLDS):
            right[at] = all(
                name_next_state(lesson.automaton, state, decide(each.values)) == each.next
                for each in stays[at].examples
            )
    return right


def split_state(segmentation: Segmentation, state: str, entered_from: Iterable[str]) -> Segmentation:
    """Split a state in two: where it was entered from certain states, it gets a label of its own.

    Parameters
    ----------
    segmentation
        The labels of a drive.
    state
        Name of the state: that of a label, without parentheses.
    entered_from
        The states before; "start" for spans at the beginning of an episode.

    Returns
    -------
    Segmentation
        The labels. The new one is called as the state, with a number.

    Raises
    ------
    UnknownName
        If no label has that name, or one that it is to be entered from.
    DefinitionError
        If it was never entered from these states, or never from others.
    """
    names = [name_state(each.name) for each in segmentation.candidates]
    wanted = set(entered_from)
    for name in (state, *sorted(wanted - {START.name})):
        if name not in names:
            raise UnknownName(what="state", name=name, where="the recording", known=names)
    index, count = names.index(state), len(names)
    labels = segmentation.labels.copy()
    moved = np.zeros(len(labels), np.bool_)
    for episode in segmentation.drive.episodes:
        former = START.name
        for span in segmentation.list_spans(episode):
            if labels[span.first] == index and former in wanted:
                moved[span.first : span.end] = True
            former = UNEXPLAINED if span.label == UNEXPLAINED else name_state(span.label)
    if not moved.any() or moved[labels == index].all():
        raise DefinitionError(
            what=f"state {state!r}",
            problem=f"it was {'always' if moved.any() else 'never'} entered from {join_names(sorted(wanted))}",
            remedy="name states before that part it in two",
        )
    labels[labels == count] = count + 1
    labels[moved] = count
    posteriors = np.insert(segmentation.posteriors, count, 0.0, axis=1)
    posteriors[moved, count], posteriors[moved, index] = posteriors[moved, index], 0.0
    number = next(each for each in range(2, count + 3) if f"{state}_{each}" not in names)
    added = SplitState(f"{state}_{number}", find_original(segmentation.candidates[index]))
    # The chances of switches do not know the new label.
    return replace(
        segmentation,
        candidates=(*segmentation.candidates, added),
        labels=labels,
        posteriors=posteriors,
        switches=None,
    )
