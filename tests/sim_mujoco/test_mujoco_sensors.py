"""Sonar and cameras of physics beside those of the 2-D world, in the same worlds at the same places."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim_mujoco.drawing import draws
from tests.sim_mujoco.pictures import ROBOT, patrol
from tests.sim_mujoco.world_image import INSET, SIZE_PX, render_with_camera_inset, save_png

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.materials import PAINTS, choose_material_color, derive_camera_color
from understudy.addons.bridges.mujoco.robot_files import calibrate_camera_colors
from understudy.addons.robots.camera.blobs import BlobDetector
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Camera as Simulated
from understudy.sim.scenario.schema import Lidar, RobotType, Scenario, Sonar


def plain(name: str) -> Scenario:
    """A scenario whose sensors have no noise, and all of whose objects are there from the beginning."""
    scenario = load_scenario(name)
    return replace(
        scenario,
        types={each: replace(kind, sensors=_noiseless(kind)) for each, kind in scenario.types.items()},
        objects=tuple(replace(each, presence=None, capture=None) for each in scenario.objects),
    )


def _noiseless(kind: RobotType) -> tuple[Any, ...]:
    return tuple(
        replace(each, noise=0.0)
        if isinstance(each, Sonar)
        else replace(each, noise_x=0.0, noise_size=0.0, misses=0.0)
        if isinstance(each, Simulated)
        else each
        for each in kind.sensors
    )


@pytest.mark.parametrize("name", ["arena", "patrol"])
def test_sonar_hears_what_the_2d_sonar_hears(name: str) -> None:
    """Rays 2.5 degrees apart miss a corner or a rim by centimeters now and then, never more."""
    apart = []
    for seed in range(12):
        body = MujocoBody(plain(name), [seed])
        keys = [(each.name, None) for each in body.readings if each.name.startswith("sonar")]
        flat, found = body.world.sense(keys), body.sense(keys)
        apart += [np.abs(flat[key] - found[key]) for key in keys]
    errors = np.concatenate(apart)
    assert np.median(errors) < 0.002
    assert errors.max() < 0.15


def test_lidar_measures_what_the_2d_lidar_measures() -> None:
    """Rays are the same rays; what they hit is to a millimeter, but for rims of round obstacles."""
    lidar = Lidar(view_deg=270.0, beams=55, range=4.0, sectors={"front": (-45.0, 45.0)}, clear=0.8)
    scenario = plain("arena")
    kinds = {name: replace(kind, sensors=(lidar,)) for name, kind in scenario.types.items()}
    scenario = replace(scenario, types=kinds, features={}, targets={})
    beams, nearest, openings = list[float](), list[float](), list[float]()
    for body in (MujocoBody(scenario, [seed]) for seed in range(6)):
        keys = [(each.name, None) for each in body.readings]
        flat, found = body.world.sense(keys), body.sense(keys)
        for name, _ in keys:
            apart = np.abs(flat[name, None] - found[name, None])
            group = nearest if name == "front" else openings if name == "front_width" else beams
            group += [] if name == "front_bearing" else apart.tolist()
        bearing = flat["front_bearing", None] - found["front_bearing", None]
        assert (np.isnan(bearing) | (np.abs(np.sin(bearing / 2)) < 0.05)).mean() > 0.8
    assert len(beams) == 6 * 55
    assert np.median(beams) < 0.001
    assert np.quantile(beams, 0.98) < 0.02
    assert np.median(nearest) < 0.01
    assert np.median(openings) < 0.05


def test_noise_of_one_sensor_is_not_that_of_another() -> None:
    """Two lidars that look the same way measure the same; what noise adds is drawn for each."""
    scenario = plain("arena")
    lidars = tuple(Lidar(beams=36, range=20.0, noise=0.1, name=name) for name in ("lower", "upper"))
    kinds = {name: replace(kind, sensors=lidars) for name, kind in scenario.types.items()}
    body = MujocoBody(replace(scenario, types=kinds, features={}, targets={}), [0])
    found = body.sense([(each.name, None) for each in body.readings])
    apart = [found[f"lower_{k}", None][0] - found[f"upper_{k}", None][0] for k in range(36)]
    assert np.std(apart) == pytest.approx(0.1 * np.sqrt(2), rel=0.4)


@draws
def test_cameras_see_what_the_2d_camera_sees() -> None:
    """Of what is large and not hidden: its middle to a pixel, its size to a tenth, in the median to 3 %."""
    pairs = []
    for seed in range(12):
        body = MujocoBody(plain("patrol"), [seed])
        for target in ("teammate", "intruder", "boss"):
            keys = [("blob_x", target), ("blob_size", target)]
            flat, found = body.world.sense(keys), body.sense(keys)
            pairs += [np.stack([flat[keys[0]], found[keys[0]], flat[keys[1]], found[keys[1]]], axis=1)]
    x, x_found, size, size_found = np.concatenate(pairs).T
    both = ~np.isnan(x) & ~np.isnan(x_found)
    assert both.sum() > 25
    assert (np.isnan(x_found) & (size > 40)).sum() == 0
    assert (np.isnan(x) & ~np.isnan(x_found)).sum() == 0
    assert np.median(np.abs(x - x_found)[both]) < 0.5
    assert np.median((size_found / size)[both]) == pytest.approx(1.0, abs=0.03)


@draws
def test_the_ball_is_where_it_is_from_all_sides() -> None:
    """Ahead, 20 degrees to each side, and behind; as large as 2-D has it. A wrong sign anywhere shows here."""
    body = MujocoBody(plain("soccer"), [0])
    ball = body.view().objects
    x, y = float(ball.x[0]), float(ball.y[0])
    away = 1.5 if x < 4.5 else -1.5
    toward = np.pi if away > 0 else 0.0
    keys = [("blob_x", "ball"), ("blob_size", "ball")]
    for turned, expected in ((0.0, 80.0), (-0.35, 80.0 - 50.6), (0.35, 80.0 + 50.6)):
        body.place(0, x + away, y, toward + turned)
        found = body.sense(keys)
        assert found[keys[0]][0] == pytest.approx(expected, abs=1.0)
        assert found[keys[1]][0] == pytest.approx(float(body.world.sense(keys)[keys[1]][0]), rel=0.15)
    body.place(0, x + away, y, toward + np.pi)
    assert np.isnan(body.sense(keys)[keys[0]][0])


def test_no_color_is_taken_for_another() -> None:
    """But for orange and brown, violet and purple, pink, which are one color in other light."""
    image = np.array([[[round(255 * part) for part in PAINTS[name]] for name in KNOWN] * 3] * 9, np.uint8)
    masks = BlobDetector({name: derive_camera_color(name) for name in KNOWN}).masks(
        np.repeat(image, 9, axis=1)
    )
    for number, name in enumerate(KNOWN):
        seen = [each[4, 9 * number + 4] > 0 for each in masks.values()]
        assert [other for other, yes in zip(KNOWN, seen, strict=True) if yes] == [name]


KNOWN = ["red", "orange", "yellow", "green", "cyan", "blue", "purple", "magenta", "white", "black"]


def test_colors_no_one_foresaw_are_painted_all_the_same() -> None:
    assert choose_material_color("#336699") == (0.2, 0.4, 0.6)
    assert choose_material_color("mauve") == choose_material_color("mauve")
    assert choose_material_color("mauve") in PAINTS.values()


def test_a_film_widens_the_colors_behind_it_towards_its_own() -> None:
    """Green goes to blue, and red to blue on the other side."""
    bare, behind = (
        calibrate_camera_colors(load_scenario("soccer"), "humanoid")["ball"],
        calibrate_camera_colors(load_scenario("patrol"), "pioneer"),
    )
    assert bare == derive_camera_color("orange")
    assert list(behind["intruder"].hue_deg) == pytest.approx([120.0, 168.6], abs=0.1)
    assert list(behind["teammate"].hue_deg) == pytest.approx([328.1, 12.0], abs=0.1)


@draws
def test_the_picture_of_the_documents_shows_what_the_robot_sees(tmp_path: Path) -> None:
    """The arena, with four red robots; in the corner the camera's own pixels, three times as large; small on disk."""
    body = patrol()
    image, seen = render_with_camera_inset(body, ROBOT), body.image(ROBOT)
    assert seen is not None
    assert image.shape == (SIZE_PX[1], SIZE_PX[0], 3)
    wide = round(INSET * SIZE_PX[0])
    inset = image[: round(wide * 0.75), -wide:]
    assert len(np.unique(inset.reshape(-1, 3), axis=0)) == len(np.unique(seen.reshape(-1, 3), axis=0))
    reds = BlobDetector({"it": derive_camera_color("red")}).masks(image[:, :600])["it"]
    assert (reds > 0).sum() > 1000
    save_png(image, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size < 100_000
