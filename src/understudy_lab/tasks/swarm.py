"""The swarm that ships, and the same with many more robots."""

from __future__ import annotations

from functools import cache
from math import ceil, isqrt

from msgspec.structs import replace

from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Objects, Region, Robots, Scenario

ROBOT, SQUAD, PLATOON, SWARM = "puller", "squad", "platoon", "swarm"
EACH = 25
"""Robots of a platoon."""
CELL_M = 20.0
"""How large a place a platoon begins in, with its depot in the middle."""


@cache
def scenario() -> Scenario:
    """The swarm as it ships: eight platoons."""
    return load_scenario("swarm")


def of_platoons(platoons: int) -> Scenario:
    """The same with so many platoons, as square as can be, each in its place with its depot."""
    across = ceil(platoons / isqrt(platoons))
    down = ceil(platoons / across)
    corners = [(CELL_M * (number % across), CELL_M * (number // across)) for number in range(platoons)]
    depots = tuple((x + CELL_M / 2, y + CELL_M / 2) for x, y in corners)
    home, *things = scenario().objects
    share = platoons / len(scenario().robots)
    return replace(
        scenario(),
        size=(CELL_M * across, CELL_M * down),
        regions={
            f"cell_{number}": Region(box=(x + 1, y + 1, x + CELL_M - 1, y + CELL_M - 1))
            for number, (x, y) in enumerate(corners)
        },
        objects=(
            replace(home, at=depots),
            *(replace(thing, count=_share(thing, share)) for thing in things),
        ),
        robots=tuple(Robots(type=ROBOT, count=EACH, within=f"cell_{number}") for number in range(platoons)),
    )


def _share(thing: Objects, share: float) -> int:
    return max(1, round(thing.count * share)) if isinstance(thing.count, int) else 1
