"""Markers: places that a person marks in a running world, for robots to refer to; at first there is none.

Every world that is found by its name, or as a file, has room for some (`spare_objects`), and the target
`nearest_marker`: what is sensed of it is absent until one is placed.
"""

from __future__ import annotations

from msgspec.structs import replace

from understudy.sim.params import names_of
from understudy.sim.scenario.schema import Objects, Scenario, TargetOf

MARKER = "marker"
TARGET = "nearest_marker"
COLORS = ("magenta", "orange", "cyan", "purple", "yellow", "white")
"""What cameras know it by: the first that nothing else in the world has."""
RADIUS = 0.15


def with_markers(scenario: Scenario) -> Scenario:
    """The scenario with a class of markers and the target of that name, as far as it has none of its own."""
    objects, targets = scenario.objects, dict(scenario.targets)
    if MARKER not in (thing.name for thing in objects):
        taken = names_of(scenario).colors
        color = next((color for color in COLORS if color not in taken), None)
        objects = (*objects, Objects(name=MARKER, count=0, radius=RADIUS, color=color))
    targets.setdefault(
        TARGET, TargetOf(nearest=MARKER, doc="The nearest of the markers that somebody placed.")
    )
    return replace(scenario, objects=objects, targets=targets)


def without_markers(scenario: Scenario) -> Scenario:
    """The scenario as it was `with_markers`; as it is where its markers are its own."""
    objects = tuple(thing for thing in scenario.objects if thing.name != MARKER)
    targets = {name: target for name, target in scenario.targets.items() if name != TARGET}
    stripped = replace(scenario, objects=objects, targets=targets)
    return stripped if with_markers(stripped) == scenario else scenario
