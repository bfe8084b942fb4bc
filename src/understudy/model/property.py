"""Properties: what a behavior must never do, or must do in time, from a stored moment or in seeded worlds."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import isfinite

from understudy.errors import DefinitionError
from understudy.model.binding import NOTHING_BOUND, Binding

LONGEST_S = 86_400.0
"""The longest time, in seconds, that a property may allow: one day."""

GOAL = "goal is reached"
"""The condition that the goal of the scenario is reached."""
RAISED = " is raised"
"""The end of the condition that a flag is raised, after the flag's name."""
PROGRESS = "progress"
"""What a property that limits the time without progress toward the scenario's goal is about."""


class PropertyKind(StrEnum):
    """The form of a property.

    "never": its condition never holds. "always": its condition holds within a time. "never longer": its condition
    never holds for longer than a time without a break. "progress": the scenario's goal never comes no nearer for
    longer than a time.
    """

    NEVER = "never"
    ALWAYS = "always"
    NEVER_LONGER = "never longer"
    PROGRESS = "progress"


@dataclass(frozen=True, slots=True)
class StoredMoment:
    """A stored situation of a simulated world, from which one agent runs while the others idle.

    `snapshot` is the state of the world, `scenario` the content of that world's scenario file, and `world` the
    world's name. `agent` is the number of the robot that is tested or, if `sort` is not empty, of the coordinator of a
    squad of the sort `sort`. The run lasts at most `limit_s`, s; None: the scenario's limit.
    """

    world: str
    scenario: str
    snapshot: bytes
    agent: int = 0
    sort: str = ""
    limit_s: float | None = None


@dataclass(frozen=True, slots=True)
class SeededWorlds:
    """Worlds of a scenario, one for each seed.

    `world` is the scenario's name or file. Each world runs for at most `limit_s`, s; None: for the scenario's limit.
    """

    world: str
    seeds: tuple[int, ...]
    limit_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Property:
    """A statement about all runs of a behavior that start in the same way.

    `what` is the condition in words, such as "distance_to(station) is below 0.5 m", "done is raised" or "goal is
    reached"; it is "progress" for the kind of that name. `seconds` is the time of "always", "never longer" and
    "progress". `behavior` is the name of the behavior; it is empty for a property that is stored in a lesson.
    `targets` binds its parameters. With `at_least` the property claims to hold in that share of all worlds; otherwise
    it claims to hold in all of them.
    """

    kind: PropertyKind
    what: str
    start: StoredMoment | SeededWorlds
    seconds: float | None = None
    behavior: str = ""
    targets: Binding = NOTHING_BOUND
    name: str = ""
    at_least: float | None = None

    def __post_init__(self) -> None:
        about = f"property {self.name!r}" if self.name else "a property"
        if (self.seconds is None) != (self.kind is PropertyKind.NEVER):
            problem = "it has a time" if self.kind is PropertyKind.NEVER else "its time is missing"
            raise DefinitionError(what=about, problem=problem, remedy="give a time to all kinds but never")
        if self.seconds is not None and not (isfinite(self.seconds) and 0.0 < self.seconds <= LONGEST_S):
            raise DefinitionError(
                what=about,
                problem=f"its time is {self.seconds:g} s",
                remedy=f"give seconds above 0, and at most {LONGEST_S:g}",
            )
        if self.at_least is not None and not 0.0 < self.at_least < 1.0:
            raise DefinitionError(
                what=about,
                problem=f"it is to hold in a share of {self.at_least:g}",
                remedy="give a share between 0 and 1, or leave it out for all worlds",
            )

    @property
    def flag(self) -> str | None:
        """The flag that must be raised in time; None if the property claims something else."""
        flag = self.what.removesuffix(RAISED)
        single = not any(f" {word} " in flag for word in ("and", "or", "is"))
        is_flag = self.kind is PropertyKind.ALWAYS and flag != self.what and single
        return flag if is_flag else None

    @property
    def is_timed(self) -> bool:
        """Whether something must hold within a time, which ends a run."""
        return self.kind is PropertyKind.ALWAYS

    @property
    def claim(self) -> str:
        """The statement in words, without the worlds that it is about."""
        if self.kind is PropertyKind.NEVER:
            return f"never {self.what}"
        if self.kind is PropertyKind.ALWAYS:
            return f"{self.what} within {self.seconds:g} s"
        if self.kind is PropertyKind.PROGRESS:
            return f"never longer than {self.seconds:g} s without progress"
        return f"never longer than {self.seconds:g} s: {self.what}"

    def __str__(self) -> str:
        bound = "".join(f", {parameter} = {target}" for parameter, target in self.targets.items())
        return f"{self.claim} in {self.start.world}{bound}"
