"""What goes with a scenario: readings, channels, targets, the kit."""

from __future__ import annotations

from math import tau

import pytest
from msgspec.structs import replace

from understudy.errors import SettingError
from understudy.model.behaviors import Command
from understudy.model.features import Feature, FlagFeature, TimeInState
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind, Toroidal
from understudy.sim.kit import list_readings, make_channels, make_scenario_kit, make_targets
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import (
    Bumper,
    Camera,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    FeatureSpec,
    GripSensor,
    PoseSensor,
    RandomSensor,
    RobotGroup,
    RobotType,
    Scenario,
    Sensor,
    Sonar,
    StallSensor,
    TargetLocator,
    TargetSpec,
)


def with_sensors(*sensors: Sensor) -> Scenario:
    types = {"rover": RobotType(sensors=sensors)}
    return Scenario(size=(9.0, 9.0), types=types, robots=(RobotGroup(type="rover"),))


LINE, CIRCLE = Continuous(), Toroidal(tau)
SENSED: list[tuple[Sensor, list[tuple[str, object, str, bool]]]] = [  # name, kind, unit, of targets
    (
        Sonar(sectors={"ahead": (0.0, 0.0), "rear": (170.0, 190.0)}),
        [("ahead", LINE, "m", False), ("rear", LINE, "m", False)],
    ),
    (Camera(), [("blob_x", LINE, "px", True), ("blob_size", LINE, "px", True)]),
    (TargetLocator(), [("range", LINE, "m", True), ("bearing", CIRCLE, "rad", True)]),
    (
        PoseSensor(),
        [
            ("x", LINE, "m", False),
            ("y", LINE, "m", False),
            ("heading", CIRCLE, "rad", False),
            ("speed", LINE, "m/s", False),
            ("turning", LINE, "rad/s", False),
        ],
    ),
    (Bumper(), [("bumper", BOOLEAN, "", False)]),
    (Bumper(sectors={"nose": (-30.0, 30.0)}), [("nose", BOOLEAN, "", False)]),
    (StallSensor(), [("stuck", BOOLEAN, "", False)]),
    (GripSensor(), [("holding", BOOLEAN, "", False), ("enough", BOOLEAN, "", False)]),
    (ClaimSensor(signal="claim", range=1.0, name="taken"), [("taken", BOOLEAN, "", True)]),
    (
        CargoSensor(),
        [
            ("food_here", LINE, "units", False),
            ("food_stored", LINE, "units", False),
            ("food_left", BOOLEAN, "", False),
            ("station_here", BOOLEAN, "", False),
        ],
    ),
    (RandomSensor(name="luck"), [("luck", LINE, "", False)]),
]


@pytest.mark.parametrize(("sensor", "readings"), SENSED, ids=lambda each: type(each).__name__)
def test_readings_of_each_sensor(sensor: Sensor, readings: list[tuple[str, object, str, bool]]) -> None:
    offered = list_readings(with_sensors(sensor))
    assert [(each.name, each.kind, each.unit, each.of_targets) for each in offered] == readings
    assert all(each.doc for each in offered)


def test_time_since_a_blob_is_of_a_target_and_time_since_a_bump_is_not() -> None:
    sensors = (
        ElapsedSensor(name="unseen", of="blob_x"),
        Camera(),
        Bumper(),
        ElapsedSensor(name="unhit", of="bumper"),
    )
    offered = {each.name: each for each in list_readings(with_sensors(*sensors))}
    assert (offered["unseen"].of_targets, offered["unseen"].unit) == (True, "s")
    assert (offered["unhit"].of_targets, offered["unhit"].unit) == (False, "s")


def test_two_types_share_a_reading_and_a_behavior() -> None:
    one = RobotType(sensors=(TargetLocator(), StallSensor()), behaviors={"go": {"drive": 1.0}})
    other = RobotType(
        sensors=(StallSensor(), PoseSensor()), behaviors={"go": {"drive": 1.0}, "spin": {"turn": 1.0}}
    )
    scenario = replace(with_sensors(), types={"one": one, "other": other})
    assert [each.name for each in list_readings(scenario)][:3] == ["range", "bearing", "stuck"]
    assert list(make_scenario_kit(scenario).behaviors) == ["go", "spin"]


def test_one_name_must_mean_one_command() -> None:
    one, other = RobotType(behaviors={"go": {"drive": 1.0}}), RobotType(behaviors={"go": {"drive": 0.5}})
    scenario = replace(with_sensors(), types={"one": one, "other": other})
    with pytest.raises(SettingError, match=r"types\.other\.behaviors\.go"):
        make_scenario_kit(scenario)


def test_features_of_a_kit() -> None:
    scenario = replace(
        with_sensors(TargetLocator(), Camera(), StallSensor()),
        features={
            "wedged": FeatureSpec(reading="stuck", doc="It got nowhere."),
            "ball_x": FeatureSpec(reading="blob_x"),
            "ball_left": FeatureSpec(reading="blob_x"),
        },
    )
    kit = make_scenario_kit(scenario)
    assert list(kit.features) == [
        "distance_to", "angle_to", "ball_x", "ball_left", "blob_size", "wedged", "done", "failed", "time_in_state",
    ]  # fmt: skip
    assert kit.features["distance_to"] == Feature(
        "distance_to", LINE, "range", of="A", unit="m", doc="How far the target is; absent if none."
    )
    assert kit.features["wedged"] == Feature("wedged", BOOLEAN, "stuck", doc="It got nowhere.")
    assert kit.features["ball_x"].parameters == ("A",)
    assert kit.features["done"] == FlagFeature("done")
    assert kit.features["time_in_state"] == TimeInState()


def test_targets_and_their_words() -> None:
    targets = {
        "food": TargetSpec(nearest="food"),
        "third": TargetSpec(object="food", index=2),
        "mate": TargetSpec(robot="teammate"),
        "anyone": TargetSpec(robot="any"),
        "them": TargetSpec(team="blues"),
        "red": TargetSpec(color="red"),
        "told": TargetSpec(color="red", doc="Whatever is hot."),
    }
    docs = [target.doc for target in make_targets(replace(with_sensors(), targets=targets))]
    assert docs == [
        "The nearest food.",
        "The food, number 3.",
        "The nearest teammate.",
        "The nearest robot.",
        "The nearest robot of the team blues.",
        "Whatever is red.",
        "Whatever is hot.",
    ]


def test_food_is_loaded_where_some_robot_carries_it() -> None:
    plain = with_sensors()
    assert [channel.name for channel in make_channels(plain)] == ["drive", "turn"]
    carriers = replace(plain, types={**plain.types, "truck": RobotType(capacity=3)})
    assert [channel.name for channel in make_channels(carriers)] == ["drive", "turn", "load", "unload"]


def test_behaviors_say_what_they_do() -> None:
    kit = make_scenario_kit(load_scenario("patrol"))
    assert kit.behaviors["forwards"].command == Command(drive=1.0)
    assert kit.behaviors["forwards"].doc == "Drive ahead."
    assert kit.behaviors["stop"].doc == "Stand still."
    assert make_scenario_kit(load_scenario("arena")).behaviors["veer_right"].doc == "Drive ahead, turn right."


def test_foraging_comes_with_the_names_that_lessons_use() -> None:
    """Lessons name features, behaviors and targets: those of today's kit are all there, of the same kinds."""
    kit = make_scenario_kit(load_scenario("forage"))
    found = {name: str(kit.features[name].kind) for name in FORAGING}
    assert found == {name: str(kind) for name, (kind, _) in FORAGING.items()}
    readings = {name: getattr(kit.features[name], "reading", None) for name in FORAGING}
    assert readings == {name: reading for name, (_, reading) in FORAGING.items()}
    assert {name: dict(each.command) for name, each in kit.behaviors.items()} == {
        "forward": {"drive": 1.0},
        "rotate_left": {"turn": 1.0},
        "rotate_right": {"turn": -1.0},
        "load_food": {"load": 1.0},
        "unload_food": {"unload": 1.0},
    }
    assert set(kit.targets) == {"station", "nearest_food"}


FORAGING: dict[str, tuple[Kind, str | None]] = {
    "distance_to": (Continuous(), "range"),
    "angle_to": (Toroidal(), "bearing"),
    "food_below_me": (Continuous(), "food_here"),
    "food_stored": (Continuous(), "food_stored"),
    "food_left": (BOOLEAN, "food_left"),
    "at_station": (BOOLEAN, "station_here"),
    "done": (BOOLEAN, None),
}


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_every_reading_of_a_built_in_scenario_is_a_feature(name: str) -> None:
    scenario = load_scenario(name)
    features = make_scenario_kit(scenario).features.values()
    read = {feature.reading for feature in features if isinstance(feature, Feature)}
    assert read == {reading.name for reading in list_readings(scenario)}
    assert all(reading.doc for reading in list_readings(scenario))
