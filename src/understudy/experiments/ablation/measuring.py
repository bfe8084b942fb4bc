"""One teaching of one variant, measured: taught in full, and from what was shown alone."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from understudy.evaluation import LENIENCE, Outcomes, judge_expert, measure_program
from understudy.experiments.ablation.drawing import drawn_by_votes, with_chances
from understudy.experiments.ablation.seeing import kit
from understudy.experiments.ablation.variants import SHOWN_ONLY, VARIANTS, Variant
from understudy.experiments.forage.teaching import make_practice, worlds_of
from understudy.experiments.lessons import lessons_of
from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.training.demonstrators.teacher import Teacher, Teaching
from understudy.worlds.forage_settings import ForageSettings
from understudy.worlds.world import World

WORLDS = 40
"""Unseen worlds each teaching is judged on."""


def measured(name: str, seed: int) -> dict[str, Any]:
    """What one teaching of a variant comes to."""
    variant = VARIANTS[name]
    full = _teach(variant, seed, shown_only=False)
    shown = _teach(variant, seed, shown_only=True)
    return {
        **_account(full, variant, seed),
        "shown": _account(shown, variant, seed),
        "lessons": lessons_of(full),
    }


def _teach(variant: Variant, seed: int, *, shown_only: bool) -> Teaching:
    topics = tuple(map(SHOWN_ONLY, variant.topics)) if shown_only else variant.topics
    teacher = Teacher(
        Library(kit),
        make_practice,
        seed,
        options=variant.options,
        reaction=variant.reaction,
        person=variant.person,
    )
    return teacher.teach(*topics)


def _account(teaching: Teaching, variant: Variant, seed: int) -> dict[str, Any]:
    accounts = teaching.accounts.values()
    return {
        **judged(teaching.library, variant, seed),
        "examples": teaching.examples,
        "presses": sum(account.presses for account in accounts),
        "teaching_seconds": round(teaching.seconds, 1),
        "taught_again": sum(account.lessons - 1 for account in accounts),
    }


def judged(library: Library, variant: Variant, seed: int) -> Mapping[str, float]:
    """Success on the unseen worlds of a seed, and food per second as a share of the yardstick's: the median."""
    expert, scenario, seeds = _yardstick(seed), ForageSettings().scenario(), worlds_of(seed)[:WORLDS]
    if variant.drawn:
        scenario = with_chances(scenario, list(library.taught))
        library = drawn_by_votes(library, corrected=variant.drawn == "corrected votes")
    limits = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    taught = measure_program(World(scenario, seeds), link(library, "forage"), limit_s=limits)
    ratio = taught.food_per_s / expert.food_per_s
    return {"success": taught.success, "relative_to_expert": round(float(np.nanmedian(ratio)), 4)}


@lru_cache(maxsize=4)
def _yardstick(seed: int) -> Outcomes:
    return judge_expert(ForageSettings(), worlds_of(seed)[:WORLDS])
