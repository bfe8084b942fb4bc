"""The foraging task of the paper (section 4.1): bring food from sources, which become empty, to the station.

There is one robot per world. Worlds are those of the built-in scenario `forage`, with sizes and counts from settings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, isfinite, pi, radians
from types import MappingProxyType
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario, remove_markers
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

NAME = "forage"
"""The built-in scenario that the settings modify."""
WHERE = "the foraging world"
BESIDE = 1.2
"""The distance of food beside the station from it, in units of the reach: a robot reaches both at once."""


def make_setting_error(setting: str, problem: str, remedy: str) -> SettingError:
    """Make the error that a setting of the foraging world is not valid."""
    return SettingError(where=WHERE, setting=setting, problem=problem, remedy=remedy)


@dataclass(frozen=True, slots=True)
class ForageSettings:
    """The sizes and counts of a foraging world; SettingError for values that are impossible together.

    With the default values a tick turns the robot by 0.12 rad and moves it by 5 cm. Both are well below the error with
    which people judge that a robot faces or has reached something, so behaviors need not alternate rapidly. Distances
    are long and loading is slow in comparison: turning takes the reference solution only an eighth of its time.

    Parameters
    ----------
    width
        Width of the arena, m.
    height
        Height of the arena, m.
    sources
        Least and most number of sources of food, drawn for each world.
    amounts
        Least and most units of food in a source, drawn for each source.
    capacity
        Most units of food that the robot can carry.
    stored
        Units of food that it carries at first.
    starts_at_station
        Whether it starts at the station, rather than at a random place.
    food_beside_station
        Whether the food is within reach of a place from which the station is in reach, too.
    forward_speed
        Greatest speed of the robot, m/s.
    turning_speed
        Greatest turning speed of the robot, rad/s.
    load_s
        Time to load one unit of food, s; a multiple of `tick_s`.
    unload_s
        Time to unload one unit of food, s; a multiple of `tick_s`.
    reach
        Distance, from center to center, within which the robot loads and unloads, m.
    radius
        Radius of the robot, of the station and of sources, m.
    tick_s
        Length of a tick, s.
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
        for name in _SIZES:
            _check_size(name, getattr(self, name))
        _check_count("capacity", self.capacity, least=1, most=None)
        _check_count("stored", self.stored, least=0, most=self.capacity)
        _check_pair("sources", self.sources, least=0)
        _check_pair("amounts", self.amounts, least=1)
        for name in ("load_s", "unload_s"):
            ticks = getattr(self, name) / self.tick_s
            if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-9:
                raise make_setting_error(
                    name, f"is {getattr(self, name)} s", f"give a multiple of tick_s, {self.tick_s} s"
                )
        if self.forward_speed * self.tick_s > self.reach:
            problem = f"drives {self.forward_speed * self.tick_s} m in a tick"
            raise make_setting_error(
                "forward_speed", problem, f"give less, so that it is at most the reach, {self.reach} m"
            )
        if self.turning_speed * self.tick_s > pi / 2:
            problem = f"turns {self.turning_speed * self.tick_s} rad in a tick"
            raise make_setting_error(
                "turning_speed", problem, "give less, so that it is at most a quarter of a circle"
            )
        if self.radius > self.reach:
            raise make_setting_error(
                "radius", f"is {self.radius} m", f"give at most the reach, {self.reach} m"
            )
        if self.food_beside_station and self.sources[0] == 0:
            raise make_setting_error(
                "food_beside_station", "is asked for without food", "let sources begin at 1"
            )
        for name in ("width", "height"):
            if getattr(self, name) <= 2 * self.margin:
                problem, remedy = f"is {getattr(self, name)} m", f"give more than {2 * self.margin} m"
                raise make_setting_error(name, f"leaves no room between the walls: it {problem}", remedy)

    @property
    def clearance(self) -> float:
        """The free space around station and sources, m: no place is within reach of two of them."""
        return round(2.0 * self.reach + 0.1 - 2.0 * self.radius, 9)

    @property
    def margin(self) -> float:
        """The least distance of the centers of station and sources from the walls, m."""
        return self.radius + self.clearance

    def scenario(self) -> Scenario:
        """Make the built-in foraging scenario with these sizes and counts.

        Returns
        -------
        Scenario
            A scenario with one robot, one station, and sources of food, for `World`.
        """
        usual = load_scenario(NAME)
        (kind,), (robots,) = usual.types, usual.robots
        beside, at_station = (
            {"near": "station", "apart": 0.0},
            {"near": "station", "near_m": 0.0, "apart": 0.0},
        )
        station, food = (
            msgspec.structs.replace(thing, radius=self.radius, apart=self.clearance)
            for thing in usual.objects
        )
        food = msgspec.structs.replace(food, count=self.sources, amount=self.amounts)
        if self.food_beside_station:
            food = msgspec.structs.replace(food, **beside, near_m=BESIDE * self.reach)
        robots = msgspec.structs.replace(robots, apart=self.clearance, stored=self.stored)
        if self.starts_at_station:
            robots = msgspec.structs.replace(robots, **at_station)
        forager = msgspec.structs.replace(
            usual.types[kind],
            radius=self.radius,
            speed=self.forward_speed,
            turning_deg=degrees(self.turning_speed),
            capacity=self.capacity,
            reach=self.reach,
            load_s=self.load_s,
            unload_s=self.unload_s,
        )
        return msgspec.structs.replace(
            usual,
            size=(self.width, self.height),
            tick_s=self.tick_s,
            objects=(station, food),
            types={kind: forager},
            robots=(robots,),
        )


def recover_forage_settings(scenario: Scenario) -> ForageSettings | None:
    """Return the settings that would produce a scenario; None if no settings do.

    Texts, colors, markers and the time limit are not compared.
    """
    scenario = remove_markers(scenario)
    try:
        (forager,), (robots,), (_, food) = scenario.types.values(), scenario.robots, scenario.objects
        settings = ForageSettings(
            *scenario.size,
            sources=_pair(food.count),
            amounts=_pair(food.amount),
            capacity=forager.capacity,
            stored=robots.stored,
            starts_at_station=robots.near is not None,
            food_beside_station=food.near is not None,
            forward_speed=forager.speed,
            turning_speed=radians(forager.turning_deg),
            load_s=forager.load_s,
            unload_s=forager.unload_s,
            reach=forager.reach,
            radius=forager.radius,
            tick_s=scenario.tick_s,
        )
    except (ValueError, SettingError):
        return None
    return settings if _meant(settings.scenario()) == _meant(scenario) else None


def _pair(count: object) -> tuple[int, int]:
    """Return a count, or a (least, most) pair of counts, as a pair; (1, 1) for anything else."""
    match count:
        case (int(least), int(most)):
            return least, most
        case int(number):
            return number, number
    return 1, 1


WORDS = ("about", "doc", "color", "limit_s")


def _meant(scenario: Scenario) -> Any:
    """Return what of a scenario affects a foraging robot, in a form in which equivalent scenarios are equal.

    Texts and colors are removed, counts become pairs, and floats are rounded.
    """
    things = (
        msgspec.structs.replace(each, count=_pair(each.count), amount=_pair(each.amount))
        for each in scenario.objects
    )
    return _without_words(
        msgspec.to_builtins(msgspec.structs.replace(scenario, name="", objects=tuple(things)))
    )


def _without_words(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _without_words(inside) for key, inside in value.items() if key not in WORDS}
    if isinstance(value, list | tuple):
        return [_without_words(inside) for inside in value]
    return round(value, 9) if isinstance(value, float) else value


_SIZES = (
    "width",
    "height",
    "forward_speed",
    "turning_speed",
    "load_s",
    "unload_s",
    "reach",
    "radius",
    "tick_s",
)


def _check_size(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not (isfinite(value) and value > 0):
        raise make_setting_error(name, f"is {value!r}", "give a finite number above 0")


def _check_count(name: str, value: object, *, least: int, most: int | None) -> None:
    if type(value) is not int or value < least or (most is not None and value > most):
        upto = "up" if most is None else f"to {most}"
        raise make_setting_error(name, f"is {value!r}", f"give a whole number from {least} {upto}")


def _check_pair(name: str, pair: object, *, least: int) -> None:
    low, high = pair if isinstance(pair, tuple) and len(pair) == 2 else (None, None)
    if type(low) is not int or type(high) is not int or not least <= low <= high:
        raise make_setting_error(name, f"is {pair!r}", f"give (least, most), whole numbers from {least} up")


def make_corner_cases(usual: ForageSettings | None = None) -> Mapping[str, ForageSettings]:
    """Return the corner cases of the paper by name, each a variation of `usual` (default settings if None)."""
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


def make_practice_worlds(usual: ForageSettings | None = None) -> Mapping[str, ForageSettings]:
    """Return small worlds by name, each to teach one part of the task, as variations of the settings `usual`."""
    usual = ForageSettings() if usual is None else usual
    small = replace(usual, width=8.0, height=8.0)
    nearly_full = usual.capacity - 3
    return MappingProxyType(
        {
            "an arena": small,
            "a small room": replace(usual, width=4.0, height=4.0, sources=(1, 1)),
            "little food in many places": replace(small, stored=nearly_full, sources=(3, 3), amounts=(2, 2)),
            "the last food": replace(small, stored=usual.capacity - 5, sources=(1, 1), amounts=(2, 3)),
            "one unit to deposit": replace(small, stored=1),
            "some food to deposit": replace(small, stored=4),
            "food for two ways": replace(small, stored=nearly_full, sources=(2, 2), amounts=(3, 5)),
        }
    )


__all__ = ["FORAGE_KIT", "Forage", "ForageSettings", "make_corner_cases"]

FORAGE_KIT = make_scenario_kit(load_scenario(NAME))


class Forage(World):
    """A body of N foraging robots, each alone in a world that its seed lays out.

    Parameters
    ----------
    seeds
        One whole number from 0 to 2**63 - 1 per world.
    settings
        Sizes and counts of the worlds; the defaults if None.
    """

    def __init__(self, seeds: Sequence[int] = (0,), settings: ForageSettings | None = None) -> None:
        self.settings = ForageSettings() if settings is None else settings
        super().__init__(self.settings.scenario(), seeds)

    def success(self) -> NDArray[np.bool_]:
        """Check which robots have brought all food of their world to the station.

        Returns
        -------
        NDArray[np.bool_]
            One flag per robot [N]. It is true from the start where a world has no food.
        """
        return np.equal(self.delivered, self.total)
