"""Squads: what a coordinator senses of its members and can order them to do, as data (paper section 5).

A squad is a body: its readings are statistics over its members, its basic behaviors are orders to them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import isfinite
from typing import Literal, TypeAlias, get_args

from understudy.errors import DefinitionError
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.kinds import BOOLEAN, NO, YES, Continuous, Kind

Telling: TypeAlias = Literal["any", "all", "none", "count", "fraction"]
Measuring: TypeAlias = Literal["mean", "minimum", "maximum", "spread"]
How: TypeAlias = Telling | Measuring

TELLING: tuple[str, ...] = get_args(Telling)
"""Of how many members something is true."""
YES_OR_NO = ("any", "all", "none")


@dataclass(frozen=True, slots=True)
class Statistic:
    """One number about the members of a squad: of a `reading` or `flag` of each, or of how many there are.

    `any`, `all`, `none`, `count` and `fraction` ask each member whether the flag is up or the reading is yes; whether
    a reading that is no yes or no is there at all or, where these are given, at least `least` and below `below`. The
    others take the readings that are there: `mean` (on a circle where the reading is an angle), `minimum`, `maximum`
    and `spread` (their standard deviation). A `role` leaves out the other members. Of nobody, `all` is no.

    `within_s`: whether it was yes within so many seconds; of a number, its mean over them, for minimum and maximum the
    least and the greatest. `since`: the seconds since it was last yes, absent where it never was. `for_s`: whether it
    has been yes for so long.
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
            return "it compares what is no reading", "leave least and below out"
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
        """Whether it depends on what was before: such a one is reset only with the run."""
        return self.within_s is not None or self.since or self.for_s is not None

    @property
    def reset_value(self) -> float | None:
        """What it reads when all members have just been restarted; None where that does not matter."""
        if self.flag is None or self.is_timed:
            return None
        return YES if self.how == "none" else NO

    def kind(self, reading: Kind | None) -> Kind:
        """The kind of its values, given that of the reading."""
        if self.how in YES_OR_NO:
            return Continuous() if self.since else BOOLEAN
        number = self.how in ("count", "fraction", "spread") or reading is None or reading == BOOLEAN
        return reading if reading is not None and not number else Continuous()


@dataclass(frozen=True, slots=True)
class Assignment:
    """What some members of a squad are to do: those of a role, a share of them, or the rest (neither: all).

    `share` is how many (from 1), or what part of them (below 1, of those of the role).
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
    """What a coordinator's basic behavior tells its members; of several duties that fit one, the first with room."""

    duties: tuple[Assignment, ...]

    def substitute(self, binding: Mapping[str, str]) -> Order:
        """The order with parameters replaced by what they stand for."""
        return Order(
            tuple(
                Assignment(each.behavior, each.binding.substitute(binding), each.role, each.share)
                for each in self.duties
            )
        )


@dataclass(frozen=True, slots=True)
class Role:
    """A part of a squad: members `of` one sort (robots of a type, or squads), how many at least, best and at most."""

    name: str
    of: str
    least: int = 1
    preferred: int | None = None
    most: int | None = None


@dataclass(frozen=True)
class Squad:
    """One sort of squad: who is in it, what its coordinator senses, and which orders it has beside its members'.

    `drops` names a yes-or-no reading of members, such as being stuck: who reads yes is counted no more.
    """

    name: str
    roles: tuple[Role, ...]
    statistics: tuple[Statistic, ...] = ()
    orders: Mapping[str, Order] = field(default_factory=dict)
    drops: str | None = None
    doc: str = ""

    def role(self, name: str) -> Role | None:
        """The role of this name."""
        return next((role for role in self.roles if role.name == name), None)
