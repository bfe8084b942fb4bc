"""Leaves that draw: each time a state is asked, the next one is drawn by the votes of the leaf's examples.

What is drawn is a reading of the body, a random number of each automaton's own, keyed by world and tick.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from types import MappingProxyType

import msgspec

from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Continuous
from understudy.model.lesson import Example, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, PathStep, Tree
from understudy.sim.scenario.schema import RandomSensor, Scenario


@dataclass(frozen=True)
class StochasticLeaves:
    """A tree whose leaves draw: by leaf, the outcomes with the shares up to each. The last value is what is drawn."""

    tree: Tree
    shares: Mapping[int, Sequence[tuple[int, float]]]

    def decide(self, values: Sequence[float]) -> int:
        """The next state's index, or STAY."""
        _, leaf = self.path(values)
        drawn = (outcome for outcome, upto in self.shares.get(leaf, ()) if values[-1] < upto)
        return next(drawn, STAY)

    def path(self, values: Sequence[float]) -> tuple[tuple[PathStep, ...], int]:
        """The steps to the leaf, and the leaf."""
        return self.tree.path(values[:-1])


def randomize_leaves(library: Library, *, corrected: bool) -> Library:
    """The library with leaves that draw by their examples, a watched one a tenth of a press-made one.

    `corrected`: by the press-made ones, and each state counts once more than it was shown (Laplace's correction;
    Provost and Domingos 2003).
    """
    automata = [
        make_stochastic_automaton(taught, corrected=corrected)
        for taught in library.taught.values()
        if taught.lesson is not None
    ]
    return Library.of(library.kit, *automata)


def make_stochastic_automaton(taught: TrainedAutomaton, *, corrected: bool) -> Automaton:
    """A learned automaton with leaves that draw."""
    automaton, lesson = taught.automaton, taught.lesson or Lesson(taught.automaton)
    name = name_chance_reading(automaton.name)
    feature = BoundFeature(Feature(name, Continuous(), reading=name))
    shown = group_examples_by_state(lesson)
    transitions = {
        state: StochasticLeaves(tree, _shares(tree, shown[state], automaton.state_names, corrected=corrected))
        for state, tree in automaton.transitions.items()
        if isinstance(tree, Tree)
    }
    return replace(
        automaton, features=(*automaton.features, feature), transitions=MappingProxyType(transitions)
    )


def _shares(
    tree: Tree, examples: Sequence[Example], names: Sequence[str], *, corrected: bool
) -> dict[int, tuple[tuple[int, float], ...]]:
    """By leaf, each state with the share of the votes up to it; a leaf without votes has none, and stays."""
    weights = (1, 0) if corrected else (10, 1)  # of press-made examples and watched ones, as the learner's
    votes: dict[int, list[int]] = {leaf: [int(corrected)] * len(names) for _, leaf in tree.leaves()}
    for example in examples:
        leaf = tree.path(example.values)[1]
        if leaf in votes:
            votes[leaf][names.index(example.next)] += weights[not example.pressed]
    found = {}
    for leaf, counts in votes.items():
        voted = [(state, count) for state, count in enumerate(counts) if count]
        upto = accumulate(count for _, count in voted)
        found[leaf] = tuple(
            (state, share / sum(counts)) for (state, _), share in zip(voted, upto, strict=True)
        )
    return found


def name_chance_reading(automaton: str) -> str:
    """The reading that an automaton draws by."""
    return f"chance_{automaton}"


def add_chance_readings(scenario: Scenario, automata: Sequence[str]) -> Scenario:
    """The scenario, with a random number for each of these automata at every tick."""
    chances = tuple(RandomSensor(name=name_chance_reading(name)) for name in automata)
    types = {
        name: msgspec.structs.replace(robot, sensors=(*robot.sensors, *chances))
        for name, robot in scenario.types.items()
    }
    return msgspec.structs.replace(scenario, types=types)
