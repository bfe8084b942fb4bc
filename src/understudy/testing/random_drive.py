"""Bodies under check: driven with random commands, read, compared, and put back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import isfinite

import numpy as np

from understudy.errors import KindError, join_names
from understudy.model.features import Percept
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.body import BODY_ATTRIBUTES, Body, Channel, Commands, Rewindable, list_reading_keys
from understudy.testing.laws import LawBroken, require

TICKS = 60


def check_body_parts(body: Body) -> None:
    """Check that a body has all that a body has."""
    missing = [name for name in BODY_ATTRIBUTES if not hasattr(body, name)]
    law = f"a body has {join_names(BODY_ATTRIBUTES)}"
    require(not missing, f"body {type(body).__name__}", law, f"it has no {join_names(missing)}")


def are_same(one: Column, other: Column) -> bool:
    """Return whether two columns are equal bit for bit; absent values are equal."""
    return one.shape == other.shape and np.array_equal(one, other, equal_nan=True)


def require_same_percepts(part: str, law: str, one: Sequence[Percept], other: Sequence[Percept]) -> None:
    """Check that two sequences of percepts are equal; the law is broken at the first tick that differs."""
    for tick, (percept, again) in enumerate(zip(one, other, strict=True)):
        for key, column in percept.items():
            if not are_same(column, again[key]):  # said only then: columns take long to spell
                found = f"{name_reading(key)} is {column} and {again[key]} at tick {tick}"
                raise LawBroken(part=part, law=law, found=found)


def name_reading(key: tuple[str, str | None]) -> str:
    """Name a reading for a sentence."""
    return f"reading {key[0]!r}" if key[1] is None else f"reading {key[0]!r} of {key[1]!r}"


def check_column(part: str, column: object, rows: int, kind: Kind | None) -> None:
    """Check that a column has a float64 per agent, of a kind, or finite without one."""
    shape = getattr(column, "shape", None)
    law = "its values are one column of floats, a number per agent"
    require(isinstance(column, np.ndarray), part, law, f"they are {type(column).__name__}")
    values = np.asarray(column)
    require(shape == (rows,) and values.dtype == np.float64, part, law, f"they are {values.dtype} {shape}")
    if kind is None:
        require(bool(np.isfinite(values).all()), part, "commands are finite", f"they are {values}")
        return
    for row, value in enumerate(values.tolist()):
        try:
            kept = kind.check(value, where=part)
        except KindError as broken:
            raise LawBroken(
                part=part, law=f"its values are {kind}", found=f"agent {row}: {broken}"
            ) from broken
        same = kept == value or (kept != kept and value != value)
        require(same, part, f"its values are {kind}", f"agent {row} has {value}, which is {kept} there")


def draw_commands(body: Body, generators: Sequence[np.random.Generator], rows: int) -> Commands:
    """Draw random commands in [-1, 1], or in the limits of a channel, for one tick, at rest in about half of the rows.

    Each world's commands come from its own generator, so that they do not depend on the other worlds.
    """
    drawn = [generator.uniform(-1, 1, (len(body.channels) + 1, rows)) for generator in generators]
    commands = {
        channel.name: np.concatenate(
            [np.where(world[-1] < 0.5, _fit_limits(channel, world[at]), channel.rest) for world in drawn]
        )
        for at, channel in enumerate(body.channels)
    }
    return commands


def _fit_limits(channel: Channel, drawn: Column) -> Column:
    """Stretch numbers in [-1, 1] over the limits of a channel, if both are finite, and round them if it asks so."""
    if isfinite(channel.least) and isfinite(channel.most):
        drawn = channel.least + (channel.most - channel.least) * (drawn + 1.0) / 2.0
    drawn = np.clip(drawn, channel.least, channel.most)
    return np.rint(drawn) if channel.whole else drawn


def drive_randomly(body: Body, ticks: int, seed: int) -> Iterator[Percept]:
    """Yield the percept of each tick of a body that is driven with random commands."""
    generators, keys = [np.random.default_rng(seed)], list_reading_keys(body)
    for _ in range(ticks):
        yield body.sense(keys)
        body.act(draw_commands(body, generators, body.agents))


def record_percepts(body: Body, ticks: int, seeds: Sequence[int], rows: int) -> list[Percept]:
    """Record the percepts of worlds driven with random commands, each world's by its own seed."""
    generators, keys = [np.random.default_rng(seed) for seed in seeds], list_reading_keys(body)
    percepts: list[Percept] = []
    for _ in range(ticks):
        percepts.append(copy_percept(body.sense(keys)))
        body.act(draw_commands(body, generators, rows))
    return percepts


def copy_percept(percept: Percept) -> dict[tuple[str, str | None], Column]:
    """Copy a percept with its columns."""
    return {key: column.copy() for key, column in percept.items()}


@contextmanager
def restore_afterwards(body: Body) -> Iterator[None]:
    """Put a rewindable body back at the end."""
    before = body.snapshot() if isinstance(body, Rewindable) else None
    try:
        yield
    finally:
        if before is not None and isinstance(body, Rewindable):
            body.restore(before)
