"""Drives for tests: a stick that follows aims with some inertia and noise, and what it is to be explained by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Column, Continuous
from understudy.records.record import Episode, Record
from understudy.runtime.body import Channel, Reading

TICK_S = 0.1


def follow(
    aims: Sequence[Sequence[float]], *, gain: float = 0.6, noise: float = 0.02, seed: int = 0
) -> Column:
    """The stick [T, C] that moves a share of the way to each aim in each tick, with noise."""
    random, place, rows = np.random.default_rng(seed), np.zeros(len(aims[0])), []
    for aim in aims:
        place = place + gain * (np.asarray(aim) - place)
        rows.append(place + noise * random.standard_normal(len(place)))
    return np.array(rows)


def make_drive(
    commands: Column,
    values: Mapping[ReadingKey, Column],
    *,
    readings: Sequence[Reading] = (),
    channels: Sequence[Channel] = (Channel("drive"), Channel("turn")),
    lengths: Sequence[int] = (),
) -> Record:
    """A drive with these commands [T, C] and readings; episodes have these lengths."""
    edges = np.cumsum([0, *(lengths or [len(commands)])]).tolist()
    return Record(
        np.arange(len(commands), dtype=np.float64) * TICK_S,
        values,
        commands,
        tuple(channels),
        tuple(readings)
        or tuple(Reading(name, Continuous(), of_targets=target is not None) for name, target in values),
        tuple({target: None for _, target in values if target is not None}),
        TICK_S,
        tuple(Episode("drive.csv", first, end) for first, end in pairwise(edges)),
    )
