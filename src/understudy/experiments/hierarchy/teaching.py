"""One teaching in one of the ways, looked at all along."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple
from functools import lru_cache
from typing import Any

import numpy as np

from understudy.evaluation import LENIENCE, judge_expert, measure_program
from understudy.experiments.forage.teaching import make_practice, worlds_of
from understudy.experiments.hierarchy.curves import Curve
from understudy.experiments.hierarchy.foraging import LAYERS, OPTIONS
from understudy.experiments.hierarchy.servoing import NAME, success, topics
from understudy.experiments.hierarchy.thorough import Thorough
from understudy.experiments.lessons import lessons_of
from understudy.model.kinds import Column
from understudy.model.lesson import Options
from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.training.demonstrators.servo import SIDES
from understudy.training.demonstrators.teacher import MakesBody, Patience, Topic
from understudy.worlds.forage import Forage, kit
from understudy.worlds.forage_settings import ForageSettings
from understudy.worlds.soccer import Soccer
from understudy.worlds.soccer import kit as soccer_kit

WORLDS = 30
"""Unseen worlds of each look."""
MOST_CORRECTIONS, MOST_S = 150, 2_400.0
"""A teacher corrects a lesson until it comes right, or has had enough: about 400 examples, 40 minutes."""

FORAGING, SERVOING = tuple(LAYERS), ("one automaton", "two automata")


def taught(way: str, seed: int) -> dict[str, Any]:
    """One teaching: its learning curve, what it took in the end, and its lessons."""
    return _forager(way, seed) if way in FORAGING else _servo(way, seed)


def _forager(way: str, seed: int) -> dict[str, Any]:
    curve = Curve("forage", lambda library: foraging_success(library, seed))
    return _looked_at(curve, Library(kit), make_practice, seed, LAYERS[way], OPTIONS)


def _servo(way: str, seed: int) -> dict[str, Any]:
    curve = Curve(NAME, lambda library: success(library, worlds_of(seed)[:WORLDS]))
    chosen = topics(SIDES[seed % 2])[way]
    return _looked_at(curve, Library(soccer_kit), lambda practice, world: Soccer([world]), seed, chosen, {})


def _looked_at(
    curve: Curve,
    library: Library,
    make: MakesBody,
    seed: int,
    chosen: Sequence[Topic],
    options: Mapping[str, Options],
) -> dict[str, Any]:
    patience = Patience(MOST_CORRECTIONS, lessons=1, seconds=MOST_S)
    teacher = Thorough(
        library, make, seed, options=options, progress=curve.look, patience=patience, person=curve.person
    )
    curve.teacher = teacher
    teaching = teacher.teach(*chosen)
    return {
        "points": [astuple(point) for point in curve.points],
        "examples": teaching.examples,
        "presses": sum(account.presses for account in teaching.accounts.values()),
        "teaching_seconds": round(teaching.seconds, 1),
        "lessons": lessons_of(teaching),
    }


def foraging_success(library: Library, seed: int) -> float:
    """The share of unseen worlds that are foraged in time."""
    world = Forage(worlds_of(seed)[:WORLDS])
    return measure_program(world, link(library, "forage"), limit_s=_limits(seed)).success


@lru_cache(maxsize=4)
def _limits(seed: int) -> Column:
    expert = judge_expert(ForageSettings(), worlds_of(seed)[:WORLDS])
    limits: Column = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    return limits
