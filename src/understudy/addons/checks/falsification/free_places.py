"""Free places in an arena for things at wanted places, kept apart as in worlds that a seed lays out."""

from __future__ import annotations

from math import cos, hypot, sin, sqrt

from understudy.errors import SettingError
from understudy.sim.layout.clearance import (
    is_point_in_polygon,
    list_edges,
    list_wall_segments,
    measure_point_to_segment,
    place_polygon,
)
from understudy.sim.scenario.schema import Obstacle, Scenario
from understudy.sim.scenario.validate_places import list_placed

TURN = 2.399963229728653
"""The golden angle, rad, by which places around a wanted one are tried."""

TRIES = 1_500
"""The number of places that are tried, up to the whole arena away."""

TINY = 1e-7
"""The distance, m, by which things are kept further apart than they need, so that rounding makes no overlap."""


class FreePlaces:
    """The places of a scenario that are taken, and those that are free.

    Parameters
    ----------
    scenario
        The scenario, whose walls and things at given places are in the way.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._name, self._size = scenario.name, scenario.size
        self._walls = tuple(list_wall_segments(scenario))
        self._polygons = []
        self._taken: list[tuple[float, float, float, float]] = []
        for _, thing, radius in list_placed(scenario):
            if not isinstance(thing.at, tuple):
                continue
            for place in thing.at:
                if isinstance(thing, Obstacle) and thing.points is not None:
                    self._polygons.append(place_polygon(thing.points, place))
                else:
                    self._taken.append((place[0], place[1], radius, thing.apart))

    def take(
        self,
        wanted: tuple[float, float],
        radius: float,
        apart: float,
        box: tuple[float, float, float, float],
        circle: float | None,
        *,
        key: str,
    ) -> tuple[float, float]:
        """Take the free place nearest to a wanted one, of those tried; SettingError if there is none.

        Parameters
        ----------
        wanted
            The place, m.
        radius
            The radius of the thing, m.
        apart
            The free space around it, m.
        box
            The region of possible places, (x0, y0, x1, y1), m.
        circle
            The radius of the circle in that region to which places are limited, m. None: the whole box.
        key
            The key of the thing in the scenario, for the error.

        Returns
        -------
        tuple[float, float]
            The place, m, which is taken from now on.
        """
        step = hypot(*self._size) / sqrt(TRIES)
        for number in range(TRIES):
            away, angle = (
                0.5 * step * sqrt(number) if number < 300 else step * sqrt(number - 225),
                TURN * number,
            )
            x = min(max(wanted[0] + away * cos(angle), box[0]), box[2])
            y = min(max(wanted[1] + away * sin(angle), box[1]), box[3])
            if self._is_free(x, y, radius, apart, box, circle):
                self._taken.append((x, y, radius, apart))
                return x, y
        raise SettingError(
            where=f"scenario {self._name!r}",
            setting=f"{key}.count",
            problem="does not fit: no free place was found",
            remedy="give fewer or smaller things, less `apart`, or a larger size or region",
        )

    def _is_free(
        self,
        x: float,
        y: float,
        radius: float,
        apart: float,
        box: tuple[float, float, float, float],
        circle: float | None,
    ) -> bool:
        x_middle, y_middle = 0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])
        if circle is not None and hypot(x - x_middle, y - y_middle) > circle:
            return False
        for other_x, other_y, other_radius, other_apart in self._taken:
            least = radius + other_radius + max(apart, other_apart) + TINY
            if (x - other_x) ** 2 + (y - other_y) ** 2 < least * least:
                return False
        least = radius + apart + TINY
        if any(measure_point_to_segment((x, y), wall) < least for wall in self._walls):
            return False
        return not any(
            is_point_in_polygon((x, y), corners)
            or any(measure_point_to_segment((x, y), edge) < least for edge in list_edges(corners))
            for corners in self._polygons
        )
