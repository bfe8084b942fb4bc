"""Checks of features, behaviors and kits, on the percepts of a body driven with random commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import product
from typing import Any, cast

from understudy.model.behaviors import Behavior
from understudy.model.features import AnyFeature, Feature, Percept, ReadingsView
from understudy.model.library import Kit
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.body import Body
from understudy.testing.laws import LawBroken, require
from understudy.testing.random_drive import (
    TICKS,
    are_same,
    check_body_parts,
    check_column,
    copy_percept,
    drive_randomly,
    name_reading,
    restore_afterwards,
)


def check_feature(feature: AnyFeature, body: Body, *, ticks: int = TICKS, seed: int = 0) -> None:
    """Check a feature on the percepts of a body driven with random commands.

    The feature must use only readings that the body has, return N float64 values of its kind, leave the readings
    unchanged, give the same values for the same readings, and compute each row independently of the others. Features
    of the automaton itself (flags, counters, timers, time in state) are accepted without a check.

    Parameters
    ----------
    feature
        The feature.
    body
        The body. The feature is checked with every combination of its targets. The checks send it random commands; a
        Rewindable body is restored afterwards.
    ticks
        Number of ticks for which the body is driven.
    seed
        Seed of the random commands.

    Raises
    ------
    LawBroken
        If the feature breaks a rule, or has parameters and the body has no targets.
    """
    if not isinstance(feature, Feature):
        return  # it reads the automaton, not the body
    part = f"feature {feature.name!r}"
    check_body_parts(body)
    bindings = list(product(body.targets, repeat=len(feature.parameters)))
    require(bool(bindings), part, "a feature of a target needs a body that has targets", "this one has none")
    with restore_afterwards(body):
        for percept in drive_randomly(body, ticks, seed):
            for targets in bindings:
                if (
                    feature.function is None
                ):  # a reading is looked up, which changes nothing and needs no others
                    column = _read_value(feature, targets, part, percept)
                    check_column(part, column, body.agents, feature.kind)
                    continue
                compute = partial(_call, part, feature.function, targets=targets)
                _check_computation(part, compute, percept, feature.kind)


def check_behavior(behavior: Behavior, body: Body, *, ticks: int = TICKS, seed: int = 0) -> None:
    """Check a behavior on the percepts of a body driven with random commands.

    The behavior must command only channels of the body, with N finite float64 values each, leave the readings
    unchanged, give the same commands for the same readings, and compute each row independently of the others.

    Parameters
    ----------
    behavior
        The behavior.
    body
        The body. The behavior is checked with every combination of its targets. The checks send it random commands; a
        Rewindable body is restored afterwards.
    ticks
        Number of ticks for which the body is driven.
    seed
        Seed of the random commands.

    Raises
    ------
    LawBroken
        If the behavior breaks a rule.
    """
    part = f"behavior {behavior.name!r}"
    check_body_parts(body)
    channels = {channel.name for channel in body.channels}
    _check_channels(part, behavior.command, channels)
    if behavior.function is None:
        return
    bindings = list(product(body.targets, repeat=len(behavior.parameters)))
    with restore_afterwards(body):
        for percept in drive_randomly(body, ticks, seed):
            for targets in bindings:
                commanded = sorted(_commanded(behavior, targets, percept))
                _check_channels(part, commanded, channels)
                for channel in commanded:
                    compute = partial(_channel, behavior, targets, channel)
                    _check_computation(part, compute, percept, None)


def check_kit(kit: Kit, body: Body, *, ticks: int = TICKS, seed: int = 0) -> None:
    """Check all features and behaviors of a kit on a body, as `check_feature` and `check_behavior` do.

    The targets of the kit must be targets of the body, too.

    Parameters
    ----------
    kit
        The kit.
    body
        The body. The checks send it random commands; a Rewindable body is restored afterwards.
    ticks
        Number of ticks for which the body is driven for each part.
    seed
        Seed of the random commands.

    Raises
    ------
    LawBroken
        If a part breaks a rule, or the kit has a target that the body does not have.
    """
    require(isinstance(kit, Kit), "kit", "it is a Kit", f"it is a {type(kit).__name__}")
    check_body_parts(body)
    unknown = sorted(set(kit.targets) - set(body.targets))
    law = "its targets are targets of the body"
    require(not unknown, "kit", law, f"it has {unknown} where there are {list(body.targets)}")
    for feature in kit.features.values():
        check_feature(feature, body, ticks=ticks, seed=seed)
    for behavior in kit.behaviors.values():
        check_behavior(behavior, body, ticks=ticks, seed=seed)


def _call(part: str, function: Callable[..., Any], percept: Percept, targets: tuple[str, ...]) -> Any:
    """Call the function of a feature or behavior; raise LawBroken if it fails."""
    try:
        return function(ReadingsView(percept), *(ReadingsView(percept, target) for target in targets))
    except Exception as error:
        law = "its function works for all that the body reads, and for any number of agents"
        found = f"it failed: {type(error).__name__}: {error}"
        raise LawBroken(part=part, law=law, found=found) from error


def _read_value(feature: Feature, targets: tuple[str, ...], part: str, percept: Percept) -> Column:
    key = (str(feature.reading), targets[0] if targets else None)
    require(key in percept, part, "a feature reads what the body offers", f"there is no {name_reading(key)}")
    return percept[key]


def _commanded(behavior: Behavior, targets: tuple[str, ...], percept: Percept) -> Mapping[str, Column]:
    if behavior.function is None:
        return {}
    part = f"behavior {behavior.name!r}"
    commanded = _call(part, behavior.function, percept, targets)
    law = "it returns a column for each channel"
    require(isinstance(commanded, Mapping), part, law, f"it returned {commanded!r:.60}")
    return cast("Mapping[str, Column]", commanded)


def _channel(behavior: Behavior, targets: tuple[str, ...], channel: str, percept: Percept) -> Column:
    return _commanded(behavior, targets, percept)[channel]


def _check_computation(
    part: str, compute: Callable[[Percept], Column], percept: Percept, kind: Kind | None
) -> None:
    before = copy_percept(percept)
    column = compute(percept)
    rows = len(next(iter(percept.values())))
    check_column(part, column, rows, kind)
    kept = all(are_same(percept[key], before[key]) for key in before)
    require(kept, part, "it leaves the readings it is given untouched", "it changed them")
    require(
        are_same(column, compute(percept)), part, "the same readings give the same values", "they differed"
    )
    for row in range(rows):
        alone = compute({key: values[row : row + 1] for key, values in percept.items()})
        if not are_same(alone, column[row : row + 1]):
            found = f"agent {row} has {column[row]} among others and {alone} alone"
            raise LawBroken(part=part, law="each agent's value is its own", found=found)


def _check_channels(part: str, commands: Iterable[str], known: set[str]) -> None:
    unknown = sorted(set(commands) - known)
    law = "it commands channels of the body"
    require(not unknown, part, law, f"it commands {unknown} where there are {sorted(known)}")
