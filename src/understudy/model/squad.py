"""Squads: the statistics that a coordinator senses of its members, and the orders it can give (paper section 5).

A squad acts as a body: its readings are statistics over its members, its basic behaviors are orders to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import isfinite
from typing import Literal, TypeAlias, get_args

from understudy.errors import DefinitionError
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.value_kinds import BOOLEAN, NO, YES, Continuous, Kind

Telling: TypeAlias = Literal["any", "all", "none", "count", "fraction"]
Measuring: TypeAlias = Literal["mean", "minimum", "maximum", "spread"]
How: TypeAlias = Telling | Measuring

TELLING: tuple[str, ...] = get_args(Telling)
"""The statistics that evaluate a condition for each member; the others aggregate readings."""
YES_OR_NO = ("any", "all", "none")
"""The statistics whose values are yes or no."""


@dataclass(frozen=True, slots=True)
class Statistic:
    """One number about the members of a squad: how many fulfill a condition, or an aggregate of their readings.

    `any`, `all`, `none`, `count` and `fraction` evaluate a condition for each member: its `flag` is raised; its
    yes-or-no `reading` is yes; or another reading is present and, if given, at least `least` and less than `below`.
    `count` without flag and reading counts members. `mean` (circular for angles), `minimum`, `maximum` and `spread`
    (the standard deviation) aggregate those readings that are present. `role` restricts all this to members of that
    role. In an empty squad `all` is no.

    At most one of these refers to the past. `within_s`: whether the condition held at some moment of the last
    `within_s` seconds; for numbers, the mean (for minimum and maximum the extreme) over that time. `since`: the
    seconds since it last held, NaN if never. `for_s`: whether it has held for `for_s` seconds without
    interruption.
    """

    name: str
    how: How
    reading: str | None = None
    flag: str | None = None
    role: str | None = None
    least: float | None = None
    below: float | None = None
    within_s: float | None = None
    since: bool = False
    for_s: float | None = None
    doc: str = ""

    def __post_init__(self) -> None:
        problem = self._problem()
        if problem is not None:
            raise DefinitionError(what=f"statistic {self.name!r}", problem=problem[0], remedy=problem[1])

    def _problem(self) -> tuple[str, str] | None:
        telling, timed = self.how in TELLING, (self.within_s, self.since or None, self.for_s)
        if self.reading is not None and self.flag is not None:
            return "it is of a reading and of a flag", "leave one of them out"
        if self.reading is None and (self.flag is None or not telling) and self.how != "count":
            return f"it is the {self.how} of nothing", "name a reading" + " or a flag" * telling
        if self.reading is None and (self.least, self.below) != (None, None):
            return "it compares something that is not a reading", "leave least and below out"
        if not telling and (self.least, self.below) != (None, None):
            return f"it compares for a {self.how}", "leave least and below out"
        if sum(each is not None for each in timed) > 1:
            return "it looks back in more than one way", "give one of within_s, since and for_s"
        if self.how not in YES_OR_NO and (self.since or self.for_s is not None):
            return f"it times a {self.how}", "give within_s, or ask whether any, all or none"
        for seconds in (self.within_s, self.for_s):
            if seconds is not None and not (seconds > 0 and isfinite(seconds)):
                return f"it looks back {seconds} s", "give a positive number of seconds"
        return None

    @property
    def is_timed(self) -> bool:
        """True if the value depends on the past; such a statistic is reset only when the run restarts."""
        return self.within_s is not None or self.since or self.for_s is not None

    @property
    def reset_value(self) -> float | None:
        """The value right after all members were restarted: 0 or 1; None if a restart does not change it."""
        if self.flag is None or self.is_timed:
            return None
        return YES if self.how == "none" else NO

    def kind(self, reading: Kind | None) -> Kind:
        """Return the kind of the statistic's values, given the kind of the reading (None: no reading)."""
        if self.how in YES_OR_NO:
            return Continuous() if self.since else BOOLEAN
        number = self.how in ("count", "fraction", "spread") or reading is None or reading == BOOLEAN
        return reading if reading is not None and not number else Continuous()


@dataclass(frozen=True, slots=True)
class Assignment:
    """The behavior that some members of a squad are ordered to run: those of a role, a share of them, or all.

    `share` is a number of members if 1 or more, or a fraction of the members (of those of `role`) if less than 1.
    None: no limit.
    """

    behavior: str
    binding: Binding = NOTHING_BOUND
    role: str | None = None
    share: Fraction | None = None

    def __str__(self) -> str:
        who = self.role or ""
        return f"{who}{' ' * bool(who)}{format_bound_name(self.behavior, self.binding)}"


@dataclass(frozen=True, slots=True)
class Order:
    """The order that a coordinator's basic behavior gives to its members.

    A member takes the first of the assignments (`duties`) that fits its role and is not full.
    """

    duties: tuple[Assignment, ...]

    def substitute(self, binding: Mapping[str, str]) -> Order:
        """Return the order with parameters replaced by the targets that they are bound to."""
        return Order(
            tuple(
                Assignment(each.behavior, each.binding.substitute(binding), each.role, each.share)
                for each in self.duties
            )
        )


@dataclass(frozen=True, slots=True)
class Role:
    """A role in a squad: the members that can have it, and the least, preferred and largest number of them.

    `of` is a robot type or a sort of squad. None means no preference, or no upper limit.
    """

    name: str
    of: str
    least: int = 1
    preferred: int | None = None
    most: int | None = None


@dataclass(frozen=True)
class Squad:
    """The definition of one sort of squad: its roles, the statistics of its coordinator, and extra orders.

    Orders made from the behaviors of its members are added to `orders`. `drops` names a yes-or-no reading of
    members, such as being stuck; a member is not counted while it is yes.
    """

    name: str
    roles: tuple[Role, ...]
    statistics: tuple[Statistic, ...] = ()
    orders: Mapping[str, Order] = field(default_factory=dict)
    drops: str | None = None
    doc: str = ""

    def role(self, name: str) -> Role | None:
        """Return the role with the given name, or None."""
        return next((role for role in self.roles if role.name == name), None)
