"""Groups of squad members by sort: which squad each belongs to, and which program each runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnderstudyError, UnknownName, join_names
from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import Assignment, Role, Squad
from understudy.runtime.body import Body, Commands
from understudy.runtime.link import GroundBehavior, Program

Finds: TypeAlias = Callable[[str, Binding], Program]
"""A function that makes the program of a behavior that members can run, with its targets."""


class Runner(Protocol):
    """The runner of a body's agents: interpreters or an engine."""

    @property
    def keys(self) -> tuple[ReadingKey, ...]:
        """The readings that the agents use."""
        ...

    def begin(self, agents: NDArray[np.intp], program: Program) -> None:
        """Let these agents begin a program."""
        ...

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Find the agents that have raised a flag [N]."""
        ...

    def path(self, agent: int) -> tuple[str, ...]:
        """Return the current state of every level of an agent, from the root down."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """Pulse every agent on one snapshot, and return the commands of all."""
        ...


@dataclass
class AgentLayer:
    """A body with the runner of its agents, and its snapshot and commands of this tick."""

    body: Body
    runner: Runner
    percept: Percept = field(default_factory=dict)
    commands: Commands = field(default_factory=dict)


@dataclass(frozen=True)
class MemberGroup:
    """Members of one sort: agents of a layer, which can be ordered to run the behaviors that `finds` finds."""

    name: str
    layer: AgentLayer
    finds: Finds


class Member(NamedTuple):
    """One member of a squad: a row of one of the bodies below, in a role (the index of each)."""

    band: int
    row: int
    role: int


@dataclass(frozen=True, eq=False)
class Membership:
    """The M members of all squads of a layer, one squad after the other, as arrays [M].

    `band` is the index of the group of agents (robots, or squads of a layer below) that has a member, `row` its index
    there; `role` and `squad` are the indices of its role and its squad.
    """

    squads: int
    band: NDArray[np.intp]
    row: NDArray[np.intp]
    role: NDArray[np.intp]
    squad: NDArray[np.intp]

    @classmethod
    def from_squads(
        cls, squads: Sequence[Sequence[Member]], worlds: int = 1, rows: Sequence[int] = ()
    ) -> Membership:
        """Make the members of the squads of one world, or of several worlds whose bodies have `rows` rows per world."""
        members = [member for squad in squads for member in squad]
        band, row, role = np.array(members, np.intp).reshape(-1, 3).T
        squad = np.repeat(np.arange(len(squads)), [len(squad) for squad in squads])
        step = np.array(rows, np.intp)[band] if len(rows) else np.zeros_like(band)
        world = np.repeat(np.arange(worlds), len(members))
        return cls(
            worlds * len(squads),
            np.tile(band, worlds),
            np.tile(row, worlds) + world * np.tile(step, worlds),
            np.tile(role, worlds),
            np.tile(squad, worlds) + world * len(squads),
        )

    def __len__(self) -> int:
        return len(self.row)

    def of_squads(self, chosen: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Return the members of these squads [S]."""
        return np.flatnonzero(chosen[self.squad])


def check_members(
    types: Sequence[str],
    type_of: Sequence[int],
    squads: Sequence[tuple[Squad, Sequence[Sequence[Member]]]],
) -> None:
    """Refuse, with DefinitionError, a member that is in two squads, does not exist, or does not fit its role."""
    robots = [types[kind] for kind in type_of]
    sorts = [(name, robots) for name in types]  # of each sort of agents, what the rows of its body are
    taken: dict[tuple[str, int], str] = {}
    for squad, lists in squads:
        if squad.name in (name for name, _ in sorts):
            raise DefinitionError(
                what=f"squad {squad.name!r}", problem="its name is taken", remedy="give another name"
            )
        for number, members in enumerate(lists):
            mine = f"squad {squad.name!r}, number {number}"
            for member in members:
                problem = _problem(member, squad, sorts)
                if problem is not None:
                    raise DefinitionError(what=mine, problem=problem, remedy="correct its members")
                key = sorts[member.band][0], member.row
                if key in taken:
                    problem = f"row {member.row} of {key[0]!r} is a member, and one of {taken[key]} before"
                    raise DefinitionError(what=mine, problem=problem, remedy="leave it out of one of them")
                taken[key] = mine
        sorts.append((squad.name, [squad.name] * len(lists)))


def _problem(member: Member, squad: Squad, sorts: Sequence[tuple[str, Sequence[str]]]) -> str | None:
    """Return what is wrong with a single member, or None."""
    band, row, role = member
    if not 0 <= role < len(squad.roles):
        return f"role {role} of a member is not one of its {len(squad.roles)} roles"
    if not 0 <= band < len(sorts):
        return f"sort {band} of a member is none of the {len(sorts)} below it"
    name, rows = sorts[band]
    if not 0 <= row < len(rows):
        return f"row {row} of {name!r} is none of the {len(rows)} there are"
    wanted = squad.roles[role]
    if not rows[row] == name == wanted.of:
        return f"row {row} is of {rows[row]!r}, and its role {wanted.name!r} is for {wanted.of!r}"
    return None


def find_ordered_program(
    squad: Squad,
    order: GroundBehavior,
    role: Role,
    duty: Assignment,
    finds: Callable[[str, Binding], Program],
) -> Program:
    """Find the program that an order means for members in a role; DefinitionError if they have no such behavior.

    `duty` is the behavior, with targets, that the order assigns to the role. `finds` looks up a program by both.
    """
    what = f"squad {squad.name!r}, order {str(order)!r}"
    try:
        return finds(duty.behavior, duty.binding)
    except UnknownName as error:
        if (error.what, error.name) != ("behavior", duty.behavior):
            error.add_note(f"{what} asks for it")
            raise
        raise DefinitionError(
            what=what,
            problem=f"its {role.name} ({role.of}) have no behavior {duty.behavior!r}",
            remedy=f"teach it to them, or order one of {join_names(error.known)}",
        ) from None
    except UnderstudyError as error:
        error.add_note(f"{what} asks for it")
        raise
