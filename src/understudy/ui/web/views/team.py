"""List the groups of agents that can be trained, robots or the coordinators of squads, and find their libraries."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from understudy.addons.robots.twin import Ground
from understudy.errors import UnknownName
from understudy.model.library import Kit, Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team, TeamTree
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import (
    Libraries,
    collect_libraries,
    find_type_folders,
    load_type_libraries,
)
from understudy.ui.web.views.library import LibraryView, read_library_folder
from understudy.ui.web.views.scene import SquadSortData


class TrainableGroups:
    """The robots and sorts of squads of a scenario, with their library folders.

    Robots' automata are in `folder`; those of squads, and of robot types that differ, in a subfolder of their name.
    """

    def __init__(self, scenario: Scenario, folder: Path, kit: Kit) -> None:
        self._scenario, self._folder, self._kit = scenario, folder, kit
        self.tree: TeamTree = assign_team_members(scenario)

    @property
    def squads(self) -> list[str]:
        """The sorts of squads, the topmost first."""
        return [squad.name for squad, _ in reversed(self.tree.squads)]

    def agents(self, sort: str | None) -> int:
        """Return the number of robots (None) or of squads of a sort; UnknownName if there is no such sort."""
        if sort is None:
            return len(self.tree.type_of)
        self._check(sort)
        return next(len(squads) for squad, squads in self.tree.squads if squad.name == sort)

    def _check(self, sort: str) -> None:
        if sort not in self.squads:
            raise UnknownName(what="sort of squads", name=sort, where="this scenario", known=self.squads)

    def type_of(self, agent: int) -> str:
        """Return the type of a robot."""
        return self.tree.types[self.tree.type_of[agent]]

    def have_same_library(self, one: int, other: int) -> bool:
        """Return whether two robots use the same library folder."""
        places = find_type_folders(self._scenario, self._folder, self._kit)
        return places[self.type_of(one)][0] == places[self.type_of(other)][0]

    def read_library(self, sort: str | None, agent: int = 0) -> LibraryView:
        """Read the library of a robot (None) or of a sort of squads; UnknownName if there is no such sort."""
        if sort is None:
            where, kit = find_type_folders(self._scenario, self._folder, self._kit)[self.type_of(agent)]
            return read_library_folder(where, kit)
        self._check(sort)
        return read_library_folder(self._folder / sort, self._known()[sort].kit)

    def body(self, world: Ground, sort: str | None) -> Ground | CoordinatorBody:
        """Return the body to train: the world's robots (None), or the coordinators of a sort of squads."""
        if sort is None:
            return world
        radio = self._scenario.radio
        team = Team(
            world, self.tree, self._known(), {}, trained=sort, delay_s=radio.delay_s, loss=radio.loss,
            seeds=world.seeds,
        )  # fmt: skip
        return CoordinatorBody(team, sort)

    def collect_libraries(self, sort: str | None, agent: int, library: Library) -> Libraries:
        """Return the library of every sort of agents; `library` replaces that of a robot (None) or sort of squads."""
        if sort is not None:
            return {**self._known(), sort: library}
        places = find_type_folders(self._scenario, self._folder, self._kit)
        here = places[self.type_of(agent)][0]
        same = {name: library for name, (where, _) in places.items() if where == here}
        return {**(self._known() if self.squads else {}), **same}

    def _known(self) -> Libraries:
        def look(where: Path, kit: Kit) -> Library:
            return read_library_folder(where, kit).library

        robots = load_type_libraries(self._scenario, self._folder, self._kit, look)
        return collect_libraries(self._scenario, robots, lambda name, kit: look(self._folder / name, kit))

    def data(self) -> list[SquadSortData]:
        """Return the sorts of squads, topmost first, with all robots of each squad."""
        return [
            SquadSortData(name=squad.name, doc=squad.doc, squads=self._list_robots(squad.name, len(squads)))
            for squad, squads in reversed(self.tree.squads)
        ]

    def _list_robots(self, sort: str, squads: int) -> list[list[int]]:
        below = (self.tree.mark_robots_below(sort, number) for number in range(squads))
        return [np.flatnonzero(each).tolist() for each in below]


class ActivityNames:
    """A numbering of the robots' activities; frames contain the numbers, the session's data the names."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self._numbers: dict[str, int] = {}

    def numbers(self, paths: list[tuple[str, ...]]) -> list[int]:
        """Return the number of each robot's activity."""
        return [self._number(path) for path in paths]

    def _number(self, path: tuple[str, ...]) -> int:
        name = path[:2][-1] if path else "idles"  # where it is in what it was ordered to do
        if name not in self._numbers:
            self._numbers[name] = len(self.names)
            self.names.append(name)
        return self._numbers[name]
