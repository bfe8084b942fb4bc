"""The team tree of a scenario: sorts of squads, what their coordinators sense and order, and their radio."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from msgspec import UNSET, Struct, UnsetType, field
from msgspec.structs import fields

from understudy.model.squad import How


class StrictStruct(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """What all parts of a scenario, or of a robot's file, have in common: frozen, keys by name, no unknown key."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without defaults: a copy of a default is another object, and would be written out in files."""
        values = {each.name: (getattr(self, each.name), each.default) for each in fields(self)}
        given = {name: value for name, (value, default) in values.items() if value is not default}
        return _make_struct, (type(self), given)


def _make_struct(kind: type[StrictStruct], given: dict[str, Any]) -> StrictStruct:
    return kind(**given)


class RoleSpec(StrictStruct, frozen=True, kw_only=True):
    """A role in squads of a sort: members `of` a type of robots, or of another sort of squads.

    Each squad gets `least` of them, then up to `preferred`, then up to `most`.
    """

    of: str
    least: int = 1
    preferred: int | None = None
    most: int | None = None


class StatisticSpec(StrictStruct, frozen=True, kw_only=True):
    """A number about the members of a squad, as `model.squad.Statistic` has it.

    A `centroid` is two of them: the means of the readings x and y, or of `reading`_x and `reading`_y.
    """

    how: How | Literal["centroid"]
    reading: str | None = None
    flag: str | None = None
    role: str | None = None
    least: float | None = None
    below: float | None = None
    within_s: float | None = None
    since: bool = False
    for_s: float | None = None
    doc: str = ""


class AssignmentSpec(StrictStruct, frozen=True, kw_only=True):
    """What some members are ordered to `run`, `with` targets for its parameters: those of a role, a share, the rest.

    A share is how many of them, or what part, such as "1/3".
    """

    run: str
    with_: Mapping[str, str] = field(name="with", default_factory=dict)
    role: str | None = None
    share: int | str | None = None


class SquadSpec(StrictStruct, frozen=True, kw_only=True):
    """A sort of squad; where `count` is left out there are as many as the preferred sizes of its roles ask for.

    `drops` names a yes-or-no reading, such as stuck: members who read yes are counted no more.
    """

    doc: str = ""
    count: int | UnsetType = UNSET
    drops: str | None = None
    members: Mapping[str, RoleSpec]
    statistics: Mapping[str, StatisticSpec] = field(default_factory=dict)
    orders: Mapping[str, tuple[AssignmentSpec, ...]] = field(default_factory=dict)


class CommsSpec(StrictStruct, frozen=True, kw_only=True):
    """What orders and reports between coordinators and their members suffer: a delay, and the chance to get lost."""

    delay_s: float = 0.0
    loss: float = 0.0
