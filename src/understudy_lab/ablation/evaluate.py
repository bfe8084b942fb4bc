"""One teaching of one variant, measured: taught in full, and its GoTo from what was shown alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from understudy.analysis.evaluation import LENIENCE, Outcomes, measure_program_outcomes
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.sim.forage import ForageSettings
from understudy.sim.world import World
from understudy_lab.ablation.feature_variants import kit
from understudy_lab.ablation.stochastic_leaves import add_chance_readings, randomize_leaves
from understudy_lab.ablation.variants import VARIANTS, Variant
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_expert import evaluate_expert
from understudy_lab.teachers.teacher import LessonPlan, Patience, ScriptedTeacher, TeachingResult

WORLDS, DRAWN_WORLDS = 40, 5
"""Unseen worlds each teaching is judged on; fewer where leaves draw, which is slow."""
WAY_S = 45.0
"""Longer than the longest way takes, s."""
PATIENCE = Patience(seconds=300.0)
"""Usual patience, but five minutes for an automaton at most: what cannot be taught would take hours."""


def measure_variant(name: str, seed: int) -> dict[str, Any]:
    """What one teaching of a variant comes to."""
    variant = VARIANTS[name]
    full = _teach(variant, seed, variant.topics)
    shown = _teach(variant, seed, [replace(variant.topics[0], tries=0)])  # no trying, so no correcting
    accounts = full.accounts.values()
    return {
        **evaluate_variant(full.library, variant, seed),
        "arrives": measure_arrivals(full.library, seed),
        "arrives_as_shown": measure_arrivals(shown.library, seed),
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
    """The share of ways, from where robots begin to the station and to food, that GoTo ends within reach of it."""
    seeds, arrived = worlds_of(seed)[:WORLDS], []
    for target in ("station", "nearest_food"):
        world = World(ForageSettings().scenario(), seeds)
        engine = Engine.of(world, link(library, "goto", {"A": target}))
        for _ in range(round(WAY_S / world.tick_s)):
            engine.tick()
        there = world.sense([("range", target)])["range", target] < ForageSettings().reach
        arrived += [engine.path(k)[-1] == "done" and bool(there[k]) for k in range(len(seeds))]
    return sum(arrived) / len(arrived)


def evaluate_variant(library: Library, variant: Variant, seed: int) -> Mapping[str, float]:
    """Success on the unseen worlds of a seed, and food per second as a share of the yardstick's: the median."""
    scenario, seeds = ForageSettings().scenario(), worlds_of(seed)[:WORLDS]
    if variant.drawn:
        seeds = seeds[:DRAWN_WORLDS]
    expert = _yardstick(seeds)
    if variant.drawn:
        scenario = add_chance_readings(scenario, list(library.taught))
        library = randomize_leaves(library, corrected=variant.drawn == "corrected votes")
    limits = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    taught = measure_program_outcomes(World(scenario, seeds), link(library, "forage"), limit_s=limits)
    ratio = taught.food_per_s / expert.food_per_s
    return {"success": taught.success, "relative_to_expert": round(float(np.nanmedian(ratio)), 4)}


@lru_cache(maxsize=4)
def _yardstick(seeds: range) -> Outcomes:
    return evaluate_expert(ForageSettings(), seeds)
