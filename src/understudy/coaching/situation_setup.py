"""Setting up situations: the robot is placed in the situation that advice is about, for a demonstration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, isinf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.pose_sampling import PoseSampler, RobotPose
from understudy.errors import SessionError, join_names
from understudy.model.features import BoundFeature, CounterFeature, FlagFeature, TimeInState, TimerFeature
from understudy.model.tree_regions import Box, ValueSet
from understudy.model.value_kinds import NO, Categorical, Toroidal
from understudy.runtime.interpreter import StackFrame
from understudy.training.other_agents import SessionSnapshot, require_rewindable
from understudy.training.session import Session

TRIES = 240
"""The number of poses that are tried in each world."""
EXACT = 0.02
"""The distance from the wanted situation below which no further pose is tried."""
NEARBY = 0.5
"""The share of tries after which poses are drawn around the best one so far."""


class SituationSpec(Protocol):
    """A situation to set up, such as that of an `Advice`, which says what the parts mean."""

    @property
    def sentence(self) -> str:
        """The sentence that describes the purpose of the situation."""

    @property
    def state(self) -> str:
        """The state of the automaton; "" if any."""

    @property
    def region(self) -> Box | None:
        """The set of values of each of the lesson's features; None: no situation in particular."""

    @property
    def at(self) -> tuple[float, ...] | None:
        """A feature vector that represents the region."""


@dataclass(frozen=True, slots=True)
class SetupResult:
    """The result of setting up a situation: whether it is `there`, and the features `missed`.

    `seed` is that of the world in which the robot is now; None: that world did not change.
    """

    there: bool
    sentence: str
    missed: tuple[str, ...] = ()
    seed: int | None = None


def set_up_situation(
    session: Session, advice: SituationSpec, *, seeds: Sequence[int] = (), tries: int = TRIES, draw: int = 0
) -> SetupResult:
    """Place the session's robot in the situation of advice, with its automaton in the state of the advice.

    Nothing is recorded. Of several places in the region, the one nearest to its representative is taken. If this world
    has no such place, the worlds of `seeds` are tried in turn. `draw` selects among suitable places. SessionError if
    the advice has no situation, or the body can neither be placed nor rewound.
    """
    if advice.region is None and not advice.state:
        raise SessionError(f"this advice is about no place in particular: {advice.sentence}")
    automaton = session.automaton
    region = advice.region or ()
    if advice.state and automaton.state(advice.state).flag is not None:
        raise SessionError(
            f"state {advice.state!r} raises a flag and is never left: nothing can be shown in it"
        )
    body = require_rewindable(session.body)
    levels, own_missed = _levels(session, advice.state, region)
    targets = session.view().targets
    poser = PoseSampler(session.body, session.agent, automaton.features, targets)
    best: tuple[float, bytes, NDArray[np.float64], int | None] | None = None
    before = body.snapshot()
    draws = np.random.default_rng([draw, 7])
    for seed in (None, *seeds):
        if seed is not None:
            session.reset(seed)
        for off, values in _tried(poser, advice, automaton.features, draws, tries):
            if best is None or off < best[0]:
                best = off, body.snapshot(), values, seed
        if best is not None and best[0] < 1.0:
            break
    if best is None:
        best = (inf, before, np.full(len(automaton.features), np.nan), None)
    _, snapshot, values, seed = best
    session.rewind(SessionSnapshot(snapshot, levels, session.mode, session.other_agents.snapshot()))
    off_each = _misses(automaton.features, region, values)
    missed = (
        *(str(bound) for bound, off in zip(automaton.features, off_each, strict=False) if off > 0),
        *own_missed,
    )
    return SetupResult(not missed, _said(advice, missed), missed, seed)


def _said(advice: SituationSpec, missed: Sequence[str]) -> str:
    if not missed:
        where = f" in state {advice.state}" if advice.state else ""
        return f"The situation is set up{where}: show me what to do."
    return f"Not fully set up: {join_names(missed)} {'differs' if len(missed) == 1 else 'differ'} from the suggestion."


def _tried(
    poser: PoseSampler,
    advice: SituationSpec,
    features: Sequence[BoundFeature],
    draws: np.random.Generator,
    tries: int,
) -> Iterator[tuple[float, NDArray[np.float64]]]:
    """Yield poses that are better than those before: how far off each is, and the values there.

    Below 1 it lies in the region. The search ends when all is as it should be.
    """
    if advice.region is None:
        yield 0.0, poser.read()
        return
    best: tuple[float, RobotPose] | None = None
    for turn in range(tries):
        if best is not None and turn > tries * NEARBY:
            pose = poser.draw_nearby_pose(best[1], draws, 0.2 * (1 - turn / tries) ** 2 + 0.003)
        else:
            pose = poser.draw_pose(draws, near=turn % 3 > 0)
        values = poser.values(pose)
        if values is None:
            continue
        missed = sum(_misses(features, advice.region, values))
        aside = 0.0 if advice.at is None else _aside(features, advice.at, values)
        off = (1.0 + missed if missed else 0.0) + aside
        if best is None or off < best[0]:
            best = off, pose
            yield off, values
        if off < EXACT:
            return


def _aside(features: Sequence[BoundFeature], at: Sequence[float], values: NDArray[np.float64]) -> float:
    """Return the distance of values from a vector, from 0 to below 1."""
    off = []
    for bound, wanted, value in zip(features, at, values.tolist(), strict=True):
        if bound.is_own or wanted == value or (wanted != wanted and value != value):
            continue
        if wanted != wanted or value != value or isinstance(bound.kind, Categorical):
            off.append(1.0)
        elif isinstance(bound.kind, Toroidal):
            turned = abs(wanted - value) % bound.kind.period
            off.append(2.0 * min(turned, bound.kind.period - turned) / bound.kind.period)
        else:
            off.append(min(1.0, abs(wanted - value) / max(abs(wanted), abs(value))))
    return 0.99 * sum(off) / len(features) if off else 0.0


def _misses(
    features: Sequence[BoundFeature], region: Box, values: Sequence[float] | NDArray[np.float64]
) -> list[float]:
    """Return the distance of each value from its part of a region, 0 inside; own features are ignored."""
    misses = []
    for bound, part, value in zip(features, region, values, strict=False):
        misses.append(0.0 if bound.is_own else measure_miss(bound, part, float(value)))
    return misses


def measure_miss(bound: BoundFeature, region: ValueSet, value: float) -> float:
    """Return the distance of a value from a region: 0 inside, 1 at most, and 1 where there are no degrees."""
    if value in region:
        return 0.0
    if value != value or not region.parts or isinstance(bound.kind, Categorical):
        return 1.0
    if isinstance(bound.kind, Toroidal):
        period = bound.kind.period
        off = min(min((low - value) % period, (value - high) % period) for low, high in region.parts)
        return min(1.0, max(off, 1e-9) / (period / 2))
    ends = [end for part in region.parts for end in part if not isinf(end)]
    scale = max(max(ends) - min(ends), abs(ends[0]), 1e-9)
    off = min(max(low - value, value - high) for low, high in region.parts)
    return min(1.0, 0.01 + 0.5 * max(off, 0.0) / scale)


def _levels(session: Session, state: str, region: Box) -> tuple[tuple[StackFrame, ...], tuple[str, ...]]:
    """Return the run state in which own features lie in a region, and the names of those for which there is none."""
    automaton = session.automaton
    name = state or automaton.states[0].name
    seconds, counters, timers = 0.0, {}, {}
    below: list[StackFrame] = []
    missed = []
    for bound, part in zip(automaton.features, region, strict=False):
        feature = bound.feature
        if isinstance(feature, TimeInState):
            seconds = _within(part)
        elif isinstance(feature, CounterFeature):
            counters[feature.name] = _within(part)
        elif isinstance(feature, TimerFeature) and part.parts:
            timers[feature.name] = _within(part)
        elif isinstance(feature, FlagFeature) and NO not in part:
            raised = _raised(session, name, feature.name)
            below += raised
            missed += [] if raised else [str(bound)]
    return (StackFrame(automaton.name, name, seconds, counters, timers), *below), tuple(missed)


def _raised(session: Session, state: str, flag: str) -> list[StackFrame]:
    """Return the run state of a state's behavior with its flag raised; an empty list if it has no such flag."""
    behavior = session.automaton.state(state).behavior
    taught = session.library.taught.get(behavior or "")
    if taught is None:
        return []
    flags = [each.name for each in taught.automaton.states if each.flag == flag]
    return [StackFrame(taught.automaton.name, flags[0], 0.0, {}, {})] if flags else []


def _within(region: ValueSet) -> float:
    """Return the number of a region that is nearest to 0 without lying on its edge."""
    if not region.parts or 0.0 in region:
        return 0.0
    low, high = min(region.parts, key=lambda part: abs(part[0]) if not isinf(part[0]) else abs(part[1]))
    if isinf(high):
        return low * 1.2 if low > 0 else low
    return high - 0.2 * abs(high) if isinf(low) else (low + high) / 2
