"""Evaluation of one teaching of one variant: fully taught, and its GoTo from demonstrations alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import accumulate
from types import MappingProxyType
from typing import Any

import msgspec
import numpy as np

from understudy.judging.baseline import LENIENCE
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.outcomes import Outcomes, measure_success
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, PathStep, Tree
from understudy.model.value_kinds import Continuous
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.forage import ForageSettings
from understudy.sim.scenario.schema import RandomSensor, Scenario
from understudy.sim.world import World
from understudy_lab.ablation.variants import VARIANTS, Variant, kit
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_expert import evaluate_expert
from understudy_lab.teachers.teacher import LessonPlan, Patience, ScriptedTeacher, TeachingResult


@dataclass(frozen=True)
class StochasticLeaves:
    """A tree with random leaves: each holds outcomes with cumulative shares; the last input is the random number."""

    tree: Tree
    shares: Mapping[int, Sequence[tuple[int, float]]]

    def decide(self, values: Sequence[float]) -> int:
        """Return the next state's index, or STAY."""
        _, leaf = self.path(values)
        drawn = (outcome for outcome, upto in self.shares.get(leaf, ()) if values[-1] < upto)
        return next(drawn, STAY)

    def path(self, values: Sequence[float]) -> tuple[tuple[PathStep, ...], int]:
        """Return the steps to the leaf, and the leaf."""
        return self.tree.path(values[:-1])


def randomize_leaves(library: Library, *, corrected: bool) -> Library:
    """Return the library with leaves that draw by their examples; a watched one counts a tenth of a press-made one.

    With `corrected`, only press-made examples count, and each state gets one more vote (Laplace's correction; Provost
    and Domingos 2003).
    """
    automata = [
        make_stochastic_automaton(taught, corrected=corrected)
        for taught in library.taught.values()
        if taught.lesson is not None
    ]
    return Library.from_automata(library.kit, *automata)


def make_stochastic_automaton(taught: TrainedAutomaton, *, corrected: bool) -> Automaton:
    """Return a learned automaton with leaves that draw."""
    automaton, lesson = taught.automaton, taught.lesson or Lesson(taught.automaton)
    name = name_chance_reading(automaton.name)
    feature = BoundFeature(Feature(name, Continuous(), reading=name))
    examples_by_state = group_examples_by_state(lesson)
    transitions = {
        state: StochasticLeaves(
            tree, _shares(tree, examples_by_state[state], automaton.state_names, corrected=corrected)
        )
        for state, tree in automaton.transitions.items()
        if isinstance(tree, Tree)
    }
    return replace(
        automaton, features=(*automaton.features, feature), transitions=MappingProxyType(transitions)
    )


def _shares(
    tree: Tree, examples: Sequence[Example], names: Sequence[str], *, corrected: bool
) -> dict[int, tuple[tuple[int, float], ...]]:
    """Return the states that a leaf may answer, each with the cumulative share of its votes, by the leaf's index.

    A leaf without votes has no states; the automaton stays there. `corrected` counts press-made examples only, and adds
    one vote to every state (Laplace); otherwise watched examples have a tenth of a press's vote.
    """
    weights = (1, 0) if corrected else (10, 1)  # of press-made examples and watched ones, as the learner's
    votes: dict[int, list[int]] = {leaf: [int(corrected)] * len(names) for _, leaf in tree.leaves()}
    for example in examples:
        leaf = tree.path(example.values)[1]
        if leaf in votes:
            votes[leaf][names.index(example.next)] += weights[not example.is_from_press]
    shares = {}
    for leaf, counts in votes.items():
        voted = [(state, count) for state, count in enumerate(counts) if count]
        upto = accumulate(count for _, count in voted)
        shares[leaf] = tuple(
            (state, share / sum(counts)) for (state, _), share in zip(voted, upto, strict=True)
        )
    return shares


def name_chance_reading(automaton: str) -> str:
    """Return the name of the random sensor value that an automaton draws by."""
    return f"chance_{automaton}"


def add_chance_readings(scenario: Scenario, automata: Sequence[str]) -> Scenario:
    """Return the scenario with a random sensor for each of these automata."""
    chances = tuple(RandomSensor(name=name_chance_reading(name)) for name in automata)
    types = {
        name: msgspec.structs.replace(robot, sensors=(*robot.sensors, *chances))
        for name, robot in scenario.types.items()
    }
    return msgspec.structs.replace(scenario, types=types)


WORLDS, DRAWN_WORLDS = 40, 5
"""The number of test worlds; fewer for randomized leaves, which are slow."""
WAY_S = 45.0
"""A time limit in s that no trip reaches."""
PATIENCE = Patience(seconds=300.0)
"""The usual patience with at most five minutes per automaton, because a hopeless lesson would take hours."""


def measure_variant(name: str, seed: int) -> dict[str, Any]:
    """Return all measurements of one teaching of a variant."""
    variant = VARIANTS[name]
    full = _teach(variant, seed, variant.topics)
    untried = _teach(variant, seed, [replace(variant.topics[0], tries=0)])  # no trying, so no correcting
    accounts = full.accounts.values()
    return {
        **evaluate_variant(full.library, variant, seed),
        "arrives": measure_arrivals(full.library, seed),
        "arrives_as_shown": measure_arrivals(untried.library, seed),
        "examples": full.examples,
        "presses": sum(account.presses for account in accounts),
        "teaching_seconds": round(full.seconds, 1),
        "taught_again": sum(account.lessons - 1 for account in accounts),
        "lessons": lessons_of(full),
    }


def _teach(variant: Variant, seed: int, topics: Sequence[LessonPlan]) -> TeachingResult:
    teacher = ScriptedTeacher(
        Library(kit),
        make_practice,
        seed,
        options=variant.options,
        reaction=variant.reaction,
        person=variant.person,
        patience=PATIENCE,
    )
    return teacher.teach(*topics)


def measure_arrivals(library: Library, seed: int) -> float:
    """Return the share of trips to the station and to food that GoTo ends within reach of the target."""
    seeds, arrived = worlds_of(seed)[:WORLDS], []
    for target in ("station", "nearest_food"):
        world = World(ForageSettings().scenario(), seeds)
        engine = Engine.from_program(world, link(library, "goto", {"A": target}))
        for _ in range(round(WAY_S / world.tick_s)):
            engine.tick()
        there = world.sense([("range", target)])["range", target] < ForageSettings().reach
        arrived += [engine.path(k)[-1] == "done" and bool(there[k]) for k in range(len(seeds))]
    return sum(arrived) / len(arrived)


def evaluate_variant(library: Library, variant: Variant, seed: int) -> Mapping[str, float]:
    """Return the success on unseen worlds, and the median food per second relative to the baseline."""
    scenario, seeds = ForageSettings().scenario(), worlds_of(seed)[:WORLDS]
    if variant.drawn:
        seeds = seeds[:DRAWN_WORLDS]
    expert = _yardstick(seeds)
    if variant.drawn:
        scenario = add_chance_readings(scenario, list(library.taught))
        library = randomize_leaves(library, corrected=variant.drawn == "corrected votes")
    limits = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    run = ProgramRun(World(scenario, seeds), link(library, "forage"), library, {})
    taught = measure_success(run, limits)
    ratio = taught.food_per_s / expert.food_per_s
    return {"success": taught.success, "relative_to_expert": round(float(np.nanmedian(ratio)), 4)}


@lru_cache(maxsize=4)
def _yardstick(seeds: range) -> Outcomes:
    return evaluate_expert(ForageSettings(), seeds)
