"""Find the library of an automaton that is exported, and the body that it is for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from understudy.errors import SettingError
from understudy.export.body_interface import BodyInterface, describe_kit
from understudy.model.library import Library

if TYPE_CHECKING:
    from understudy.export.body_interface import RobotInterface
    from understudy.model.library import Kit
    from understudy.sim.scenario.schema import Scenario


def open_library_to_export(
    folder: Path, name: str, world: str | None, kit: str | None
) -> tuple[Library, str, BodyInterface]:
    """Open the library of an automaton named NAME or SORT/NAME; also return its own name, and its body.

    Without a world, the first built-in scenario that fits is taken, or the kit alone if one is named. The same goes for
    a function that makes a body: it has no scenario.
    """
    from understudy.sim.kit import list_readings, make_channels
    from understudy.ui.cli.library_data import find_fitting_world
    from understudy.ui.cli.options import find_kit, find_optional_scenario

    named = world or (find_fitting_world(folder) if kit is None else None)
    where = find_optional_scenario(named)
    library, name = _open_library(folder, name, where, find_kit(kit, named or ""))
    if where is None:
        return library, name, describe_kit(library)
    if _is_for_coordinators(library):
        return library, name, describe_kit(library, tick_s=where.tick_s)
    body = BodyInterface(tuple(list_readings(where)), make_channels(where), where.tick_s)
    return library, name, body


def open_library_for_robot(
    folder: Path, name: str, robot: Path, world: str | None, kit: str | None
) -> tuple[Library, str, RobotInterface]:
    """Open the library of an automaton for the robot of a file, whose world it is taught in.

    A world is named only if the file names none; without either, the first built-in scenario that fits is taken.
    """
    from understudy.export.body_interface import describe_robot
    from understudy.robots.robot import find_robot_scenario
    from understudy.robots.robot_file import load_robot
    from understudy.sim.kit import make_scenario_kit
    from understudy.ui.cli.library_data import find_fitting_world
    from understudy.ui.cli.options import find_kit, open_scenario
    from understudy.ui.cli.robot_options import find_robots_file

    file = load_robot(robot)
    where, _ = find_robot_scenario(file, robot)
    if where is not None:
        find_robots_file(robot, None, world=world)
    else:
        where = open_scenario(world or find_fitting_world(folder))
    parts = make_scenario_kit(where) if kit is None else find_kit(kit, "")
    library, name = _open_library(folder, name, where, parts)
    if _is_for_coordinators(library):
        problem = f"is for one robot, and {name!r} coordinates a squad"
        raise SettingError(where="--robot", setting=str(robot), problem=problem, remedy="leave it out")
    return library, name, describe_robot(file, path=robot, scenario=where if file.world is None else None)


def _open_library(folder: Path, name: str, where: Scenario | None, parts: Kit) -> tuple[Library, str]:
    from understudy.ui.cli.library_data import find_listed, open_all_libraries
    from understudy.ui.cli.options import import_learner

    listings = open_all_libraries(folder, where, parts, import_learner())
    prefix, name = find_listed(listings, name)
    listing = listings[prefix]
    if name not in listing.opened:
        raise listing.problems[f"{name}.json"]
    return listing.library, name


def _is_for_coordinators(library: Library) -> bool:
    return any(each.order is not None for each in library.kit.behaviors.values())
