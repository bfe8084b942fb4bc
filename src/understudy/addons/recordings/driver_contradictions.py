"""Contradictions between drivers: situations of a lesson in which one driver switched and another did not, by name.

The trees of a merged lesson cannot show them, because they separate contradicting examples if a test can. So each
driver's own examples are learned apart, and the trees of each two drivers are compared where both have examples. No
driver switches twice at the very same reading, and reaction times are estimates: what happened while a driver may have
been deciding already is not compared, and a difference counts only if it is unlikely by chance.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from understudy.errors import UnknownName
from understudy.learning.fisher_test import compute_fisher_p
from understudy.learning.fit import learn_state
from understudy.learning.leave_one_out import compute_pairwise_distances
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Automaton, Transition, name_next_state
from understudy.model.describe import format_values
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY, TestKind, Tree
from understudy.training.edits import set_quarantine
from understudy.training.watched_examples import measure_deciding_time

CHANCE = 0.05
"""The probability by chance below which a difference between two drivers is a contradiction."""
MOST_COMPARED = 300
"""The approximate number of examples of each driver that are compared to find the two most similar ones."""


@dataclass(frozen=True, slots=True)
class DriverContradiction:
    """A contradiction between two drivers of a lesson, who chose different next states in similar situations.

    Parameters
    ----------
    state
        Name of the state.
    drivers
        Names of the two drivers.
    nexts
        Name of the next state that each of them chose; that of the state itself for staying.
    numbers
        Numbers of each driver's examples that contradict the other.
    examples
        The example of each driver that is most like one of the other.
    readings
        The values of these two by the features that matter, as text.
    """

    state: str
    drivers: tuple[str, str]
    nexts: tuple[str, str]
    numbers: tuple[tuple[int, ...], tuple[int, ...]]
    examples: tuple[Example, Example]
    readings: tuple[str, str]

    def __str__(self) -> str:
        """Say who did what and where: "anna switches from forward to back at ...; ben stays in forward at ..."."""
        return f"{self.describe_side(0)}; {self.describe_side(1)}"

    def describe_side(self, index: int) -> str:
        """Say in words what one of the two drivers did, and where their recording shows it.

        Parameters
        ----------
        index
            0 or 1, as in `drivers`.

        Returns
        -------
        str
            Text such as "ben stays in forward at range(ball) = 0.85 m (ben.csv at 40.1 s)".
        """
        following, source = self.nexts[index], self.examples[index].source
        stays = following == self.state
        what = f"stays in {self.state}" if stays else f"switches from {self.state} to {following}"
        reading = f" at {self.readings[index]}" if self.readings[index] else ""
        place = "" if source is None else f" ({source.file} at {source.time_s:.1f} s)"
        return f"{self.drivers[index]} {what}{reading}{place}"


def find_driver_contradictions(lesson: Lesson) -> tuple[DriverContradiction, ...]:
    """Find where drivers of a lesson contradict each other, beyond what chance explains.

    Parameters
    ----------
    lesson
        A lesson whose examples say who drove, as `merge_driver_lessons` makes it, also after it was stored.

    Returns
    -------
    tuple[DriverContradiction, ...]
        The contradictions, by state in declared order: one for each choice of two drivers and their next states.

    Notes
    -----
    The examples of each driver are learned apart. Where the trees of two drivers decide differently, both drivers'
    examples are counted, and compared by Fisher's exact test: Fisher, The Design of Experiments (1935), section 2.
    """
    taught = {name: _learn_driver(lesson, name) for name in list_drivers(lesson)}
    return tuple(
        each
        for state in lesson.automaton.state_names
        for pair in combinations([name for name, learned in taught.items() if state in learned], 2)
        for each in _compare_drivers(lesson, state, pair, (taught[pair[0]][state], taught[pair[1]][state]))
    )


def settle_driver_contradictions(
    lesson: Lesson, trust: str, contradictions: Sequence[DriverContradiction] | None = None
) -> Lesson:
    """Settle contradictions between drivers: the examples of all others that contradict one driver teach nothing.

    Parameters
    ----------
    lesson
        The lesson.
    trust
        Name of the driver who is right.
    contradictions
        Which contradictions are settled; those between other drivers stay. None: all, also those that come out when
        others are settled.

    Returns
    -------
    Lesson
        The lesson with these examples in quarantine, with the reason.

    Raises
    ------
    UnknownName
        If no example of the lesson is of that driver.
    """
    drivers = list_drivers(lesson)
    if trust not in drivers:
        raise UnknownName(what="driver", name=trust, where=f"lesson {lesson.name!r}", known=drivers)
    if contradictions is not None:
        return set_quarantine(lesson, _list_reasons(trust, contradictions))
    while reasons := _list_reasons(trust, find_driver_contradictions(lesson)):
        lesson = set_quarantine(lesson, reasons)
    return lesson


def list_drivers(lesson: Lesson) -> list[str]:
    """List the names of the drivers that the examples of a lesson are of.

    Parameters
    ----------
    lesson
        The lesson.

    Returns
    -------
    list
        The names in the order of their examples.
    """
    names = (each.source.driver for each in lesson.examples if each.source is not None)
    return list(dict.fromkeys(name for name in names if name))


def _list_reasons(trust: str, contradictions: Sequence[DriverContradiction]) -> dict[int, str]:
    """List the examples that contradict a trusted driver, with the reason why they teach nothing."""
    return {
        number: f"contradicts {each.describe_side(each.drivers.index(trust))}"
        for each in contradictions
        if trust in each.drivers
        for number in each.numbers[1 - each.drivers.index(trust)]
    }


@dataclass(frozen=True, slots=True)
class _LearnedState:
    """The transition function learned from the examples of one driver in one state, and those that are compared."""

    function: Transition
    compared: tuple[Example, ...]


def _learn_driver(lesson: Lesson, driver: str) -> Mapping[str, _LearnedState]:
    """Learn the examples of one driver, by state; a stateless lesson is taken as one with states here."""
    mine = [each for each in lesson.examples if each.source is not None and each.source.driver == driver]
    undecided = _find_undecided(lesson, mine)
    automaton = replace(lesson.automaton, stateless=False)
    own = replace(lesson, automaton=automaton, examples=tuple(mine))
    return {
        state: _LearnedState(
            learn_state(own, state, examples),
            tuple(each for each in examples if each.number not in undecided),
        )
        for state, examples in group_examples_by_state(own).items()
    }


def _find_undecided(lesson: Lesson, examples: Sequence[Example]) -> set[int]:
    """Find the watched examples of so short a time before a press that its driver may have been deciding already."""
    pressed: dict[str, list[tuple[float, float]]] = {}
    for each in examples:
        if each.source is not None and each.is_shown:
            reaction_s = lesson.options.reaction_s if each.reaction_s is None else each.reaction_s
            press = each.source.time_s, measure_deciding_time(reaction_s)
            insort(pressed.setdefault(each.source.file, []), press)
    undecided = set()
    for each in examples:
        if each.source is not None and not each.is_from_press:
            presses = pressed.get(each.source.file, [])
            following = presses[bisect_left(presses, (each.source.time_s, 0.0)) :][:1]
            if any(time_s - each.source.time_s <= late_s for time_s, late_s in following):
                undecided.add(each.number)
    return undecided


def _compare_drivers(
    lesson: Lesson, state: str, names: tuple[str, str], learned: tuple[_LearnedState, _LearnedState]
) -> Iterator[DriverContradiction]:
    """Yield the contradictions of two drivers in a state: one for each two next states that their trees decide for."""
    cells: dict[tuple[str, str], tuple[list[Example], list[Example]]] = {}
    for side, each in enumerate(learned):
        for example in each.compared:
            one, two = (_decide(other.function, lesson.automaton, state, example) for other in learned)
            if one is not None and two is not None and one != two:
                cells.setdefault((one, two), ([], []))[side].append(example)
    used = _list_tested_features(lesson, [each.function for each in learned])
    for nexts, held in cells.items():
        first, second = (
            [each for each in examples if each.next == following]
            for examples, following in zip(held, nexts, strict=True)
        )
        if first and second and _compute_chance(*held, nexts[1]) < CHANCE:
            alike = _find_most_alike(first, second, used)
            yield DriverContradiction(
                state,
                names,
                nexts,
                (_list_numbers(first), _list_numbers(second)),
                alike,
                (_format_reading(alike[0], used), _format_reading(alike[1], used)),
            )


def _decide(function: Transition, automaton: Automaton, state: str, example: Example) -> str | None:
    """Return the next state that a function decides for; None for what its driver never showed."""
    if isinstance(function, Tree) and function.path(example.values)[1] == STAY:
        return None
    return name_next_state(automaton, state, function.decide(example.values))


def _compute_chance(first: Sequence[Example], second: Sequence[Example], following: str) -> float:
    """Compute the probability that, by chance, the second driver has as many of the examples that lead to a state."""
    mine = sum(each.next == following for each in second)
    went = sum(each.next == following for each in first)
    return compute_fisher_p(mine, len(second), went, len(first))


Tested = list[tuple[int, BoundFeature]]
"""Features with their places in feature vectors."""


def _list_tested_features(lesson: Lesson, functions: Sequence[Transition]) -> Tested:
    """List the features that any of some trees tests; all if one is no tree."""
    features = list(enumerate(lesson.automaton.features))
    trees = [each for each in functions if isinstance(each, Tree)]
    if len(trees) < len(functions):
        return features
    tested = {node.feature for tree in trees for node in tree.nodes if node.test != TestKind.LEAF}
    return [each for each in features if each[0] in tested]


def _find_most_alike(
    first: Sequence[Example], second: Sequence[Example], used: Tested
) -> tuple[Example, Example]:
    """Find the two examples, one of each list, that are nearest to each other by the features used."""
    first, second = (each[:: 1 + len(each) // MOST_COMPARED] for each in (first, second))
    values = np.array([[each.values[place] for place, _ in used] for each in (*first, *second)])
    distances = compute_pairwise_distances(values, [bound.kind for _, bound in used])
    between = distances[: len(first), len(first) :]
    one, two = np.unravel_index(int(np.argmin(between)), between.shape)
    return first[int(one)], second[int(two)]


def _format_reading(example: Example, used: Tested) -> str:
    return format_values([bound for _, bound in used], [example.values[place] for place, _ in used])


def _list_numbers(examples: Sequence[Example]) -> tuple[int, ...]:
    return tuple(each.number for each in examples)
