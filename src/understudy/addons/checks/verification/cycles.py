"""Find switches that are undone in the same cell, and cycles of switches in one cell, also through several levels.

An automaton is run on boxes instead of numbers: at each query the box of readings that are held is divided among the
leaves, and each part goes its own way, by the same rules as in `runtime.interpreter`. A run in which some level
switches at every tick and that comes back to where it began goes on for as long as the readings stay in its box. Runs
with a tick without a switch are given up: there the automaton waits, for its clock or for the world.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil, nan
from typing import NamedTuple

from understudy.addons.checks.verification.cells import Leaf
from understudy.addons.checks.verification.levels import Level
from understudy.model.features import CounterFeature, Feature, FlagFeature, TimeInState, TimerFeature
from understudy.model.tree import STAY
from understudy.model.value_kinds import NO, YES

MOST_PULSES = 20_000
"""The number of pulses of one automaton after which the search is given up, and reported as unfinished."""
TICK_S = 0.1
"""The tick length that is assumed where no scenario gives one, s."""


class Frame(NamedTuple):
    """One level of a run: its state, the ticks since it was entered, and its counters and timers.

    Counters are numbers; timers are the ticks since they were set. Ages stop counting above all thresholds.
    """

    state: int
    age: int
    counters: tuple[tuple[str, float], ...] = ()
    timers: tuple[tuple[str, int], ...] = ()


LevelFrames = tuple[Frame, ...]
"""The frames of all levels that matter, from the root down."""


class Pulse(NamedTuple):
    """What one pulse of a level may do: its frames after it, the box that it needs, and whether any level switched."""

    frames: LevelFrames
    box: int
    switched: bool


@dataclass(frozen=True, slots=True)
class Cycle:
    """A cycle of switches: the root's states in order, the boxes that it runs in, and for each its length in ticks.

    `nested` is true if levels below the root switch in it, and `clocked` if it depends on the length of a tick.
    `resets` is true if it is possible only if members do not raise flags in the tick of an order, as they may.
    """

    states: tuple[int, ...]
    boxes: tuple[int, ...]
    ticks: tuple[int, ...]
    nested: bool
    clocked: bool
    resets: bool


@dataclass(frozen=True)
class CycleSearch:
    """The result of a search: the cycles, and whether the search was finished."""

    cycles: tuple[Cycle, ...]
    is_finished: bool


@dataclass
class CycleFinder:
    """A search for cycles of the root automaton in one cell.

    Parameters
    ----------
    root
        The automaton.
    tick_s
        Length of a tick, s.
    flags_vary
        True to let features that an order resets have any value at each query, instead of their reset value.
    """

    root: Level
    tick_s: float = TICK_S
    flags_vary: bool = False
    _pulses: int = 0
    _caps: dict[int, int] = field(default_factory=dict)

    def search(self) -> CycleSearch:
        """Search from every state that can be entered and left."""
        runs_by_states: dict[tuple[int, ...], list[tuple[int, int, bool]]] = {}
        try:
            for start in sorted(self.root.reachable_states):
                if self.root.exits[start]:
                    for states, box, ticks, nested in self._from_state(start):
                        runs_by_states.setdefault(states, []).append((box, ticks, nested))
            finished = True
        except _GivenUp:
            finished = False
        return CycleSearch(
            tuple(self._make(states, runs) for states, runs in runs_by_states.items()), finished
        )

    def _make(self, states: tuple[int, ...], runs: Sequence[tuple[int, int, bool]]) -> Cycle:
        tested = {bits for state in states for leaf in self.root.leaves[state] or () for bits in leaf.tested}
        features = [axis.bound.feature for axis in self.root.axes if axis.whole in tested]
        lengths = {box: ticks for box, ticks, _ in runs}
        return Cycle(
            states,
            tuple(lengths),
            tuple(lengths.values()),
            any(nested for _, _, nested in runs),
            any(isinstance(feature, TimeInState | TimerFeature) for feature in features),
            any(
                self.root.instant is None or feature.reading in self.root.instant.get(state, ())
                for feature in features
                for state in states
                if isinstance(feature, Feature) and feature.fresh is not None
            ),
        )

    def _from_state(self, start: int) -> Iterator[tuple[tuple[int, ...], int, int, bool]]:
        """Yield the root's states, the box, the ticks and whether levels below switched, for each cycle."""
        first = self._enter(self.root, start, Frame(0, 0))
        waiting: list[tuple[LevelFrames, int, tuple[int, ...], int, bool, frozenset[Frame]]] = [
            ((first, *pulse.frames), pulse.box, (start,), 1, bool(pulse.frames), frozenset([first]))
            for pulse in self._pulse_child(self.root, start, None, self.root.space.full)
        ]
        visited: set[tuple[LevelFrames, int, tuple[int, ...]]] = set()
        while waiting:
            run, box, states, ticks, nested, entries = waiting.pop()
            run = self._grow_older(run)
            if (run, box, states) in visited:
                continue
            visited.add((run, box, states))
            for pulse in self._pulse(self.root, run, box):
                if not pulse.switched:
                    continue
                root = pulse.frames[0]
                if root.age > 0:  # only levels below it switched
                    waiting.append((pulse.frames, pulse.box, states, ticks + 1, True, entries))
                    continue
                if root.state == start and root == first:
                    if self.root.space.before_end.narrow(pulse.box):
                        yield states, pulse.box, ticks, nested
                    continue
                if root.state < start or root in entries or self._is_flag(root.state):
                    continue
                waiting.append(
                    (
                        pulse.frames,
                        pulse.box,
                        (*states, root.state),
                        ticks + 1,
                        nested or len(pulse.frames) > 1,
                        entries | {root},
                    )
                )

    def _is_flag(self, state: int) -> bool:
        return self.root.automaton.states[state].flag is not None

    # One pulse

    def _pulse(self, level: Level, run: LevelFrames, box: int) -> Iterator[Pulse]:
        """Yield what a pulse of a level may do, one for each leaf that some readings in the box reach."""
        self._pulses += 1
        if self._pulses > MOST_PULSES:
            raise _GivenUp
        frame, below = run[0], run[1:]
        leaves = level.leaves[frame.state]
        if leaves is None:
            if level.automaton.states[frame.state].name in level.automaton.transitions:
                raise _GivenUp  # a classifier
            yield from self._stay(level, frame, below, box)
            return
        own = self._own_bits(level, frame, below)
        for leaf in leaves:
            narrowed = self._narrow(level, leaf, own, box)
            if not narrowed:
                continue
            if leaf.outcome in (STAY, frame.state):
                yield from self._stay(level, frame, below, narrowed)
                continue
            entered = self._enter(level, leaf.outcome, frame)
            for pulse in self._pulse_child(level, leaf.outcome, None, narrowed):
                yield Pulse((entered, *pulse.frames), pulse.box, True)

    def _stay(self, level: Level, frame: Frame, below: LevelFrames, box: int) -> Iterator[Pulse]:
        for pulse in self._pulse_child(level, frame.state, below, box):
            yield Pulse((frame, *pulse.frames), pulse.box, pulse.switched)

    def _pulse_child(self, level: Level, state: int, below: LevelFrames | None, box: int) -> Iterator[Pulse]:
        """Pulse the automaton that a state runs, restarted if `below` is None, if any of its flags matters there."""
        child = level.children[state]
        if child is None or not self._waits_for_flags(level, state):
            yield Pulse((), box, False)
            return
        yield from self._pulse(child, below or (Frame(0, 0),), box)

    def _waits_for_flags(self, level: Level, state: int) -> bool:
        """Return whether a state's tree tests a flag that the automaton it runs can raise."""
        child, leaves = level.children[state], level.leaves[state]
        if child is None or leaves is None:
            return False
        bits = {
            axis.whole
            for axis in level.axes
            if isinstance(axis.bound.feature, FlagFeature) and axis.bound.feature.name in child.possible_flags
        }
        return any(bits.intersection(leaf.tested) for leaf in leaves)

    def _narrow(self, level: Level, leaf: Leaf, own: int, box: int) -> int:
        """Return the part of a box of held readings that reaches a leaf, given the bits of all other values."""
        loose = self._loose_bits(level)
        if any(not leaf.box & own & bits for bits in leaf.tested if bits & loose):
            return 0
        narrowed = box & (leaf.box | loose)
        return 0 if any(not narrowed & bits for bits in leaf.tested) else narrowed

    def _loose_bits(self, level: Level) -> int:
        """Return the bits of the axes whose values are not held: own features, and those that an order resets."""
        key = -id(level)
        if key not in self._caps:
            self._caps[key] = level.own_bits | sum(
                axis.whole for axis in level.axes if _find_reset(axis.bound.feature) is not None
            )
        return self._caps[key]

    def _own_bits(self, level: Level, frame: Frame, below: LevelFrames) -> int:
        """Return the bits of the values of all features that are not held."""
        bits = 0
        for axis in level.axes:
            feature = axis.bound.feature
            if isinstance(feature, Feature):
                reset = _find_reset(feature)
                if reset is not None:
                    bits |= axis.whole if self.flags_vary and frame.age > 0 else axis.find_bit(reset)
            elif isinstance(feature, FlagFeature):
                bits |= axis.find_bit(YES if self._raised(level, frame.state, below) == feature.name else NO)
            elif isinstance(feature, CounterFeature):
                bits |= axis.find_bit(dict(frame.counters).get(feature.name, 0.0))
            elif isinstance(feature, TimerFeature):
                ticks = dict(frame.timers).get(feature.name)
                bits |= axis.find_bit(nan if ticks is None else ticks * self.tick_s)
            else:
                bits |= axis.find_bit(round(frame.age * self.tick_s, 9))
        return bits

    def _raised(self, level: Level, state: int, below: LevelFrames) -> str | None:
        """Return the flag that the automaton of a state has raised."""
        child = level.children[state]
        return child.automaton.states[below[0].state].flag if child is not None and below else None

    # Memory

    def _enter(self, level: Level, state: int, former: Frame) -> Frame:
        """Return the frame of a level that has just entered a state: its memory, changed by the state's behavior."""
        counters, timers = dict(former.counters), dict(former.timers)
        for change in level.changes[state]:
            if change.of == "counter":
                number = change.value if change.action == "set" else 0.0
                if change.action == "increment":
                    number = counters.get(change.name, 0.0) + change.value
                counters[change.name] = self._limit(level, change.name, number)
            elif change.action == "set":
                timers[change.name] = 0
            else:
                timers.pop(change.name, None)
        tested = {axis.bound.feature.name for axis in level.axes}
        return Frame(
            state,
            0,
            tuple(sorted((name, value) for name, value in counters.items() if name in tested and value)),
            tuple(sorted((name, value) for name, value in timers.items() if name in tested)),
        )

    def _limit(self, level: Level, name: str, number: float) -> float:
        """Return a counter's value, kept just beyond all thresholds, so that runs come back to the same values."""
        cuts = [
            end
            for axis in level.axes
            if axis.bound.feature.name == name
            for part in axis.parts
            for ends in part.parts
            for end in ends
            if abs(end) < float("inf")
        ]
        return max(min([*cuts, 0.0]) - 1.0, min(max([*cuts, 0.0]) + 1.0, number))

    def _grow_older(self, run: LevelFrames) -> LevelFrames:
        """Return a run one tick later; ages count to just beyond the thresholds of the features that read them."""
        older = []
        level: Level | None = self.root
        for frame in run:
            if level is None:
                break
            cap = self._age_cap(level)
            timers = tuple((name, min(ticks + 1, cap)) for name, ticks in frame.timers)
            older.append(frame._replace(age=min(frame.age + 1, cap), timers=timers))
            level = level.children[frame.state]
        return tuple(older)

    def _age_cap(self, level: Level) -> int:
        if id(level) not in self._caps:
            cuts = [
                part.parts[0][0]
                for axis in level.axes
                if isinstance(axis.bound.feature, TimeInState | TimerFeature)
                for part in axis.parts
                if part.parts
            ]
            self._caps[id(level)] = ceil(max([0.0, *cuts]) / self.tick_s) + 1
        return self._caps[id(level)]


class _GivenUp(Exception):
    """The search takes too long, or meets something that it cannot decide."""


def _find_reset(feature: object) -> float | None:
    """Return the value that an order resets a feature to; None if it is not reset."""
    return feature.fresh if isinstance(feature, Feature) else None
