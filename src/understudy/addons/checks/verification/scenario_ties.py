"""The ties between features that a scenario guarantees: ranges of its sensors, and readings that go together.

A tie holds for every type of robots that has its readings. Noise, dropout and slow sensors make most of them untrue;
such sensors give fewer ties.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import hypot, inf, nextafter

from msgspec import UnsetType

from understudy.addons.checks.verification.ties import Tie, make_presence_tie, make_range_tie
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.model.tree_regions import ABSENT_ONLY, ValueSet, make_full_value_set
from understudy.model.value_kinds import NO, YES
from understudy.sim.scenario.schema import (
    Bumper,
    Camera,
    CargoSensor,
    GripSensor,
    Lidar,
    ObjectClass,
    RandomSensor,
    RobotType,
    Scenario,
    SensorBase,
    Sonar,
    StallSensor,
    TargetLocator,
)
from understudy.sim.sensing.sensor_table import find_sensor_row

CLOSE = 1e-9
"""Distances this near to a limit (m) may fall on either side of it, because they are rounded."""
PRESENT = ValueSet(((-inf, inf),), False)
NONE, SOME = ValueSet(((-inf, 1.0),), False), ValueSet(((1.0, inf),), False)
BETWEEN = ValueSet(((nextafter(0.0, 1.0), 1.0),), False)
DOWN, UP = ValueSet(((NO, 1.0),), False), ValueSet(((YES, 2.0),), False)


def list_bound_features(library: Library, targets: Iterable[str]) -> list[BoundFeature]:
    """List the features of a library's automata, bound to each target and each parameter."""
    names = dict.fromkeys(targets)
    names |= {name: None for taught in library.taught.values() for name in taught.automaton.parameters}
    bound_features: dict[BoundFeature, None] = {}
    for taught in library.taught.values():
        for bound in taught.automaton.features:
            if not isinstance(bound.feature, Feature):
                continue
            bound_features[bound] = None
            if len(bound.binding) == 1:
                (parameter,) = bound.binding
                bound_features |= {
                    BoundFeature(bound.feature, type(bound.binding)({parameter: name})): None
                    for name in names
                }
    return list(bound_features)


def list_scenario_ties(scenario: Scenario, library: Library) -> list[Tie]:
    """List the ties between the features that a library's automata use in a scenario.

    Parameters
    ----------
    scenario
        The scenario.
    library
        The library of a type of robots of the scenario, opened with its kit.

    Returns
    -------
    list[Tie]
        The ties that hold for all types of robots that have the readings.
    """
    ties: list[Tie] = []
    features = list_bound_features(library, scenario.targets)
    for bound in features:
        ties += _list_single(scenario, bound)
    by_key = {_key(bound): bound for bound in features}
    for bound in features:
        ties += _list_pairs(scenario, bound, by_key)
    return ties


def _key(bound: BoundFeature) -> tuple[str, str]:
    """Return the reading and the target of a feature."""
    feature = bound.feature
    return (feature.reading or "" if isinstance(feature, Feature) else ""), next(
        iter(bound.binding.values()), ""
    )


def _list_sensors(scenario: Scenario, reading: str, target: str) -> list[tuple[RobotType, SensorBase]]:
    """List the sensors that give a reading of a target, or of any if it is a parameter, each with its robots' type."""
    return [
        (robot_type, sensor)
        for robot_type in scenario.types.values()
        for sensor in robot_type.sensors
        if any(each.name == reading for each in find_sensor_row(sensor).readings(sensor))
        and not (
            isinstance(sensor, TargetLocator)
            and target in scenario.targets
            and not _is_located(robot_type, sensor, target)
        )
    ]


def _list_single(scenario: Scenario, bound: BoundFeature) -> Iterator[Tie]:
    """Yield the ties of one feature: its range, and that it is never absent."""
    reading, target = _key(bound)
    sensors = _list_sensors(scenario, reading, target)
    if not sensors:
        return
    ranges = [_find_range(scenario, robot_type, sensor, reading) for robot_type, sensor in sensors]
    if all(ends is not None for ends in ranges):
        low = min(ends[0] for ends in ranges if ends is not None)
        high = max(ends[1] for ends in ranges if ends is not None)
        unit = f" {bound.feature.unit}" if bound.feature.unit else ""
        sentence = f"{bound} is at least {low:g}{unit}" + (
            f" and at most {high:g}{unit}" if high < inf else ""
        )
        yield make_range_tie(bound, low, nextafter(high, inf) if high < inf else inf, sentence)
    if all(isinstance(sensor, CargoSensor) for _, sensor in sensors) and bound.feature.unit:
        yield Tie(f"{bound} is 0 or at least 1", {bound: BETWEEN})
    if all(_is_always_there(scenario, robot_type, sensor, target) for robot_type, sensor in sensors):
        yield make_presence_tie(bound, f"{bound} is never absent")


def _find_range(
    scenario: Scenario, robot_type: RobotType, sensor: SensorBase, reading: str
) -> tuple[float, float] | None:
    """Return the least and the largest present value of a sensor's reading; None if nothing bounds it."""
    if isinstance(sensor, Sonar):
        return 0.0, sensor.range
    if isinstance(sensor, Lidar) and not reading.endswith(("_bearing", "_width")):
        return 0.0, sensor.range
    if isinstance(sensor, TargetLocator) and reading == "range":
        diagonal = hypot(*scenario.size) if sensor.range is None else sensor.range
        return 0.0, diagonal if sensor.noise_range == 0 else inf
    if isinstance(sensor, Camera):
        largest = float(sensor.width_px * (1 if reading == "blob_x" else sensor.height_px))
        return 0.0, largest if reading == "blob_x" else inf
    if isinstance(sensor, RandomSensor):
        return 0.0, 1.0
    if isinstance(sensor, CargoSensor) and reading == "food_stored":
        stored = max([robots.stored for robots in scenario.robots], default=0)
        return 0.0, float(max(robot_type.capacity, stored))
    if isinstance(sensor, CargoSensor) and reading == "food_here":
        amounts = [
            each.amount if isinstance(each.amount, int) else each.amount[1] for each in scenario.objects
        ]
        return 0.0, float(max(amounts, default=0))
    return None


def _is_always_there(scenario: Scenario, robot_type: RobotType, sensor: SensorBase, target: str) -> bool:
    """Return whether a sensor's reading is never absent."""
    if sensor.dropout > 0:
        return False
    if isinstance(sensor, Sonar | Bumper | StallSensor | CargoSensor | GripSensor | RandomSensor):
        return True
    if isinstance(sensor, TargetLocator) and sensor.range is None:
        thing = _find_lasting_object(scenario, target)
        return thing is not None and _is_located(robot_type, sensor, target)
    return False


def _find_lasting_object(scenario: Scenario, target: str) -> ObjectClass | None:
    """Return the class of a target that is one object which is always there; None for other targets."""
    meant = scenario.targets.get(target)
    if meant is None or meant.object is None or meant.index:
        return None
    thing = next((each for each in scenario.objects if each.name == meant.object), None)
    if thing is None or thing.presence or thing.capture or thing.pull or thing.amount != 0:
        return None
    return thing


def _is_located(robot_type: RobotType, sensor: TargetLocator, target: str) -> bool:
    """Return whether a locator is the one that finds a target for its type of robots."""
    locators = [each for each in robot_type.sensors if isinstance(each, TargetLocator)]
    named = {name for each in locators for name in each.targets or ()}
    return target in sensor.targets if sensor.targets is not None else target not in named


def _list_pairs(
    scenario: Scenario, bound: BoundFeature, by_key: dict[tuple[str, str], BoundFeature]
) -> Iterator[Tie]:
    """Yield the ties of one feature with another."""
    reading, target = _key(bound)
    for first, second in (("range", "bearing"), ("blob_x", "blob_size")):
        other = by_key.get((second, target)) if reading == first else None
        if other is not None:
            sentence = f"{bound} and {other} are absent together"
            yield Tie(sentence, {bound: ABSENT_ONLY, other: _present(other)})
            yield Tie(sentence, {bound: PRESENT, other: ABSENT_ONLY})
    if reading == "holding" and (enough := by_key.get(("enough", ""))) is not None:
        yield Tie(f"{enough} is yes only while {bound} is yes", {bound: DOWN, enough: UP})
    if reading == "range" and measures_exactly(scenario):
        yield from _list_reach(scenario, bound, target, by_key)


def _present(bound: BoundFeature) -> ValueSet:
    """Return the set of all values that a feature can have while it is present."""
    return ValueSet(make_full_value_set(bound.kind).parts, False)


def measures_exactly(scenario: Scenario) -> bool:
    """Return whether locators and cargo sensors of all types measure at every tick, everywhere, and without noise."""
    sensors = [
        sensor
        for robot_type in scenario.types.values()
        for sensor in robot_type.sensors
        if isinstance(sensor, TargetLocator | CargoSensor)
    ]
    return all(
        sensor.dropout == 0
        and sensor.rate_hz is None
        and (isinstance(sensor, CargoSensor) or (sensor.noise_range == 0 and sensor.range is None))
        for sensor in sensors
    )


def _list_reach(
    scenario: Scenario, bound: BoundFeature, target: str, by_key: dict[tuple[str, str], BoundFeature]
) -> Iterator[Tie]:
    """Yield the ties of a distance with what robots reach there: the only home, and the only class of food."""
    reaches = {robot_type.reach for robot_type in scenario.types.values()}
    meant = scenario.targets.get(target)
    if meant is None or len(reaches) != 1:
        return
    (reach,) = reaches
    near = ValueSet(((-inf, reach - CLOSE),), False)
    far = ValueSet(((reach + CLOSE, inf),), False)
    homes = [each for each in scenario.objects if each.home]
    foods = [each for each in scenario.objects if each.amount != 0]
    here = by_key.get(("station_here", ""))
    thing = _find_lasting_object(scenario, target)
    if here is not None and thing is not None and homes == [thing] and _is_single(thing):
        sentence = f"{here} is yes exactly where {bound} is at most {reach:g} m"
        yield Tie(sentence, {here: UP, bound: far})
        yield Tie(sentence, {here: DOWN, bound: near})
        if least := _find_least_distance(thing, foods):
            yield from _list_distances(scenario, bound, here, least, reach, by_key)
    if meant.nearest is None or [each.name for each in foods] != [meant.nearest] or meant.unclaimed:
        return
    below, left = by_key.get(("food_here", "")), by_key.get(("food_left", ""))
    if below is not None:
        sentence = f"{below} is at least 1 exactly where {bound} is at most {reach:g} m"
        yield Tie(sentence, {below: SOME, bound: far})
        yield Tie(sentence, {below: SOME, bound: ABSENT_ONLY})
        yield Tie(sentence, {below: NONE, bound: near})
    if left is not None:
        sentence = f"{bound} is absent exactly while {left} is no"
        yield Tie(sentence, {left: DOWN, bound: PRESENT})
        yield Tie(sentence, {left: UP, bound: ABSENT_ONLY})
    if below is not None and left is not None:
        yield Tie(f"{below} is 0 while {left} is no", {left: DOWN, below: SOME})


def _list_distances(
    scenario: Scenario,
    home: BoundFeature,
    here: BoundFeature,
    least: float,
    reach: float,
    by_key: dict[tuple[str, str], BoundFeature],
) -> Iterator[Tie]:
    """Yield what follows from the least distance between the home and food: no robot is near both."""
    below = by_key.get(("food_here", ""))
    if below is not None and least > 2 * reach + CLOSE:
        sentence = f"{below} is at least 1 only while {here} is no, since the home is {least:g} m from food"
        yield Tie(sentence, {below: SOME, here: UP})
    for name, meant in scenario.targets.items():
        food = by_key.get(("range", name))
        if food is not None and any(each.name == meant.nearest and each.amount for each in scenario.objects):
            sentence = f"{home} and {food} are {least:g} m together at least"
            yield Tie(sentence, {}, ((home, -1.0), (food, -1.0)), CLOSE - least)


def _find_least_distance(home: ObjectClass, foods: list[ObjectClass]) -> float:
    """Return the least distance between the centers of a home and of food (m); 0 if nothing keeps them apart."""
    still = [
        isinstance(each.at, UnsetType) and each.near is None and not (each.walk or each.pushable or each.pull)
        for each in (home, *foods)
    ]
    if not foods or not all(still):
        return 0.0
    return min(home.radius + each.radius + max(home.apart, each.apart) for each in foods)


def _is_single(thing: ObjectClass) -> bool:
    """Return whether each world has exactly one object of a class."""
    if isinstance(thing.at, tuple):
        return len(thing.at) == 1
    return thing.count == 1 or not isinstance(thing.count, int | tuple)
