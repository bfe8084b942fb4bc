"""One teaching in one of the ways, looked at all along."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple
from functools import lru_cache
from typing import Any

import numpy as np

from understudy.analysis.evaluation import LENIENCE, measure_program
from understudy.model.kinds import Column
from understudy.model.lesson import Options
from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.sim.forage import Forage, kit
from understudy.sim.forage_settings import ForageSettings
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.hierarchy.forage_variants import LAYERS, OPTIONS
from understudy_lab.hierarchy.learning_curves import Curve
from understudy_lab.hierarchy.servo_variants import NAME, success, topics
from understudy_lab.hierarchy.thorough import Thorough
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_baseline import judge_expert
from understudy_lab.tasks.servo_teacher import SIDES
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.tasks.soccer import kit as soccer_kit
from understudy_lab.teachers.teacher import MakesBody, Patience, Topic

WORLDS, MOST_LOOKS = 30, 1_000
"""Unseen worlds of each look, and more looks than any teaching has."""
BESIDE = 10 * WORLDS
"""So many worlds the yardstick is put to at once, which takes it little longer than those of one look."""
MOST_CORRECTIONS, MOST_S = 150, 2_400.0
"""A teacher corrects a lesson until it comes right, or has had enough: about 400 examples, 40 minutes."""

FORAGING, SERVOING = tuple(LAYERS), ("one automaton", "two automata")


def taught(way: str, seed: int) -> dict[str, Any]:
    """One teaching: its learning curve, what it took in the end, and its lessons."""
    return _forager(way, seed) if way in FORAGING else _servo(way, seed)


def _forager(way: str, seed: int) -> dict[str, Any]:
    return _looked_at("forage", foraging_success, Library(kit), make_practice, seed, LAYERS[way], OPTIONS)


def _servo(way: str, seed: int) -> dict[str, Any]:
    chosen = topics(SIDES[seed % 2])[way]
    return _looked_at(NAME, success, Library(soccer_kit), lambda _, world: Soccer([world]), seed, chosen, {})


def unseen(seed: int, look: int) -> range:
    """The worlds of one look at the teaching of this seed: no two looks share one, nor with `worlds_of`."""
    first = WORLDS * (MOST_LOOKS * seed + look)
    return range(first, first + WORLDS)


def _looked_at(
    whole: str,
    success: Callable[[Library, range], float],
    library: Library,
    make: MakesBody,
    seed: int,
    chosen: Sequence[Topic],
    options: Mapping[str, Options],
) -> dict[str, Any]:
    curve = Curve(whole, lambda library, look: success(library, unseen(seed, look)))
    patience = Patience(MOST_CORRECTIONS, lessons=1, seconds=MOST_S)
    teacher = Thorough(
        library,
        make,
        seed,
        held=curve.held,
        options=options,
        progress=curve.went,
        patience=patience,
        person=curve.person,
    )
    curve.teacher = teacher
    teaching = teacher.teach(*chosen)
    return {
        "points": [astuple(point) for point in curve.points],
        "success": success(teaching.library, worlds_of(seed)),
        "examples": teaching.examples,
        "presses": sum(account.presses for account in teaching.accounts.values()),
        "teaching_seconds": round(teaching.seconds, 1),
        "lessons": lessons_of(teaching),
    }


def foraging_success(library: Library, seeds: range) -> float:
    """The share of worlds that are foraged in time."""
    first = seeds.start % BESIDE
    limits = _limits(seeds.start - first)[first : first + len(seeds)]
    return measure_program(Forage(seeds), link(library, "forage"), limit_s=limits).success


@lru_cache(maxsize=4)
def _limits(first: int) -> Column:
    """How long a robot may take, s, in this world and the next ones [BESIDE]."""
    expert = judge_expert(ForageSettings(), range(first, first + BESIDE))
    limits: Column = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    return limits
