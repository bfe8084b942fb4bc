"""Whether a team fits together: everybody is in one squad at most, and knows what is ordered of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from understudy.errors import DefinitionError, UnderstudyError, UnknownName, listed
from understudy.model.binding import Binding
from understudy.model.squad import Duty, Role, Squad
from understudy.runtime.program import GroundBehavior, Program
from understudy.runtime.team.roster import Member


def check_members(
    types: Sequence[str],
    type_of: Sequence[int],
    squads: Sequence[tuple[Squad, Sequence[Sequence[Member]]]],
) -> None:
    """DefinitionError where a member is in two squads, is not there, or is not what its role is for."""
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
    """What is wrong with a member by itself."""
    band, row, role = member
    if not 0 <= role < len(squad.roles):
        return f"role {role} of a member is none of its {len(squad.roles)}"
    if not 0 <= band < len(sorts):
        return f"sort {band} of a member is none of the {len(sorts)} below it"
    name, rows = sorts[band]
    if not 0 <= row < len(rows):
        return f"row {row} of {name!r} is none of the {len(rows)} there are"
    wanted = squad.roles[role]
    if not rows[row] == name == wanted.of:
        return f"row {row} is of {rows[row]!r}, and its role {wanted.name!r} is for {wanted.of!r}"
    return None


def ordered(
    squad: Squad, order: GroundBehavior, role: Role, duty: Duty, finds: Callable[[str, Binding], Program]
) -> Program:
    """What members in a role run by an order; DefinitionError where they do not know it."""
    what = f"squad {squad.name!r}, order {str(order)!r}"
    try:
        return finds(duty.behavior, duty.binding)
    except UnknownName as error:
        if (error.what, error.name) != ("behavior", duty.behavior):
            error.add_note(f"{what} asks for it")
            raise
        raise DefinitionError(
            what=what,
            problem=f"its {role.name} ({role.of}) know no behavior {duty.behavior!r}",
            remedy=f"teach it to them, or order what they know: {listed(error.known)}",
        ) from None
    except UnderstudyError as error:
        error.add_note(f"{what} asks for it")
        raise
