"""Find the library of an automaton that is exported, and the body that it is for."""

from __future__ import annotations

from pathlib import Path

from understudy.export.body_interface import BodyInterface, describe_kit
from understudy.model.library import Library


def open_library_to_export(
    folder: Path, name: str, world: str | None, kit: str | None
) -> tuple[Library, str, BodyInterface]:
    """Open the library of an automaton named NAME or SORT/NAME; also return its own name, and its body.

    Without a world, the first built-in scenario that fits is taken, or the kit alone if one is named.
    """
    from understudy.sim.kit import list_readings, make_channels, make_scenario_kit
    from understudy.ui.cli.library_data import find_fitting_world, find_listed, open_all_libraries
    from understudy.ui.cli.options import find_kit, import_learner, open_scenario

    where = None
    if world is not None or kit is None:
        where = open_scenario(world or find_fitting_world(folder))
    parts = make_scenario_kit(where) if kit is None and where is not None else find_kit(kit, "")
    listings = open_all_libraries(folder, where, parts, import_learner())
    prefix, name = find_listed(listings, name)
    listing = listings[prefix]
    if name not in listing.opened:
        raise listing.problems[f"{name}.json"]
    if where is None:
        return listing.library, name, describe_kit(listing.library)
    if any(each.order is not None for each in listing.library.kit.behaviors.values()):
        return listing.library, name, describe_kit(listing.library, tick_s=where.tick_s)
    body = BodyInterface(tuple(list_readings(where)), make_channels(where), where.tick_s)
    return listing.library, name, body
