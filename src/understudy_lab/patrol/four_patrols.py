"""Four patrols in a world of four homes, and the coordinator of their coordinators (paper section 5, Figure 4 C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

from msgspec.structs import replace

from understudy.model.kit import Kit
from understudy.model.library import Library
from understudy.runtime.team.coordinator_body import Troop
from understudy.runtime.team.team import Team
from understudy.sim.kit import kit_of
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, libraries_of, team_of, troop_of
from understudy_lab.patrol.practice import NEVER, SQUAD
from understudy_lab.patrol.teach import teach
from understudy_lab.tasks import garrison, patrol_teacher
from understudy_lab.teachers.teacher import Progress, Teacher, Teaching

TOP, BEHAVIOR = "garrison", "guard"
HOMES = ("home_north", "home_east", "home_south", "home_west")
"""Of the patrols, one after the other."""


class Taught(NamedTuple):
    """What was taught to the robots, to those who coordinate a patrol, and to the coordinator of these."""

    robots: Teaching
    patrols: Teaching
    garrison: Teaching


@cache
def scenario() -> Scenario:
    """The world of the four regions as it ships."""
    return load_scenario("regions")


@cache
def quiet() -> Scenario:
    """The same without a boss, to practice in."""
    made = scenario()
    objects = (replace(each, presence=NEVER) if each.name == "boss" else each for each in made.objects)
    return replace(made, objects=tuple(objects))


def known(robots: Library, patrols: Library, top: Library | None = None) -> Libraries:
    """What everybody there knows: robots and patrols what they were taught in the world of one patrol."""

    def squads(name: str, kit: Kit) -> Library:
        taught = patrols if name == SQUAD else top
        return Library(kit, {} if taught is None else taught.taught)

    return libraries_of(scenario(), Library(kit_of(scenario()), robots.taught), squads)


def troops(libraries: Libraries) -> Callable[[str, int], Troop]:
    """Makes the whole team for the coordinator of coordinators to be taught on."""
    return lambda practice, seed: troop_of(quiet(), TOP, libraries, seed=seed)


def teach_all(seed: int, *, progress: Progress = lambda name, what, account: None) -> Taught:
    """Teach everything from nothing, bottom-up: robots and one patrol in the world `patrol`, their top in this one."""
    taught = teach(seed, patrol_teacher.TOPICS, garrison.PATROL_TOPICS, progress=progress)
    libraries = known(taught.robots.library, taught.coordinators.library)
    teacher = Teacher(libraries[TOP], troops(libraries), seed, options={}, progress=progress)
    return Taught(taught.robots, taught.coordinators, teacher.teach(*garrison.GUARD_TOPICS))


def guarding(taught: Taught, seeds: Sequence[int]) -> Team:
    """The team of a teaching in a world per seed."""
    libraries = known(taught.robots.library, taught.patrols.library, taught.garrison.library)
    return team_of(scenario(), seeds, libraries, {TOP: (BEHAVIOR, {})})
