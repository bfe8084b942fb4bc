"""Checks that features, behaviors, bodies and worlds of your own meet their contracts.

    check_feature(my_feature, body)
    check_behavior(my_behavior, body)
    check_body(body)
    check_world(lambda seeds: MyWorld(seeds))

Each check raises LawBroken, whose message names the part and the rule that it breaks, or returns None. The checks
send commands to the body; a Rewindable body is restored afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import product
from math import isfinite
from typing import Any, cast

import numpy as np

from understudy.errors import KindError, UnderstudyError, join_names
from understudy.model.behaviors import Behavior
from understudy.model.features import AnyFeature, Feature, Percept, ReadingsView
from understudy.model.kinds import Column, Kind
from understudy.runtime.body import BODY_ATTRIBUTES, Body, Channel, Commands, Rewindable, list_reading_keys

TICKS = 60
__all__ = ["LawBroken", "check_behavior", "check_body", "check_feature", "check_world"]


class LawBroken(UnderstudyError, json_type="LawBroken"):
    """A feature, behavior, body or world that breaks a rule of its contract.

    Parameters
    ----------
    part
        The part that was checked, such as "feature 'gap'".
    law
        The rule that it breaks.
    found
        The behavior that was observed instead.
    """

    def __init__(self, *, part: str, law: str, found: str) -> None:
        self.part, self.law, self.found = part, law, found
        super().__init__(f"{part} breaks a law: {law}; {found}")


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
    _check_parts(body)
    bindings = list(product(body.targets, repeat=len(feature.parameters)))
    _require(bool(bindings), part, "a feature of a target needs a body that has targets", "this one has none")
    with _put_back(body):
        for percept in _percepts(body, ticks, seed):
            for targets in bindings:
                if (
                    feature.function is None
                ):  # a reading is looked up, which changes nothing and needs no others
                    column = _read_value(feature, targets, part, percept)
                    _check_column(part, column, body.agents, feature.kind)
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
    _check_parts(body)
    channels = {channel.name for channel in body.channels}
    _check_channels(part, behavior.command, channels)
    if behavior.function is None:
        return
    bindings = list(product(body.targets, repeat=len(behavior.parameters)))
    with _put_back(body):
        for percept in _percepts(body, ticks, seed):
            for targets in bindings:
                commanded = sorted(_commanded(behavior, targets, percept))
                _check_channels(part, commanded, channels)
                for channel in commanded:
                    compute = partial(_channel, behavior, targets, channel)
                    _check_computation(part, compute, percept, None)


def check_body(body: Body, *, ticks: int = TICKS, seed: int = 0) -> None:
    """Check that a body meets its contract, driven with random commands.

    The body must return N float64 values of the declared kind for each reading, the same if it is read twice and if a
    reading is asked for alone. It must leave the commands that it gets unchanged, and refuse unknown readings,
    unknown channels, columns of the wrong length and NaN with an UnderstudyError. A Rewindable body must also
    continue from a snapshot exactly as before, refuse invalid snapshots, and put channels without a command at rest.

    Parameters
    ----------
    body
        The body. A Rewindable body is restored afterwards.
    ticks
        Number of ticks for which it is driven.
    seed
        Seed of the random commands.

    Raises
    ------
    LawBroken
        If the body breaks a rule.
    """
    part = f"body {type(body).__name__}"
    _check_parts(body)
    _check_declarations(part, body)
    with _put_back(body):
        for percept in _percepts(body, ticks, seed):
            _check_percept(part, body, percept)
        _check_refusals(part, body)
        _check_commands_untouched(part, body, seed)
    if isinstance(body, Rewindable):
        _check_rewinding(part, body, ticks, seed)


def check_world(
    make: Callable[[Sequence[int]], Body], *, seeds: Sequence[int] = (0, 1, 2, 7, 40), ticks: int = TICKS
) -> None:
    """Check that a simulated world meets the contract of a body and can be repeated by its seed.

    In addition to `check_body`, the same seeds must give the same run, and each world must run alone exactly as it
    does together with others.

    Parameters
    ----------
    make
        Function that takes seeds and returns a body with one world per seed. All worlds have the same number of rows,
        in the order of the seeds.
    seeds
        Seeds of the worlds.
    ticks
        Number of ticks for which each world is driven.

    Raises
    ------
    LawBroken
        If the world breaks a rule.
    """
    body = make(seeds)
    _check_parts(body)
    part = f"world {type(body).__name__}"
    rows, rest = divmod(body.agents, len(seeds))
    _require(
        not rest, part, "each seed's world has as many rows", f"{len(seeds)} seeds gave {body.agents} rows"
    )
    check_body(body, ticks=ticks)
    among = _record(make(seeds), ticks, seeds, rows)
    _require_same(part, "the same seeds give the same run", among, _record(make(seeds), ticks, seeds, rows))
    for index, seed in enumerate(seeds):
        alone = _record(make([seed]), ticks, [seed], rows)
        own = slice(index * rows, (index + 1) * rows)
        cut = [{key: column[own] for key, column in percept.items()} for percept in among]
        _require_same(part, f"world {seed} runs alone as it does among others", cut, alone)


# What the checks are made of.


def _require(kept: bool, part: str, law: str, found: str) -> None:
    if not kept:
        raise LawBroken(part=part, law=law, found=found)


def _check_parts(body: Body) -> None:
    missing = [name for name in BODY_ATTRIBUTES if not hasattr(body, name)]
    law = f"a body has {join_names(BODY_ATTRIBUTES)}"
    _require(not missing, f"body {type(body).__name__}", law, f"it has no {join_names(missing)}")


def _call(part: str, function: Callable[..., Any], percept: Percept, targets: tuple[str, ...]) -> Any:
    """Call the function of a feature or behavior; raise LawBroken if it fails."""
    try:
        return function(ReadingsView(percept), *(ReadingsView(percept, target) for target in targets))
    except Exception as error:
        law = "its function works for all that the body reads, and for any number of agents"
        found = f"it failed: {type(error).__name__}: {error}"
        raise LawBroken(part=part, law=law, found=found) from error


def _same(one: Column, other: Column) -> bool:
    return one.shape == other.shape and np.array_equal(one, other, equal_nan=True)


def _require_same(part: str, law: str, one: Sequence[Percept], other: Sequence[Percept]) -> None:
    for tick, (percept, again) in enumerate(zip(one, other, strict=True)):
        for key, column in percept.items():
            if not _same(column, again[key]):  # said only then: columns take long to spell
                found = f"{_spelled(key)} is {column} and {again[key]} at tick {tick}"
                raise LawBroken(part=part, law=law, found=found)


def _spelled(key: tuple[str, str | None]) -> str:
    return f"reading {key[0]!r}" if key[1] is None else f"reading {key[0]!r} of {key[1]!r}"


def _drawn(body: Body, generators: Sequence[np.random.Generator], rows: int) -> Commands:
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


def _percepts(body: Body, ticks: int, seed: int) -> Iterator[Percept]:
    generators, keys = [np.random.default_rng(seed)], list_reading_keys(body)
    for _ in range(ticks):
        yield body.sense(keys)
        body.act(_drawn(body, generators, body.agents))


def _record(body: Body, ticks: int, seeds: Sequence[int], rows: int) -> list[Percept]:
    generators, keys = [np.random.default_rng(seed) for seed in seeds], list_reading_keys(body)
    percepts: list[Percept] = []
    for _ in range(ticks):
        percepts.append(_copied(body.sense(keys)))
        body.act(_drawn(body, generators, rows))
    return percepts


def _copied(percept: Percept) -> dict[tuple[str, str | None], Column]:
    return {key: column.copy() for key, column in percept.items()}


@contextmanager
def _put_back(body: Body) -> Iterator[None]:
    before = body.snapshot() if isinstance(body, Rewindable) else None
    try:
        yield
    finally:
        if before is not None and isinstance(body, Rewindable):
            body.restore(before)


def _read_value(feature: Feature, targets: tuple[str, ...], part: str, percept: Percept) -> Column:
    key = (str(feature.reading), targets[0] if targets else None)
    _require(key in percept, part, "a feature reads what the body offers", f"there is no {_spelled(key)}")
    return percept[key]


def _commanded(behavior: Behavior, targets: tuple[str, ...], percept: Percept) -> Mapping[str, Column]:
    if behavior.function is None:
        return {}
    part = f"behavior {behavior.name!r}"
    commanded = _call(part, behavior.function, percept, targets)
    law = "it returns a column for each channel"
    _require(isinstance(commanded, Mapping), part, law, f"it returned {commanded!r:.60}")
    return cast("Mapping[str, Column]", commanded)


def _channel(behavior: Behavior, targets: tuple[str, ...], channel: str, percept: Percept) -> Column:
    return _commanded(behavior, targets, percept)[channel]


def _check_column(part: str, column: object, rows: int, kind: Kind | None) -> None:
    shape = getattr(column, "shape", None)
    law = "its values are one column of floats, a number per agent"
    _require(isinstance(column, np.ndarray), part, law, f"they are {type(column).__name__}")
    values = np.asarray(column)
    _require(shape == (rows,) and values.dtype == np.float64, part, law, f"they are {values.dtype} {shape}")
    if kind is None:
        _require(bool(np.isfinite(values).all()), part, "commands are finite", f"they are {values}")
        return
    for row, value in enumerate(values.tolist()):
        try:
            kept = kind.check(value, where=part)
        except KindError as broken:
            raise LawBroken(
                part=part, law=f"its values are {kind}", found=f"agent {row}: {broken}"
            ) from broken
        same = kept == value or (kept != kept and value != value)
        _require(same, part, f"its values are {kind}", f"agent {row} has {value}, which is {kept} there")


def _check_computation(
    part: str, compute: Callable[[Percept], Column], percept: Percept, kind: Kind | None
) -> None:
    before = _copied(percept)
    column = compute(percept)
    rows = len(next(iter(percept.values())))
    _check_column(part, column, rows, kind)
    kept = all(_same(percept[key], before[key]) for key in before)
    _require(kept, part, "it leaves the readings it is given untouched", "it changed them")
    _require(_same(column, compute(percept)), part, "the same readings give the same values", "they differed")
    for row in range(rows):
        alone = compute({key: values[row : row + 1] for key, values in percept.items()})
        if not _same(alone, column[row : row + 1]):
            found = f"agent {row} has {column[row]} among others and {alone} alone"
            raise LawBroken(part=part, law="each agent's value is its own", found=found)


def _check_channels(part: str, commands: Iterable[str], known: set[str]) -> None:
    unknown = sorted(set(commands) - known)
    law = "it commands channels of the body"
    _require(not unknown, part, law, f"it commands {unknown} where there are {sorted(known)}")


def _check_declarations(part: str, body: Body) -> None:
    law = "names are given once, and there is at least one reading, channel and agent"
    for names in ([each.name for each in body.readings], [each.name for each in body.channels]):
        _require(bool(names) and len(set(names)) == len(names), part, law, f"it has {names}")
    _require(len(set(body.targets)) == len(body.targets), part, law, f"it has targets {list(body.targets)}")
    _require(body.agents >= 1, part, law, f"it has {body.agents} agents")
    _require(body.tick_s > 0, part, "a tick takes some time", f"tick_s is {body.tick_s}")


def _check_percept(part: str, body: Body, percept: Percept) -> None:
    kinds = {reading.name: reading.kind for reading in body.readings}
    keys = list_reading_keys(body)
    _require(
        set(percept) == set(keys), part, "it senses what it is asked", f"it gave {sorted(map(str, percept))}"
    )
    for key in keys:
        _check_column(f"{part}, {_spelled(key)}", percept[key], body.agents, kinds[key[0]])
    _require_same(part, "sensing twice gives the same", [percept], [body.sense(keys)])
    for key in keys:
        _require_same(part, "a reading is the same asked alone", [body.sense([key])], [percept])
    kept, written = _copied(percept), body.sense(keys)
    for key in keys:
        if written[key].flags.writeable:
            written[key].fill(0.5)
    _require_same(part, "what is done to a percept does not reach the body", [kept], [body.sense(keys)])


def _check_refusals(part: str, body: Body) -> None:
    law = "what it does not know, it refuses with an UnderstudyError that names it"
    unknown = "no_such_thing"
    channel, wrong = body.channels[0].name, np.zeros(body.agents + 1)
    attempts: dict[str, Callable[[], object]] = {
        f"reading {unknown!r}": lambda: body.sense([(unknown, None)]),
        f"channel {unknown!r}": lambda: body.act({unknown: np.zeros(body.agents)}),
        f"{channel!r} for one agent too many": lambda: body.act({channel: wrong}),
        f"{channel!r} that is NaN": lambda: body.act({channel: np.full(body.agents, np.nan)}),
    }
    before = _copied(body.sense(list_reading_keys(body)))
    for what, attempt in attempts.items():
        name = unknown if unknown in what else channel
        try:
            attempt()
        except UnderstudyError as refusal:
            _require(name in str(refusal), part, law, f"for {what} it said: {refusal}")
        except Exception as error:
            raise LawBroken(part=part, law=law, found=f"for {what} it raised {error!r}") from error
        else:
            raise LawBroken(part=part, law=law, found=f"it took {what}")
    after = [body.sense(list_reading_keys(body))]
    _require_same(part, "a command that is refused changes nothing", [before], after)


def _check_commands_untouched(part: str, body: Body, seed: int) -> None:
    commands = _drawn(body, [np.random.default_rng(seed)], body.agents)
    before = {channel: column.copy() for channel, column in commands.items()}
    body.act(commands)
    kept = all(_same(commands[channel], column) for channel, column in before.items())
    _require(kept, part, "it leaves the commands it is given untouched", "it changed them")


def _check_rewinding(part: str, body: Body, ticks: int, seed: int) -> None:
    if not isinstance(body, Rewindable):
        return
    start, time_s = body.snapshot(), body.time_s
    first = [_copied(percept) for percept in _percepts(body, ticks, seed)]
    body.restore(start)
    law = "restoring a snapshot goes back bit for bit"
    _require(body.time_s == time_s, part, law, f"its time was {time_s} s and is {body.time_s} s")
    _require(body.snapshot() == start, part, law, "a snapshot taken there is another")
    second = [_copied(percept) for percept in _percepts(body, ticks, seed)]
    _require_same(part, "it goes on from a snapshot as it did before", first, second)
    for bad in (b"", b"nonsense", start[:-1]):
        try:
            body.restore(bad)
        except UnderstudyError:
            continue
        except Exception as error:
            raise LawBroken(
                part=part, law="it refuses a bad snapshot", found=f"it raised {error!r}"
            ) from error
        raise LawBroken(part=part, law="it refuses a bad snapshot", found=f"it took {bad[:20]!r}")
    body.restore(start)
    body.act({})
    rested = [body.sense(list_reading_keys(body))]
    body.restore(start)
    body.act({channel.name: np.full(body.agents, channel.rest) for channel in body.channels})
    _require_same(part, "a channel left out rests", rested, [body.sense(list_reading_keys(body))])
    body.restore(start)
