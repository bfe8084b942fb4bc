"""A survey of a lesson: everything that pieces of advice are made from, made once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.cross_validation import Learner, Trial, learners, trials
from understudy.coaching.distances import Nearness
from understudy.coaching.situation_sampling import completed, imagined, vectors_of
from understudy.coaching.situation_text import (
    Cells,
    Wording,
    box_of,
    cells_of,
    situation,
    usual_of,
    wordings,
)
from understudy.model.automaton import Transition
from understudy.model.lesson import Example, Lesson
from understudy.model.tree_regions import Box

ENOUGH = 3
"""So many presses that said something are the least to say anything about what is missing."""


@dataclass(frozen=True)
class Survey:
    """A lesson, what was learned from it, and by state what teaches it and what it would be without some of that.

    `situations` [M, F] are feature vectors the robot may come into, `cells` [M, F] the same in people's words.
    """

    lesson: Lesson
    transitions: Mapping[str, Transition]
    words: tuple[Wording, ...]
    situations: NDArray[np.float64]
    cells: NDArray[np.int64]
    learners: Mapping[str, Learner]
    trials: Mapping[str, Sequence[Trial]]

    @classmethod
    def of(
        cls,
        lesson: Lesson,
        transitions: Mapping[str, Transition],
        situations: NDArray[np.float64] | None = None,
    ) -> Survey:
        """Look a lesson over; `situations` [M, F] are such as the robot may come into (None: they are imagined).

        What they say of the automaton's own features is taken from examples instead.
        """
        seen = vectors_of(lesson)
        if situations is None:
            words = wordings(lesson.automaton.features, seen)
            situations = imagined(lesson, seen)
        else:
            situations = completed(lesson, situations, seen)
            words = wordings(lesson.automaton.features, np.concatenate([seen, situations]))
        found = learners(lesson)
        return cls(
            lesson,
            transitions,
            words,
            situations,
            cells_of(words, situations),
            found,
            trials(lesson, found),
        )

    @property
    def shown(self) -> int:
        """How many examples the demonstrator said: directives and confirmations."""
        return sum(example.shown for learner in self.learners.values() for example in learner.examples)

    @property
    def scant(self) -> bool:
        """Whether too little was shown to say what is missing."""
        return self.shown < ENOUGH

    def transition(self, state: str) -> Transition:
        """What a state of `learners` learned."""
        return self.transitions[state]

    def nearness(self, state: str) -> Nearness:
        """How near situations are to one another in a state."""
        return Nearness(self.words, self.transitions.get(state))

    def said(self, state: str, cells: Cells) -> str:
        """A situation of a state in words; what is usual in its examples goes without saying."""
        rows = self.learners[state].shown.values
        return situation(self.words, cells, usual_of(cells_of(self.words, rows), self.words))

    def where(self, state: str, example: Example) -> tuple[Box, str]:
        """The situation of an example, and how to say it: " when A is close"; nothing where it may be any."""
        row = cells_of(self.words, np.array([example.values], np.float64).reshape(1, -1))[0]
        cells = {
            feature: frozenset({int(cell)})
            for feature, cell in enumerate(row)
            if self.words[feature].cells != (cell,)  # it tells nothing: all values that were seen are one
        }
        said = self.said(state, cells)
        return box_of(self.words, cells), f" when {said}" if said else ""

    def place(self, state: str) -> str:
        """Where a state's advice belongs: the state, or anywhere in a stateless automaton."""
        return "" if self.lesson.automaton.stateless else state
