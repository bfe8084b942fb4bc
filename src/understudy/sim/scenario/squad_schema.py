"""Squads in a scenario: their members, the statistics and orders of their coordinators, and their radio."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from msgspec import UNSET, Struct, UnsetType, field
from msgspec.structs import fields

from understudy.model.squad import How


class StrictStruct(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """A part of a scenario or robot file: frozen, with keys by name, without unknown keys."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without default values: a copied default would be another object, and be written to files."""
        values = {each.name: (getattr(self, each.name), each.default) for each in fields(self)}
        set_fields = {name: value for name, (value, default) in values.items() if value is not default}
        return _make_struct, (type(self), set_fields)


def _make_struct(kind: type[StrictStruct], set_fields: dict[str, Any]) -> StrictStruct:
    return kind(**set_fields)


class RoleSpec(StrictStruct, frozen=True, kw_only=True):
    """A role in squads of one kind, for members `of` a type of robots or another kind of squads.

    Each squad gets `least` of them, then up to `preferred`, then up to `most`.
    """

    of: str
    least: int = 1
    preferred: int | None = None
    most: int | None = None


class StatisticSpec(StrictStruct, frozen=True, kw_only=True):
    """A number computed from the members of a squad; see `model.squad.Statistic`.

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
    """The behavior that some members are ordered to `run`, with targets (`with`) for its parameters.

    These are members in a `role`, a `share` of the members (a number, or a fraction such as "1/3"), or the rest.
    """

    run: str
    with_: Mapping[str, str] = field(name="with", default_factory=dict)
    role: str | None = None
    share: int | str | None = None


class SquadSpec(StrictStruct, frozen=True, kw_only=True):
    """A kind of squad; without `count` there are as many as the preferred sizes of its roles permit.

    `drops` names a yes-or-no reading, such as stuck: members whose reading is yes no longer count.
    """

    doc: str = ""
    count: int | UnsetType = UNSET
    drops: str | None = None
    members: Mapping[str, RoleSpec]
    statistics: Mapping[str, StatisticSpec] = field(default_factory=dict)
    orders: Mapping[str, tuple[AssignmentSpec, ...]] = field(default_factory=dict)


class CommsSpec(StrictStruct, frozen=True, kw_only=True):
    """The radio between coordinators and their members: delay of messages (s), and the probability of losing one."""

    delay_s: float = 0.0
    loss: float = 0.0
