"""Settings of the foraging world, and the paper's corner cases as settings (paper section 4.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import isfinite
from types import MappingProxyType

from understudy.errors import SettingError

WHERE = "the foraging world"
BESIDE = 1.2
"""How far food beside the station is from it, in reaches: one place serves both."""


def wrong(setting: str, problem: str, remedy: str) -> SettingError:
    """The error for a setting of the foraging world."""
    return SettingError(where=WHERE, setting=setting, problem=problem, remedy=remedy)


@dataclass(frozen=True, slots=True)
class ForageSettings:
    """Sizes in m, speeds in m/s and rad/s, times in s, food in whole units; (least, most) where drawn.

    A tick turns the robot by 0.12 rad and drives it 5 cm, both well inside what a person would call facing it
    and being there: switching behaviors need not chatter. The ways are long and loading slow beside that, so
    that turning on the spot costs the yardstick only an eighth of its time.
    """

    width: float = 12.0
    height: float = 12.0
    sources: tuple[int, int] = (2, 4)
    amounts: tuple[int, int] = (4, 16)
    capacity: int = 12
    stored: int = 0
    starts_at_station: bool = False
    food_beside_station: bool = False
    forward_speed: float = 0.5
    turning_speed: float = 1.2
    load_s: float = 1.0
    unload_s: float = 1.0
    reach: float = 0.5
    radius: float = 0.2
    tick_s: float = 0.1

    def __post_init__(self) -> None:
        self._check_numbers()
        for name in ("sources", "amounts"):
            low, high = getattr(self, name)
            least = 0 if name == "sources" else 1
            if not least <= low <= high:
                raise wrong(name, f"is {(low, high)}", f"give (least, most) with {least} <= least <= most")
        if not 0 <= self.stored <= self.capacity:
            raise wrong("stored", f"is {self.stored}", f"give 0 to the capacity, {self.capacity}")
        for name in ("load_s", "unload_s"):
            ticks = getattr(self, name) / self.tick_s
            if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-9:
                raise wrong(
                    name, f"is {getattr(self, name)} s", f"give a multiple of the tick, {self.tick_s} s"
                )
        if self.forward_speed * self.tick_s > self.reach:
            raise wrong("forward_speed", "drives past a thing in one tick", "give less than reach / tick_s")
        if self.radius > self.reach:
            raise wrong("radius", f"is {self.radius} m", f"give at most the reach, {self.reach} m")
        if self.food_beside_station and self.sources[0] == 0:
            raise wrong("food_beside_station", "needs a source", "let sources begin at 1")
        if min(self.width, self.height) <= 2 * self.margin:
            size = f"are {self.width} and {self.height} m"
            raise wrong("width and height", size, f"give each more than {2 * self.margin} m")

    def _check_numbers(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "bool":
                continue
            if field.type == "tuple[int, int]":
                if not (isinstance(value, tuple) and [type(each) for each in value] == [int, int]):
                    raise wrong(field.name, f"is {value!r}", "give two whole numbers, the least and the most")
            elif field.type == "int" and (type(value) is not int or (value < 1 and field.name != "stored")):
                raise wrong(field.name, f"is {value!r}", "give a whole number of at least 1")
            elif not (
                isinstance(value, int | float) and isfinite(value) and (value > 0 or field.type == "int")
            ):
                raise wrong(field.name, f"is {value!r}", "give a finite number above 0")

    @property
    def load_ticks(self) -> int:
        """Ticks to load a unit."""
        return round(self.load_s / self.tick_s)

    @property
    def unload_ticks(self) -> int:
        """Ticks to unload a unit."""
        return round(self.unload_s / self.tick_s)

    @property
    def margin(self) -> float:
        """How far station and food stay from the walls, m: the robot can reach them from every side."""
        return self.reach + self.radius

    @property
    def apart(self) -> float:
        """How far station and sources stay from each other, m: no place is within reach of two."""
        return 2.0 * self.reach + 0.1


def corner_cases(usual: ForageSettings | None = None) -> Mapping[str, ForageSettings]:
    """The paper's corner cases by name, otherwise as usual."""
    usual = ForageSettings() if usual is None else usual
    return MappingProxyType(
        {
            "source empties before the robot is full": replace(
                usual, sources=(4, 5), amounts=(1, max(1, usual.capacity // 2))
            ),
            "robot starts full": replace(usual, stored=usual.capacity),
            "starts empty at the station": replace(usual, starts_at_station=True),
            "food beside the station": replace(usual, food_beside_station=True),
            "one last unit left": replace(usual, sources=(1, 1), amounts=(1, 1)),
            "no food at all": replace(usual, sources=(0, 0)),
        }
    )
