"""Teams: how their agents are taught, robots before their coordinators, and runs in which robots fail at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from understudy.errors import SettingError
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Kit, Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.sim.kit import make_scenario_kit, make_type_kits
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, collect_libraries, make_coordinator_body
from understudy.sim.world import World
from understudy_lab.teachers.live_teacher import choose_teacher
from understudy_lab.teachers.teacher import (
    LessonPlan,
    MakesBody,
    Progress,
    TeachingCost,
    TeachingResult,
    ignore_progress,
)

NOTHING_TAUGHT: Libraries = MappingProxyType({})


def make_team_libraries(scenario: Scenario, taught: Libraries = NOTHING_TAUGHT) -> Libraries:
    """Make the library of each sort of agents in a scenario, with what agents of that name were taught so far.

    They may have been taught in another scenario.
    """

    def make(name: str, kit: Kit) -> Library:
        return Library(kit, taught[name].taught if name in taught else {})

    kits = make_type_kits(scenario, make_scenario_kit(scenario))
    return collect_libraries(scenario, {name: make(name, kit) for name, kit in kits.items()}, make)


@dataclass(frozen=True)
class TeamTeaching:
    """The teachings of a team, by sort of agents: robots first, then each level of coordinators."""

    by_sort: Mapping[str, TeachingResult]

    @property
    def libraries(self) -> Libraries:
        """The library of each sort of agents that was taught."""
        return {sort: teaching.library for sort, teaching in self.by_sort.items()}

    @property
    def accounts(self) -> Mapping[str, TeachingCost]:
        """The cost of each automaton."""
        return {name: cost for each in self.by_sort.values() for name, cost in each.accounts.items()}

    @property
    def examples(self) -> int:
        """The number of press-made examples in all lessons together."""
        return sum(teaching.examples for teaching in self.by_sort.values())


@dataclass(frozen=True)
class TeamCourse:
    """How a team is taught.

    Parameters
    ----------
    scenario
        Loads the scenario of the team.
    topics
        The plans of the lessons of each sort of agents, in the order in which they are taught.
    robots_world
        Makes the world in which one robot practices.
    squad_practices
        Returns the scenarios in which coordinators practice, by name.
    options
        The options of lessons, by name.
    """

    scenario: Callable[[], Scenario]
    topics: Mapping[str, Sequence[LessonPlan]]
    robots_world: MakesBody
    squad_practices: Callable[[], Mapping[str, Scenario]]
    options: Mapping[str, LearnerOptions] = field(default_factory=dict)

    def teach(
        self,
        seed: int,
        topics: Mapping[str, Sequence[LessonPlan]] | None = None,
        *,
        method: str = "watched",
        taught: Libraries = NOTHING_TAUGHT,
        progress: Progress = ignore_progress,
    ) -> TeamTeaching:
        """Teach robots and then coordinators; the same seed gives the same lessons.

        Parameters
        ----------
        seed
            The seed of the teachings.
        topics
            Other plans than those of the course.
        method
            Whether they are taught live or as in the paper.
        taught
            The libraries of sorts that were taught before.
        progress
            Is called as teaching goes on.

        Returns
        -------
        TeamTeaching
            The teachings of the sorts that have topics.
        """
        by_sort: dict[str, TeachingResult] = {}
        for sort, plans in (self.topics if topics is None else topics).items():
            known = {**taught, **{name: each.library for name, each in by_sort.items()}}
            libraries = make_team_libraries(self.scenario(), known)
            is_robot = sort in self.scenario().types
            make = self.robots_world if is_robot else self._make_squads_body(sort, libraries)
            teacher = choose_teacher(method)(
                libraries[sort], make, seed, options=self.options, progress=progress
            )
            by_sort[sort] = teacher.teach(*plans)
        return TeamTeaching(by_sort)

    def _make_squads_body(self, sort: str, libraries: Libraries) -> Callable[[str, int], CoordinatorBody]:
        """Return a function that makes the members on which coordinators are taught."""
        return lambda practice, seed: make_coordinator_body(
            self.squad_practices()[practice], sort, libraries, seed=seed
        )


FAILING = 3
"""One robot of this many fails."""


def world_of(team: Team) -> World:
    """Return the simulated world of a team, or raise SettingError if it has none."""
    ground = getattr(team.ground, "world", team.ground)  # in physics: the one that says what there is
    if not isinstance(ground, World):
        raise SettingError(where="experiment", setting="team", problem="is in no world", remedy="give it one")
    return ground


def schedule_failures(worlds: Sequence[int], robots: int, within: tuple[int, int]) -> dict[int, list[int]]:
    """Return which robots fail, by the tick at which they do.

    `worlds` are the seeds of the worlds. In each, a random third of its robots fails, each at a random tick of a range.
    Robots are counted through all worlds: number `world * robots + robot`.
    """
    draws = np.random.default_rng(list(worlds))
    robots_by_tick: dict[int, list[int]] = {}
    for world in range(len(worlds)):
        for robot in draws.choice(robots, robots // FAILING, replace=False).tolist():
            robots_by_tick.setdefault(int(draws.integers(*within)), []).append(world * robots + robot)
    return robots_by_tick


def run_with_failures(team: Team, ticks: int, fails: Mapping[int, Sequence[int]]) -> None:
    """Run a team for a number of ticks; `fails` maps a tick to the robots that fail in it."""
    world, at = world_of(team), 0
    for tick in sorted({*fails, ticks}):
        team.run(tick - at)
        at = tick
        for robot in fails.get(tick, ()):
            world.freeze(robot)
