"""A body whose readings are plain functions of the tick: every number in a test can be checked by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from understudy.errors import FileError
from understudy.model.behaviors import (
    Behavior,
    Command,
    behavior,
    increment,
    reset_counter,
    reset_timer,
    set_counter,
    set_timer,
)
from understudy.model.binding import Target
from understudy.model.features import (
    CounterFeature,
    Feature,
    FlagFeature,
    Percept,
    ReadingKey,
    ReadingsView,
    TimeInState,
    TimerFeature,
    feature,
)
from understudy.model.library import Kit
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Toroidal
from understudy.runtime.body import Channel, Commands, Reading

TICK_S = 0.1

RANGE: Mapping[ReadingKey, Callable[[int], float]] = {
    ("range", "ball"): lambda tick: 100.0 - tick,
    ("range", "goal"): lambda tick: 1000.0 + tick,
    ("bearing", "ball"): lambda tick: (6.0 + 0.1 * tick) % Toroidal().period,
    ("bearing", "goal"): lambda tick: 1.0,
    ("load", None): lambda tick: float(tick // 5),
    ("seen", None): lambda tick: float(tick % 2),
}
"""100 m to the ball and one less per tick; 1000 m to the goal and one more; load grows every fifth tick; seen
is yes every other tick."""


class Scripted:
    """N agents that all sense the same functions of the tick, agent i adding i to its ranges; `commanded` has
    what each tick commanded."""

    tick_s = TICK_S
    targets = ("ball", "goal")
    channels = (Channel("drive"), Channel("turn", rest=0.5))
    readings = (
        Reading("range", Continuous(), "m", of_targets=True),
        Reading("bearing", Toroidal(), "rad", of_targets=True),
        Reading("load", Continuous()),
        Reading("seen", BOOLEAN),
    )

    def __init__(self, agents: int = 1, script: Mapping[ReadingKey, Callable[[int], float]] = RANGE) -> None:
        self.agents = agents
        self.script = script
        self.tick = 0
        self.commanded: list[dict[str, list[float]]] = []

    @property
    def time_s(self) -> float:
        return self.tick * self.tick_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        return {key: self._column(key) for key in keys}

    def _column(self, key: ReadingKey) -> Column:
        each: Column = np.arange(self.agents, dtype=np.float64) * (key[0] == "range")
        column: Column = each + self.script[key](self.tick)
        return column

    def act(self, commands: Commands) -> None:
        self.commanded.append({channel: column.tolist() for channel, column in commands.items()})
        self.tick += 1

    def snapshot(self) -> bytes:
        return str(self.tick).encode()

    def restore(self, snapshot: bytes) -> None:
        if not snapshot.isdigit():
            raise FileError(path="snapshot", place="", problem="is no number", remedy="give a tick")
        self.tick = int(snapshot)

    def reset(self, seeds: Sequence[int]) -> None:
        self.tick = 0


range_of = Feature("range_of", Continuous(), "range", of="A", unit="m")
bearing_of = Feature("bearing_of", Toroidal(), "bearing", of="A", unit="rad")
load = Feature("load", Continuous(), "load")
seen = Feature("seen", BOOLEAN, "seen")


@feature(Toroidal())
def opposite(_: ReadingsView, A: ReadingsView) -> Column:
    """Where one looks away from A."""
    return A.bearing + 3.0


@behavior
def toward(_: ReadingsView, A: ReadingsView) -> dict[str, Column]:
    """Turn as far as A is to the left; absent where A is not sensed."""
    return {"turn": A.bearing}


kit = Kit.from_parts(
    range_of,
    bearing_of,
    load,
    seen,
    opposite,
    toward,
    FlagFeature("done"),
    FlagFeature("failed"),
    CounterFeature("laps"),
    TimerFeature("watch"),
    TimeInState(),
    Behavior("forward", Command(drive=1.0)),
    Behavior("left", Command(turn=1.0)),
    Behavior("right", Command(turn=-1.0)),
    Behavior("lap", Command(drive=0.5), (increment("laps"),)),
    Behavior("three_laps", changes=(set_counter("laps", 3.0),)),
    Behavior("no_laps", changes=(reset_counter("laps"),)),
    Behavior("click", changes=(set_timer("watch"),)),
    Behavior("unclick", changes=(reset_timer("watch"),)),
    Target("ball"),
    Target("goal"),
)
