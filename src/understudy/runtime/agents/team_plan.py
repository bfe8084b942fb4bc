"""The plan of a team: the name of each agent, its squad, the agents that may lead each squad, and their programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from understudy.model.library import Library
from understudy.model.squad import Squad
from understudy.runtime.agents.agent import AgentSpec, SquadLink
from understudy.runtime.agents.coordinator import LEASE_S, SquadPlan
from understudy.runtime.agents.messages import list_reported_readings
from understudy.runtime.body import Reading
from understudy.runtime.link import Program
from understudy.runtime.team.squad_body import list_squad_readings
from understudy.runtime.team.team import TeamTree
from understudy.runtime.team.team_programs import TeamPrograms


class TeamPlan:
    """A team as every one of its agents knows it.

    Parameters
    ----------
    tree
        The sorts of agents, and the squads with their members.
    libraries
        The library of each sort.
    roots
        For each sort, the behavior and the binding that its agents run without an order.
    readings
        The readings that each type of robots offers.
    targets
        The targets of the team.
    robots
        The name of each robot. By default `robot_0`, `robot_1` and so on.
    deputies
        For each squad, the agents that may lead it besides the one of its own name, the first choice first; or a
        function that chooses them from its members.
    fingerprints
        The fingerprint of each sort's library.
    requires_same_library
        Whether agents whose library has another fingerprint are neither counted nor obeyed.
    lease_s
        The time for which an order holds after it was received, s.
    trainer
        The agent from which a person may train robots; None: none.
    only_led
        Whether squads that neither run a behavior by `roots` nor are below such a squad have no coordinator: their
        members are in no squad then. Otherwise all have one, which may idle.
    """

    def __init__(
        self,
        tree: TeamTree,
        libraries: Mapping[str, Library],
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        readings: Mapping[str, Sequence[Reading]],
        targets: Sequence[str],
        robots: Sequence[str] = (),
        deputies: Mapping[str, Sequence[str]] | Callable[[Sequence[str]], Sequence[str]] | None = None,
        fingerprints: Mapping[str, str] | None = None,
        requires_same_library: bool = False,
        lease_s: float = LEASE_S,
        trainer: str | None = None,
        only_led: bool = False,
    ) -> None:
        self._trainer = trainer
        self._led = tree.close_downwards(roots) if only_led else frozenset(tree.names)
        self.tree, self.targets, self._lease_s = tree, tuple(targets), lease_s
        self.libraries, self.roots = libraries, roots
        self.robots = tuple(robots) or tuple(f"robot_{row}" for row in range(len(tree.type_of)))
        self._deputies, self._fingerprints = deputies or {}, fingerprints or {}
        self._required = self._fingerprints if requires_same_library else {}
        self._programs = TeamPrograms(tree.names, [squad for squad, _ in tree.squads], libraries, roots)
        self._readings: dict[str, Sequence[Reading]] = dict(readings)
        for squad, _ in tree.squads:
            below = [reading for role in squad.roles for reading in self._readings[role.of]]
            self._readings[squad.name] = list_squad_readings(squad, below)
        self._sorts = dict(zip(self.robots, (tree.types[kind] for kind in tree.type_of), strict=True))
        self._kinds: dict[str, Squad] = {}
        self._members: dict[str, list[tuple[str, str, int]]] = {}
        self._superiors: dict[str, str] = {}
        self._place_squads()

    def _place_squads(self) -> None:
        names: list[Sequence[str]] = [self.robots] * len(self.tree.types)
        for squad, lists in self.tree.squads:
            mine = tuple(f"{squad.name}_{number}" for number in range(len(lists)))
            if squad.name not in self._led:
                names.append(mine)
                continue
            for name, members in zip(mine, lists, strict=True):
                self._sorts[name], self._kinds[name] = squad.name, squad
                self._members[name] = [
                    (names[member.band][member.row], self.tree.names[member.band], member.role)
                    for member in members
                ]
                for member, _, _ in self._members[name]:
                    self._superiors[member] = name
            names.append(mine)

    @property
    def squads(self) -> tuple[str, ...]:
        """The names of all squads, bottom-up."""
        return tuple(self._kinds)

    @property
    def programs(self) -> Mapping[str, Sequence[Program]]:
        """The programs that agents of each sort run or may be ordered to run."""
        return self._programs.orderable

    def find_sort(self, name: str) -> str:
        """Return the sort of an agent: a type of robots or a kind of squads."""
        return self._sorts[name]

    def find_superior(self, name: str) -> str | None:
        """Return the squad that an agent is a member of; None if it is in none."""
        return self._superiors.get(name)

    def list_members(self, squad: str) -> list[str]:
        """List the members of a squad."""
        return [name for name, _, _ in self._members[squad]]

    def list_candidates(self, squad: str) -> tuple[str, ...]:
        """List the agents that may lead a squad, the first choice first."""
        named = self._deputies
        deputies = named(self.list_members(squad)) if callable(named) else named.get(squad, ())
        return tuple(dict.fromkeys((squad, *deputies)))

    def list_led_squads(self, agent: str) -> list[str]:
        """List the squads that an agent may lead, bottom-up."""
        return [squad for squad in self._kinds if agent in self.list_candidates(squad)]

    def make_agent_spec(self, name: str) -> AgentSpec:
        """Describe what a robot, or the coordinator of a squad, runs."""
        sort = self._sorts[name]
        return AgentSpec(
            name,
            self._programs.finds[sort],
            self._programs.orderable[sort],
            self._programs.roots[sort],
            self._fingerprints.get(sort, ""),
            self._make_link(name),
            self._trainer if name in self.robots else None,
        )

    def _make_link(self, name: str) -> SquadLink | None:
        squad = self._superiors.get(name)
        if squad is None:
            return None
        kind = self._kinds[squad]
        keys = list_reported_readings(kind, self._readings[self._sorts[name]], self.targets)
        return SquadLink(squad, self.list_candidates(squad), keys, self._required.get(kind.name))

    def make_squad_spec(self, squad: str) -> SquadPlan:
        """Describe a squad for its coordinator."""
        members = self._members[squad]
        sorts = {sort for _, sort, _ in members}
        return SquadPlan(
            self._kinds[squad],
            members,
            {sort: self._readings[sort] for sort in sorts},
            {sort: self._programs.finds[sort] for sort in sorts},
            {sort: self._required[sort] for sort in sorts if sort in self._required},
            self._lease_s,
            self._required.get(self._kinds[squad].name),
        )
