"""The picture of physics in the documents, drawn anew: python -m tests.sim_mujoco.pictures"""

from __future__ import annotations

from pathlib import Path

from msgspec.structs import replace
from tests.sim_mujoco.world_image import render_with_camera_inset, save_png

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.sim.scenario.files import load_scenario

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "physics.png"
SEED, ROBOT = 54, 3
"""Where a robot sees a teammate, home, the boss and an intruder, which are all there from the beginning."""


def patrol() -> MujocoBody:
    """The patrol with everybody there."""
    scenario = load_scenario("patrol")
    objects = tuple(replace(each, presence=None, capture=None) for each in scenario.objects)
    return MujocoBody(replace(scenario, objects=objects), [SEED])


if __name__ == "__main__":
    save_png(render_with_camera_inset(patrol(), ROBOT), PICTURE)
