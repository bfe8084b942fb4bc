"""Pace the world against real time, count the demonstrator's time, and run a world without a session."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import ceil, inf, isinf

from understudy.addons.robots.twin import DigitalTwin, Ground
from understudy.errors import SettingError

FASTEST = inf
"""As fast as possible."""
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, FASTEST)
BUSY_S = 0.012
"""How long a beat takes ticks that goes as fast as it can: most of a picture's 1/60 s; the rest is for pages."""
LONGEST_STALL_S = 0.25
"""What is made up for after a stall; a longer one is let go, so that the world never races."""


def check_speed(speed: float, where: str, *, live: bool = False) -> float:
    """Return a speed that is available; SettingError for others. A `live` clock has only real time."""
    if live and speed != 1.0:
        problem = f"is {speed:g}, but real robots run in real time"
        raise SettingError(where=where, setting="speed", problem=problem, remedy="leave it at 1")
    if speed not in SPEEDS:
        speeds = ", ".join(f"{each:g}" for each in SPEEDS[:-1])
        remedy = f"give one of {speeds}, or fastest"
        raise SettingError(where=where, setting="speed", problem=f"is {speed:g}", remedy=remedy)
    return speed


def choose_clock(ground: Ground, wall: Callable[[], float]) -> Callable[[], float]:
    """Return the clock by which a world runs: that of its robots' simulation if they have one, else real time."""
    simulated = ground.fleet.simulation_clock if isinstance(ground, DigitalTwin) else None
    return simulated or wall


class RealTimeClock:
    """The clock of a world, paused at first. A `live` clock does not make up for late ticks."""

    def __init__(self, wall: Callable[[], float], *, tick_s: float, live: bool = False) -> None:
        self.speed, self.live = 1.0, live
        self._wall, self._tick_s = wall, tick_s
        self._going = False
        self._last = wall()
        self._time_s = self._owed_s = 0.0

    @property
    def time_s(self) -> float:
        """The demonstrator's time, s: real time without the pauses."""
        self._advance()
        return self._time_s

    def resume(self) -> None:
        """Resume the clock."""
        self._advance()
        self._going = True

    def stop(self) -> None:
        """Pause the clock."""
        self._advance()
        self._going = False
        self._owed_s = 0.0

    def step(self) -> None:
        """Note that one tick was taken while paused."""
        self._time_s += self._tick_s

    def ticks(self) -> Iterator[None]:
        """Yield once for each tick that is due; at full speed, as many as fit into a beat, but at least one."""
        if not isinf(self.speed):
            yield from (None for _ in range(self.count_due_ticks()))
            return
        began = self._advanced()
        while self._going:
            yield
            if self._advanced() - began >= BUSY_S:
                return

    def count_due_ticks(self) -> int:
        """Count the ticks that are due at a given speed."""
        self._advance()
        ticks = int(self._owed_s / self._tick_s + 1e-6)
        most = 1 if self.live else max(1, ceil(LONGEST_STALL_S * self.speed / self._tick_s))
        self._owed_s = 0.0 if ticks > most else self._owed_s - ticks * self._tick_s
        return min(ticks, most)

    def faster(self) -> None:
        """Change to the next higher speed, if there is one."""
        faster = SPEEDS[min(SPEEDS.index(self.speed) + 1, len(SPEEDS) - 1)]
        self.speed = check_speed(faster, "the trainer", live=self.live)

    def slower(self) -> None:
        """Change to the next lower speed, if there is one."""
        slower = SPEEDS[max(SPEEDS.index(self.speed) - 1, 0)]
        self.speed = check_speed(slower, "the trainer", live=self.live)

    def _advanced(self) -> float:
        self._advance()
        return self._last

    def _advance(self) -> None:
        now = self._wall()
        passed, self._last = now - self._last, now
        if self._going:
            self._time_s += passed
            self._owed_s = 0.0 if isinf(self.speed) else self._owed_s + passed * self.speed


class IdleWorld:
    """A world in real time without a trainer."""

    def __init__(self, world: Ground, wall: Callable[[], float]) -> None:
        self._world, self.pace = (
            world,
            RealTimeClock(
                choose_clock(world, wall), tick_s=world.tick_s, live=isinstance(world, DigitalTwin)
            ),
        )
        self.paused = True

    def pause(self, paused: bool) -> None:
        """Pause or resume the world."""
        self.paused = paused
        (self.pace.stop if paused else self.pace.resume)()

    def ticks(self) -> Iterator[None]:
        """Take the ticks that are due, one after the other."""
        for _ in self.pace.ticks():
            self._world.act({})
            yield

    def step(self) -> None:
        """Take one tick, then pause."""
        self.pause(True)
        self._world.act({})
