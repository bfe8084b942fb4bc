"""The patrol team: the practice worlds of its robots and its coordinator, and how they are taught."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import cache

from msgspec.structs import replace

from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    CaptureRule,
    ObjectClass,
    RobotGroup,
    Scenario,
)
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.libraries import Libraries, make_team
from understudy.sim.world import World
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher, patrol_wander_teacher
from understudy_lab.teachers.teacher import LessonDesign, Situation
from understudy_lab.teams import TeamCourse, make_team_libraries

ROBOT, SQUAD, ROBOTS = "pioneer", "patrol", 4

PERFECT = CommsSpec()
NEVER = AppearanceSchedule(away_s=(1e5, 1e5))


@cache
def scenario() -> Scenario:
    """Return the built-in patrol scenario."""
    return load_scenario("patrol")


def _with(
    objects: Mapping[str, Callable[[ObjectClass], ObjectClass]], robots: RobotGroup | None = None
) -> Scenario:
    whole = scenario()
    return replace(
        whole,
        objects=tuple(objects[each.name](each) if each.name in objects else each for each in whole.objects),
        robots=whole.robots if robots is None else (robots,),
    )


def _never(thing: ObjectClass) -> ObjectClass:
    return replace(thing, presence=NEVER)


def _always(thing: ObjectClass) -> ObjectClass:
    return replace(thing, presence=None, capture=None)


def _gone_after(seconds: float) -> Callable[[ObjectClass], ObjectClass]:
    """Return a change to an object class: its object disappears after the given time in s, as if captured."""
    return lambda thing: replace(thing, presence=None, capture=CaptureRule(range=20.0, after_s=seconds))


def _for(first_s: tuple[float, float], stays_s: tuple[float, float]) -> Callable[[ObjectClass], ObjectClass]:
    return lambda thing: replace(
        thing, presence=AppearanceSchedule(away_s=(1e5, 1e5), first_s=first_s, stays_s=stays_s), capture=None
    )


def _at(x: float, y: float) -> Callable[[ObjectClass], ObjectClass]:
    return lambda thing: replace(thing, presence=None, capture=None, at=((x, y),))


ONE = RobotGroup(type=ROBOT, count=1, apart=0.2)


def _one_at(x: float, y: float, heading_deg: float) -> RobotGroup:
    return RobotGroup(type=ROBOT, at=((x, y, heading_deg),))


@cache
def practices() -> Mapping[str, Scenario]:
    """Return the practice worlds of a robot, by name."""
    alone = {"intruder": _never, "boss": _never}
    in_the_way = RobotGroup(type=ROBOT, at=((1.5, 5.0, 0.0), (2.9, 4.7, 0.0), (2.9, 5.3, 0.0)))
    at_a_wall = _one_at(1.2, 5.0, 0.0)
    at_the_wall = _one_at(0.5, 5.0, 0.0)
    return {
        "alone": _with(alone, ONE),
        "a wall on the left": replace(_with(alone, _one_at(9.0, 8.5, 30.0)), obstacles=()),
        "a wall on the right": replace(_with(alone, _one_at(9.0, 1.5, -30.0)), obstacles=()),
        "among others": _with(alone),
        "an intruder": _with({"intruder": _always, "boss": _never}, ONE),
        "an intruder that leaves": _with({"intruder": _gone_after(5.0), "boss": _never}, ONE),
        "no intruder": _with(alone, ONE),
        "teammates in the way": replace(_with(alone, in_the_way), obstacles=()),
        "the boss": _with({"intruder": _never, "boss": _always}, ONE),
        "the boss on the left, a wall behind": replace(
            _with({"intruder": _never, "boss": _at(3.5, 5.8)}, at_a_wall), obstacles=()
        ),
        "the boss on the right, a wall behind": replace(
            _with({"intruder": _never, "boss": _at(3.5, 4.2)}, at_a_wall), obstacles=()
        ),
        "the boss aside, a wall behind": replace(
            _with({"intruder": _never, "boss": _at(1.5, 8.0)}, at_the_wall), obstacles=()
        ),
        "on patrol": _with({"boss": _never}, ONE),
    }


@cache
def squad_practices() -> Mapping[str, Scenario]:
    """Return the practice worlds of the coordinator, by name."""
    return {
        "on patrol": _with({"boss": _never}),
        "an intruder that leaves": _with({"intruder": _gone_after(1.5), "boss": _never}),
        "the boss comes": _with({"boss": _for((20.0, 30.0), (10.0, 15.0))}),
    }


def robots_world(practice: str, seed: int) -> World:
    """Return the world of a practice, in which one robot is taught."""
    return World(practices()[practice], [seed])


def make_uncoordinated_team(libraries: Libraries, seeds: Sequence[int], behavior: str = "patrol") -> Team:
    """Make the team without a coordinator, with one world per seed."""
    robots = make_team_libraries(scenario(), {ROBOT: libraries[ROBOT]})
    return make_team(scenario(), seeds, robots, {ROBOT: (behavior, {})})


def make_coordinated_team(
    libraries: Libraries, seeds: Sequence[int], behavior: str, radio: CommsSpec = PERFECT
) -> Team:
    """Make the team whose coordinator runs a behavior, with one world per seed."""
    return make_team(replace(scenario(), radio=radio), seeds, libraries, {SQUAD: (behavior, {})})


COURSE = TeamCourse(
    scenario,
    {ROBOT: patrol_teacher.TOPICS, SQUAD: patrol_squad_teacher.SQUAD_TOPICS},
    robots_world,
    squad_practices,
)
teach = COURSE.teach
"""Teach the robots of a patrol and their coordinator."""


SERVO = dataclasses.replace(
    patrol_teacher.SERVO,
    design=LessonDesign(
        parameters=["A"],
        states=["left", "right", "forward_left=forwards", "forward_right=forwards"],
        features=["blob_x(A)"],
    ),
)

ATTACK = dataclasses.replace(
    patrol_teacher.ATTACK,
    design=LessonDesign(parameters=["A"], states=["servo(A)"], flags=["done"], features=["blob_size(A)"]),
    cases=tuple(each for each in patrol_teacher.ATTACK.cases if each.practice in ("alone", "an intruder")),
)

COLLECTIVE_PATROL = dataclasses.replace(
    patrol_squad_teacher.COLLECTIVE_PATROL,
    design=LessonDesign(
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)"],
    ),
    cases=(
        Situation("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),
    ),
)

PAPERS_TOPICS = {
    ROBOT: (
        patrol_wander_teacher.DISPERSE,
        SERVO,
        ATTACK,
        patrol_teacher.SCATTER,
        patrol_teacher.RUN_AWAY,
        patrol_teacher.PATROL,
    ),
    SQUAD: (COLLECTIVE_PATROL, patrol_squad_teacher.DEFER),
}
"""The lessons with the features of the paper."""
