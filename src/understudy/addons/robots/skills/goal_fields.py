"""The goal of a skill as a message: fields from constants and from the places of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from understudy.addons.robots.ros.interfaces import Interfaces
from understudy.addons.robots.skill_file import OF_TARGET, SkillSpec
from understudy.records.messages import BASE, NAMED
from understudy.sim.scenario.toml_decode import DecodeProblem

Locate: TypeAlias = Callable[[str], tuple[float, float] | None]
"""A function that returns the place (x, y) of a target, in m, or None if it is unknown."""


class PlaceUnknown(Exception):
    """A target whose place is unknown at present."""


class GoalFields:
    """The fields of a skill's goal, checked against its type."""

    def __init__(self, skill: SkillSpec, interfaces: Interfaces, type: str) -> None:
        self._skill, self._interfaces, self._type = skill, interfaces, type

    def find_problem(self) -> DecodeProblem | None:
        """Return the first field that the type does not have, or whose value does not fit; None if all are well."""
        for path, value in self._skill.goal.items():
            node_type, of = NAMED, self._type
            for name in path.split("."):
                inside = self._interfaces.list_fields(of) if node_type == NAMED else {}
                if name not in inside:
                    has = f"give one of {', '.join(inside)}" if inside else "end the path before it"
                    return DecodeProblem(f"goal.{path}", f"is no field of {self._type}: no {name!r}", has)
                node_type, of = inside[name]
            if (problem := _find_misfit(node_type, of, value)) is not None:
                return DecodeProblem(f"goal.{path}", problem[0], problem[1])
        return None

    def make(self, binding: Mapping[str, str], locate: Locate) -> Any:
        """Make the goal for targets of the parameters; raise PlaceUnknown if a target's place is unknown."""
        goal = self._interfaces.make(self._type)
        for path, value in self._skill.goal.items():
            *above, last = path.split(".")
            inside = goal
            for name in above:
                inside = getattr(inside, name)
            field_value = self._find_value(value, binding, locate)
            setattr(
                inside, last, float(field_value) if isinstance(getattr(inside, last), float) else field_value
            )
        return goal

    @staticmethod
    def _find_value(value: Any, binding: Mapping[str, str], locate: Locate) -> Any:
        of = OF_TARGET.fullmatch(value) if isinstance(value, str) else None
        if of is None:
            return value
        place = locate(binding[of[1]])
        if place is None or not all(map(isfinite, place)):
            raise PlaceUnknown(f"the place of {binding[of[1]]} is unknown")
        return place["xy".index(of[2])]


def _find_misfit(node_type: int, of: Any, value: Any) -> tuple[str, str] | None:
    """Return problem and remedy if a value does not fit into a field."""
    if node_type != BASE:
        return "is not a single number or text", "give the path of a number, of a text or of a truth"
    kind = of[0]
    from_target = isinstance(value, str) and OF_TARGET.fullmatch(value) is not None
    if kind == "string":
        fits, wanted = isinstance(value, str) and not from_target, "a text"
    elif kind == "bool":
        fits, wanted = isinstance(value, bool), "true or false"
    elif kind.startswith("float"):
        fits = from_target or (isinstance(value, int | float) and not isinstance(value, bool))
        wanted = "a number, or a coordinate of a target as A.x"
    else:
        fits = isinstance(value, int) and not isinstance(value, bool)
        numbers = np.iinfo({"char": "uint8", "byte": "uint8"}.get(kind, kind))
        fits = fits and numbers.min <= value <= numbers.max
        wanted = f"a whole number from {numbers.min} to {numbers.max}"
    return None if fits else (f"is {value!r:.60}, and the field is a {kind}", f"give {wanted}")
