"""The programs of a team: what agents of each sort run, and what orders may tell them to run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType

from understudy.errors import UnderstudyError, UnknownName
from understudy.model.binding import Binding
from understudy.model.library import Library
from understudy.model.squad import Squad
from understudy.runtime.link import IDLE_PROGRAM, Program, link
from understudy.runtime.team.members import Finds, find_ordered_program

NO_OTHERS: Mapping[str, Sequence[Program]] = MappingProxyType({})


class TeamPrograms:
    """The programs of all agents of a team, by sort.

    Parameters
    ----------
    names
        The sorts of agents, bottom-up.
    squads
        The kinds of squads.
    libraries
        The library of each sort.
    roots
        For each sort, the behavior and the binding that agents outside of any squad run.
    others
        For each sort, further programs that its agents run.
    """

    def __init__(
        self,
        names: Sequence[str],
        squads: Sequence[Squad],
        libraries: Mapping[str, Library],
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        others: Mapping[str, Sequence[Program]] = NO_OTHERS,
    ) -> None:
        self.finds: dict[str, Finds] = {name: make_finder(libraries[name], name) for name in names}
        """For each sort, the function that makes a behavior ready to run."""
        self.orderable: dict[str, list[Program]] = {name: [] for name in names}
        """For each sort, the programs that its agents run or may be ordered to run."""
        self.roots: dict[str, Program] = dict.fromkeys(names, IDLE_PROGRAM)
        """For each sort, the program that its agents run without an order."""
        self._squads = {squad.name: squad for squad in squads}
        for name, (behavior, binding) in roots.items():
            if name not in names:
                raise UnknownName(what="sort of agents", name=name, where="the team", known=list(names))
            self.roots[name] = self.finds[name](behavior, Binding(binding))
            self._collect(name, self.roots[name])
        for name, programs in others.items():
            for program in programs:
                self._collect(name, program)

    def _collect(self, name: str, program: Program) -> None:
        """Note the programs that agents of a sort may run, and those that orders may give to agents below."""
        if program in self.orderable[name]:
            return
        self.orderable[name].append(program)
        squad = self._squads.get(name)
        for ground in program.basics:
            order = ground.behavior.order
            if order is None or squad is None:
                continue
            for duty in order.substitute(ground.binding).duties:
                for role in squad.roles:
                    if duty.role in (None, role.name):
                        ordered = find_ordered_program(squad, ground, role, duty, self.finds[role.of])
                        self._collect(role.of, ordered)


def make_finder(library: Library, name: str) -> Finds:
    """Make a function that finds the behaviors which agents of a sort can run."""

    @cache
    def find(behavior: str, binding: Binding) -> Program:
        try:
            return link(library, behavior, binding)
        except UnderstudyError as error:
            error.add_note(f"{name} is to run it")
            raise

    return find
