"""Lidars: distances along beams, and what they are summed up to in sectors."""

from __future__ import annotations

import os
import subprocess
import sys
from math import cos, inf, isnan, nan, pi, radians, sin, sqrt
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.sim.test_sensing import rays, read, read_repeatedly, world_of

from understudy.addons.robots.robot_file import ReadingSpec
from understudy.addons.robots.ros.message_readings import make_extractor
from understudy.errors import FileError, SettingError
from understudy.records.messages import decode_message, encode_message, make_message
from understudy.sim.kit import list_readings
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.scenario.schema import ElapsedSensor, Lidar, Obstacle, RobotType, Wall
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.sensing.range_sensors import SCAN
from understudy.sim.sensing.sectors import find_nearest_beam, measure_widest_opening
from understudy.sim.sensing.sensor_table import find_sensor_row
from understudy.sim.world import World

STEP = radians(10.0)
POINT = 2 * sin(STEP / 2)  # how wide 10 degrees are at 1 m

OPENINGS: list[
    tuple[list[float], float]
] = [  # distances 10 degrees apart; how wide the widest opening of 1 m is
    ([2.0, 2.0, 2.0], 2 * sin(STEP)),  # no borders: from edge to edge at 1 m
    ([0.5, 0.5, 0.5], 0.0),
    ([0.5, 2.0, 0.5], 2 * 0.5 * sin(STEP)),  # between both returns
    ([0.5, 2.0, 2.0], sqrt(0.25 + 1 - cos(2 * STEP))),  # from a return to the sector's edge at 1 m
    ([2.0, 0.5, 2.0], sqrt(0.25 + 1 - cos(STEP))),
    ([nan, 2.0, 2.0], POINT),  # where there is no answer it ends on its own beam
    ([nan, nan, nan], 0.0),
    ([0.9, 2.0, 0.9, 0.5, 2.0, 0.5], 2 * 0.9 * sin(STEP)),  # the wider of two
    ([1.0, 1.0], POINT),  # as far as it has to be
]


@pytest.mark.parametrize(("far", "width"), OPENINGS)
def test_widest_opening(far: list[float], width: float) -> None:
    found = measure_widest_opening(far, 0, len(far), 36, STEP, 0.0, 1.0)
    assert found == pytest.approx(width)


def test_openings_around_a_robot() -> None:
    """A scan all around has no ends: an opening behind is one, and half a circle or more counts across."""
    free, four = 2.0, 2 * pi / 4
    assert measure_widest_opening([free] * 4, 0, 4, 4, four, 0.2, 1.0) == pytest.approx(2.4)
    assert measure_widest_opening([free, 0.8, free, free], 0, 4, 4, four, 0.2, 1.0) == pytest.approx(2.0)
    behind = [free, 0.8, 0.8, free]  # between the third beam and the second, over the end of the list
    assert measure_widest_opening(behind, 0, 4, 4, four, 0.2, 1.0) == pytest.approx(2.0)
    narrow = [0.8, free, 0.8, 0.8]
    assert measure_widest_opening(narrow, 0, 4, 4, four, 0.2, 1.0) == pytest.approx(2.0)


def test_what_a_view_leaves_out_is_no_opening() -> None:
    """36 beams in 355 degrees: those at its ends are 5 degrees apart, and no row; in 350 degrees they are neighbors."""
    far = [2.0, *[0.8] * 34, 2.0]
    assert measure_widest_opening(far, 0, 36, 36, radians(355 / 35), 0.0, 1.0) < 0.3
    assert measure_widest_opening(far, 0, 36, 36, radians(350 / 35), 0.0, 1.0) == pytest.approx(
        2 * 0.8 * sin(1.5 * STEP)
    )


@given(
    far=st.lists(st.sampled_from([nan, 0.3, 0.7, 1.5, 3.0]), min_size=3, max_size=12),
    turned=st.integers(0, 11),
)
def test_a_scan_all_around_has_no_beginning(far: list[float], turned: int) -> None:
    turned %= len(far)
    spacing = 2 * pi / len(far)
    one = measure_widest_opening(far, 0, len(far), len(far), spacing, 0.1, 1.0)
    other = measure_widest_opening(far, turned, len(far), len(far), spacing, 0.1, 1.0)
    assert one == pytest.approx(other)


NEAREST: list[tuple[list[float], int, int, int]] = [  # distances, first beam, how many; which is nearest
    ([3.0, 1.0, 2.0], 0, 3, 1),
    ([3.0, 1.0, 2.0], 2, 2, 2),  # the last and, over the end, the first
    ([nan, nan, 2.0], 0, 3, 2),
    ([nan, nan, 2.0], 0, 2, -1),
    ([1.0, 1.0, 2.0], 0, 3, 0),
]


@pytest.mark.parametrize(("far", "first", "count", "beam"), NEAREST)
def test_nearest_beam(far: list[float], first: int, count: int, beam: int) -> None:
    assert find_nearest_beam(far, first, count, 3) == beam


# In worlds: robots of 0.2 m at (5, 4) in an arena of 10 m x 8 m, looking along x.

DOOR = (
    Wall(points=((6.0, 0.0), (6.0, 3.6))),
    Wall(points=((6.0, 4.4), (6.0, 8.0))),
)


def test_a_door_is_as_wide_as_it_is() -> None:
    lidar = Lidar(view_deg=180.0, beams=721, range=6.0, sectors={"ahead": (-60.0, 60.0)}, clear=1.5)
    world = world_of(lidar, walls=DOOR)
    assert read(world, "ahead_width") == pytest.approx(0.8, abs=0.02)
    assert read(world, "ahead") == pytest.approx(sqrt(1.0 + 0.4**2) - 0.2, abs=0.01)  # at a post
    bearing = read(world, "ahead_bearing")
    assert min(bearing, 2 * pi - bearing) == pytest.approx(np.arctan2(0.4, 1.0), abs=0.01)


def test_beams_sectors_and_what_is_not_there() -> None:
    lidar = Lidar(beams=4, range=4.5, sectors={"front": (-45.0, 45.0), "left": (90.0, 90.0)})
    world = world_of(lidar)  # beams behind, to the right, ahead, to the left
    beams = [read(world, f"beam_{number}") for number in range(4)]
    assert beams == pytest.approx([4.5, 3.8, 4.5, 3.8])
    assert read(world, "front") == 4.5
    assert isnan(read(world, "front_bearing"))  # nothing is there
    assert read(world, "left") == pytest.approx(3.8)
    assert read(world, "left_bearing") == pytest.approx(pi / 2)


@pytest.mark.parametrize("view_deg", [90.0, 359.0, 360.0])
def test_a_single_beam_looks_ahead(view_deg: float) -> None:
    lidar = Lidar(view_deg=view_deg, beams=1, range=8.0, sectors={"front": (-30.0, 30.0)})
    world = world_of(lidar, obstacles=(Obstacle(radius=0.5, at=((7.0, 4.0),)),))
    check_scenario(world.scenario)
    assert read(world, "beam_0") == read(world, "front") == pytest.approx(1.3)
    assert read(world, "front_bearing") == 0.0


REFLECTING: list[tuple[Literal["walls", "obstacles", "robots"], float]] = [
    ("obstacles", 1.3),
    ("walls", 4.8),
    ("robots", 8.0),
]


@pytest.mark.parametrize(("what", "ahead"), REFLECTING)
def test_only_what_reflects(what: Literal["walls", "obstacles", "robots"], ahead: float) -> None:
    in_front = Obstacle(radius=0.5, at=((7.0, 4.0),))
    world = world_of(Lidar(beams=4, range=8.0, sees=(what,)), obstacles=(in_front,))
    assert read(world, "beam_2") == pytest.approx(ahead)


@pytest.mark.parametrize("seed", range(8))
def test_beams_are_rays(seed: int) -> None:
    """Each on its own against all there is, and sectors against their definition."""
    random = np.random.default_rng(seed)
    drawn = random.uniform((2, 2.2), (8, 7), (30, 2)).tolist()
    places = [(x, y) for x, y in drawn if abs(x - 5) + abs(y - 4) > 1][:8]
    view = float(random.choice([360.0, 270.0, 90.0]))
    lidar = Lidar(
        view_deg=view, beams=int(random.integers(8, 90)), range=3.0, clear=0.8,
        sectors={"front": (-40.0, 40.0), "left": (10.0, 45.0)},
    )  # fmt: skip
    at = ((5.0, 4.0, float(random.uniform(0, 360))),)
    world = world_of(lidar, at=at, obstacles=(Obstacle(radius=0.3, at=tuple(places)),), walls=DOOR)
    scan = _scan(world, lidar)
    angles = np.radians([arc.from_deg for arc in scan.arcs])
    expected = (rays(world, 0, lidar, angles) - 0.2).clip(0.0, 3.0)  # type: ignore[arg-type]
    percept = {name: read(world, name) for name in _names(lidar)}
    found = np.array([percept[arc.reading] for arc in scan.arcs])
    assert found == pytest.approx(expected, abs=1e-9)
    for name, value in scan.summarize(found.tolist()).items():
        assert percept[name] == pytest.approx(value, abs=1e-9, nan_ok=True), name


def _scan(world: World, lidar: Lidar) -> Any:
    scan = find_sensor_row(lidar).scan
    assert scan is not None
    return scan(lidar, world.scenario.types["scout"])


def _names(lidar: Lidar) -> list[str]:
    return [reading.name for reading in find_sensor_row(lidar).readings(lidar)]


def test_noise_and_dropout_come_before_summing_up() -> None:
    lidar = Lidar(beams=8, range=8.0, noise=0.05, dropout=0.2, sectors={"all": (-180.0, 180.0)})
    world = world_of(lidar)
    values = read_repeatedly(world, "beam_4", 3000)
    there = values[~np.isnan(values)]
    assert np.isnan(values).mean() == pytest.approx(0.2, abs=0.03)
    assert there.mean() == pytest.approx(4.8, abs=0.006)
    assert there.std() == pytest.approx(0.05, rel=0.06)
    for _ in range(50):
        far = [read(world, f"beam_{number}") for number in range(8)]
        assert read(world, "all") == np.nanmin(far)
        world.act({})


def test_slow_lidar_keeps_its_answers() -> None:
    lidar = Lidar(beams=8, range=8.0, noise=0.05, rate_hz=2.0, sectors={"front": (-50.0, 50.0)})
    world = world_of(lidar)
    for name in ("beam_4", "front", "front_bearing", "front_width"):
        values = read_repeatedly(world, name, 20)
        assert (values.reshape(-1, 5) == values[::5, None]).all(), name


def test_a_reading_asked_for_twice_and_a_time_since() -> None:
    lidar = Lidar(beams=36, range=3.0, sectors={"front": (-50.0, 50.0)})
    world = world_of(lidar)
    twice = world.sense([("beam_35", None), ("beam_35", None), ("front", None), ("beam_0", None)])
    assert twice["front", None][0] == read(world, "front")
    assert twice["beam_35", None][0] == read(world, "beam_35")
    scout = RobotType(sensors=(lidar, ElapsedSensor(name="since", of="front")))
    with pytest.raises(SettingError, match="no such reading of a target"):  # nor is it yes or no
        check_scenario(replace_type(world, scout))


def replace_type(world: World, scout: RobotType) -> Any:
    import msgspec

    types = {**world.scenario.types, "scout": scout}
    return msgspec.structs.replace(world.scenario, types=types)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"view_deg": 0.0}, "sensors[0].view_deg is 0.0; give more than 0 and up to 360 degrees"),
    ({"view_deg": 361.0}, "sensors[0].view_deg is 361.0; give more than 0 and up to 360 degrees"),
    ({"beams": 0}, "sensors[0].beams is 0; give 1 to 2048 beams"),
    ({"beams": 2049}, "sensors[0].beams is 2049; give 1 to 2048 beams"),
    ({"range": 0.0}, "sensors[0].range is 0.0; give a number above 0"),
    ({"range": inf}, "sensors[0].range is inf"),
    ({"noise": -1.0}, "sensors[0].noise is -1.0; give 0 or more"),
    ({"clear": 0.0}, "sensors[0].clear is 0.0; give a number above 0"),
    ({"range": 0.5, "sectors": {"a": (0.0, 90.0)}}, "sensors[0].clear is 1, and no beam reaches that far"),
    ({"sees": ()}, "sensors[0].sees is empty"),
    ({"dropout": 2.0}, "sensors[0].dropout is 2.0"),
    ({"sectors": {"a": (10.0, 0.0)}}, "sensors[0].sectors.a is [10.0, 0.0]"),
    ({"sectors": {"a": (1.0, 2.0)}}, "sensors[0].sectors.a is [1.0, 2.0], which is not one row of beams"),
    ({"view_deg": 90.0, "sectors": {"a": (90.0, 120.0)}}, "which is not one row of beams in a view of 90 degrees"),
    ({"view_deg": 270.0, "sectors": {"a": (90.0, 270.0)}}, "which is not one row of beams in a view of 270 degrees"),
    ({"sectors": {"beam_0": (0.0, 90.0)}}, "beam_0"),
    ({"name": "a/b"}, "sensors[0].name has 'a/b'"),
]  # fmt: skip


@pytest.mark.parametrize(("settings", "message"), WRONG)
def test_settings_that_cannot_be(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError) as caught:
        check_scenario(replace_type(world_of(Lidar()), RobotType(sensors=(Lidar(**settings),))))
    assert message in str(caught.value)


def test_unknown_setting_is_refused_as_of_other_sensors() -> None:
    text = format_scenario(world_of(Lidar(beams=40)).scenario)
    with pytest.raises(FileError, match=r"sensors\[0\]\.beam_count: is not a key here; known are .*'beams'"):
        parse_scenario(text.replace("beams = 40", "beam_count = 40"))


def test_files_keep_it() -> None:
    lidar = Lidar(view_deg=240.0, beams=81, name="scan", sectors={"left": (10.0, 90.0)}, rate_hz=5.0)
    scenario = world_of(lidar).scenario
    assert parse_scenario(format_scenario(scenario)) == scenario
    names = [reading.name for reading in list_readings(scenario)]
    assert names[:4] + names[-1:] == ["left", "left_bearing", "left_width", "scan_0", "scan_80"]


# From messages: the same scan as a LaserScan.


@given(
    far=st.lists(st.sampled_from([0.3, 0.8, 1.2, 5.0]), min_size=36, max_size=36),
    low=st.integers(-18, 17),
    wide=st.integers(1, 36),
    backwards=st.booleans(),
)
def test_a_laser_scan_reads_as_the_simulated_lidar(
    far: list[float], low: int, wide: int, *, backwards: bool
) -> None:
    sector = (low * 10.0, min((low + wide) * 10.0, 360.0))
    lidar = Lidar(beams=36, range=5.0, sectors={"some": sector})
    scan = find_sensor_row(lidar).scan
    assert scan is not None
    expected = scan(lidar, RobotType(radius=0.2)).summarize(far)
    ranges = np.array([inf if each == 5.0 else each + 0.2 for each in far], np.float32)
    turn = -1 if backwards else 1
    message = make_message(
        SCAN, angle_min=radians(170.0 if backwards else -180.0), angle_increment=turn * radians(10.0),
        range_max=5.2, ranges=ranges[::turn],
    )  # fmt: skip
    for field, name in ((None, "some"), ("bearing", "some_bearing"), ("width", "some_width")):
        made = make_extractor(
            ReadingSpec(topic="scan", type=SCAN, field=field, sector_deg=sector, offset_m=0.2)
        )
        assert not isinstance(made, DecodeProblem)
        value = made[2](message)
        if field == "bearing" and not isnan(value):
            near = [each for each in range(36) if far[each] == expected["some"]]
            assert any(abs(value - radians(each * 10.0 - 180.0) % (2 * pi)) < 1e-5 for each in near)
        else:
            assert value == pytest.approx(expected[name], abs=1e-5, nan_ok=True)


@pytest.mark.parametrize("reach", [0.7, 0.9, 1.1, 3.9, 4.0, 5.0])
@pytest.mark.parametrize("radius", [0.1, 0.2, 0.35])
def test_as_far_as_it_sees_is_clear(reach: float, radius: float) -> None:
    """Where `clear` is the lidar's range, an opening is where it hits nothing: also in a message of 32-bit floats."""
    lidar = Lidar(beams=36, range=reach, clear=reach, sectors={"front": (-50.0, 50.0)})
    scan = find_sensor_row(lidar).scan
    kind = RobotType(radius=radius)
    assert scan is not None
    (topic,) = find_sensor_row(lidar).topics(lidar, kind)
    message = make_message(SCAN, **topic.make_fields({f"beam_{number}": reach for number in range(36)}))
    made = make_extractor(ReadingSpec(topic="scan", type=SCAN, **topic.readings["front_width"]))
    assert not isinstance(made, DecodeProblem)
    expected = scan(lidar, kind).summarize([reach] * 36)["front_width"]
    assert made[2](decode_message(SCAN, encode_message(SCAN, message))) == pytest.approx(expected, rel=1e-5)


def _read_width(
    sector: tuple[float, float], beams: int, *, first_deg: float, far: float = 2.0, step_deg: float = 1.0
) -> float:
    """The widest opening of 1 m in a scan that measures the same everywhere."""
    message = make_message(
        SCAN, angle_min=radians(first_deg), angle_increment=radians(step_deg), range_max=5.0,
        ranges=np.full(beams, far, np.float32),
    )  # fmt: skip
    made = make_extractor(ReadingSpec(topic="scan", type=SCAN, field="width", sector_deg=sector))
    assert not isinstance(made, DecodeProblem)
    return made[2](message)


def test_an_opening_ends_where_a_scan_does() -> None:
    """A scan of 270 degrees does not see what is behind, whatever sector it is asked for."""
    chord = 2 * sin(radians(45.0) / 2)
    assert _read_width((90.0, 270.0), 271, first_deg=-135.0) == pytest.approx(chord, abs=1e-6)
    seen = [_read_width(sector, 91, first_deg=-45.0) for sector in ((-180.0, 180.0), (0.0, 360.0))]
    assert seen == pytest.approx([2 * sin(radians(45.0))] * 2, abs=1e-6)


def test_the_first_turn_of_a_scan_counts_for_openings() -> None:
    """Beams that are there twice are no wider than once, as are the first and the last of many lidars."""
    once = _read_width((0.0, 60.0), 360, first_deg=0.0)
    assert once == pytest.approx(1.0, abs=1e-6)
    assert _read_width((0.0, 60.0), 420, first_deg=0.0) == pytest.approx(once)
    assert _read_width((-180.0, 180.0), 361, first_deg=-180.0) == pytest.approx(2.0)


def test_modes_of_kernels_agree() -> None:
    """Compiled and as plain Python, bit for bit, with noise, dropout, doors and robots."""
    program = (
        "from tests.sim.test_lidar import run_noisy_world\nimport sys\nsys.stdout.write(run_noisy_world())\n"
    )
    env = {**os.environ, "UNDERSTUDY_KERNELS": "python", "PYTHONPATH": os.pathsep.join(sys.path)}
    plain = subprocess.run(
        [sys.executable, "-c", program], env=env, capture_output=True, text=True, check=True
    )
    assert plain.stdout == run_noisy_world()


def run_noisy_world() -> str:
    """What lidars read in ten ticks, as exact numbers."""
    lidar = Lidar(
        beams=24, range=4.0, noise=0.02, dropout=0.1, sectors={"front": (-50.0, 50.0), "all": (-180.0, 180.0)}
    )
    world = world_of(lidar, at=((5.0, 4.0, 10.0), (5.5, 4.6, 200.0)), walls=DOOR)
    found = []
    keys = [(name, None) for name in _names(lidar)]
    for _ in range(10):
        percept = world.sense(keys)
        found += [value.hex() for key in keys for value in percept[key].tolist()]
        world.act({"drive": np.full(world.agents, 0.5), "turn": np.full(world.agents, 0.3)})
    return " ".join(found)
