"""The practice worlds of scouts, carriers and their coordinator, and the teams that are compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from msgspec.structs import replace

from understudy.model.learner_options import LearnerOptions
from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import CaptureRule, ObjectClass, RobotGroup, Scenario
from understudy.sim.team.libraries import Libraries, make_team
from understudy.sim.world import World
from understudy_lab.tasks import salvage_carrier_teacher, salvage_scout_teacher
from understudy_lab.tasks.salvage_carrier_teacher import CAPACITY
from understudy_lab.teams import TeamCourse, make_team_libraries

SCOUT, CARRIER, SQUAD = "scout", "carrier", "crew"
SIZE = (14.0, 14.0)
ELSEWHERE = ((13.0, 13.0),)
QUARTERS = ((1.3, 1.3), (2.7, 1.3), (1.3, 2.7), (2.7, 2.7))
AROUND = ((13.4, 7.3), (5.4, 7.3), (9.4, 11.3), (9.4, 3.3))
PLENTY = 60


@cache
def scenario() -> Scenario:
    """Return the built-in salvage scenario."""
    return load_scenario("salvage")


def _made(
    *robots: RobotGroup,
    size: tuple[float, float] = SIZE,
    harbor: Sequence[tuple[float, ...]] = (),
    **wreck: Any,
) -> Scenario:
    """Return a small version of the scenario with the given robots, harbor, and wrecks."""

    def changed(thing: ObjectClass) -> ObjectClass:
        if thing.name == "wreck":
            return _thing(thing, **{"apart": 0.8, "amount": PLENTY, **wreck})
        return _thing(thing, **({"at": tuple(harbor)} if harbor else {}), within=None, apart=0.8)

    objects = tuple(changed(each) for each in scenario().objects)
    return replace(scenario(), size=size, objects=objects, robots=robots, squads={}, goal=None, regions={})


def _thing(thing: ObjectClass, **changes: Any) -> ObjectClass:
    """Return a class of objects with changes; one that is given positions drops its number, and the reverse."""
    fields = {name: getattr(thing, name) for name in thing.__struct_fields__ if name not in changes}
    if "at" in changes:
        fields.pop("count", None)
        fields.pop("apart", None)
        changes.pop("apart", None)
    if "count" in changes:
        fields.pop("at", None)
    return ObjectClass(**fields, **changes)


def _one(kind: str, *at: tuple[float, float, float], **more: Any) -> RobotGroup:
    return RobotGroup(type=kind, at=at, **more) if at else RobotGroup(type=kind, count=1, **more)


@cache
def practices() -> Mapping[str, Scenario]:
    """Return the practice worlds of the robots by name; the robot that is taught is the first."""
    gone, soon = CaptureRule(range=5.0, after_s=1.5), CaptureRule(range=1.6, after_s=12.0)
    there, beside = ((9.0, 7.0),), (9.4, 7.3, 0.0)
    carrier, taken = _one(CARRIER), CaptureRule(range=1.6, after_s=1.5)
    practices_by_name = {
        "a scout in a yard": _made(_one(SCOUT), size=(5.6, 5.6), harbor=((5.0, 5.0),), at=((2.8, 2.8),)),
        "a scout, a wreck somewhere": _made(_one(SCOUT), count=1),
        "a scout, wrecks that others empty": _made(_one(SCOUT), count=4, capture=gone),
        "a scout, many wrecks that are emptied": _made(_one(SCOUT), count=10, capture=soon),
        "a scout, wrecks that are emptied": _made(_one(SCOUT), count=3, capture=soon),
        "a carrier in a yard": _made(carrier, _one(SCOUT), size=(10.0, 10.0), count=1),
        "a carrier at a wreck": _made(carrier, size=(2.8, 2.8), harbor=((2.0, 2.0),), at=((1.4, 1.4),)),
        "a carrier at wrecks with little in them": _made(
            carrier, size=(4.0, 4.0), harbor=((2.0, 2.0),), at=QUARTERS, amount=2
        ),
        "a carrier, wrecks about": _made(carrier, count=5),
        "a carrier, wrecks that others empty": _made(carrier, count=8, capture=taken),
        "a carrier, a scout at a wreck": _made(carrier, _one(SCOUT, beside), at=there),
        "a carrier, a scout at a wreck that others empty": _made(
            carrier, _one(SCOUT, (10.7, 7.0, 0.0)), at=there, capture=taken
        ),
        "a carrier, a scout somewhere else": _made(carrier, _one(SCOUT, beside), at=AROUND),
        "a carrier, wrecks about, with a load": _made(_one(CARRIER, stored=CAPACITY), count=5),
        "a carrier, a scout at a wreck, with a load": _made(
            _one(CARRIER, stored=CAPACITY), _one(SCOUT, beside), at=there
        ),
        "a carrier with one unit": _made(_one(CARRIER, stored=1), count=1),
        "a carrier with a load": _made(_one(CARRIER, stored=CAPACITY), count=1),
    }
    for kind in (SCOUT, CARRIER):
        practices_by_name |= {
            f"a {kind} alone": _made(_one(kind), at=ELSEWHERE),
            f"a {kind} between walls": _made(
                _one(kind), size=(8.0, 8.0), harbor=((3.0, 3.0),), at=((5.0, 5.0),)
            ),
        }
    return practices_by_name


@cache
def squad_practices() -> Mapping[str, Scenario]:
    """Return the practice worlds of the coordinator, by name."""
    little: dict[str, dict[str, Any]] = {
        "wreck": {"count": 5, "amount": (8, 16), "apart": 3.0},
        "harbor": {"at": ((12.0, 12.0),), "within": None},
    }
    objects = tuple(_thing(each, **little[each.name]) for each in scenario().objects)
    small = replace(scenario(), size=(24.0, 24.0), objects=objects, regions={})
    return {"wrecks with little in them": small}


def robots_world(practice: str, seed: int) -> World:
    """Return the world of a practice, in which one robot is taught."""
    return World(practices()[practice], [seed])


@cache
def make_single_type_scenario(kind: str) -> Scenario:
    """Return the scenario with the same number of robots, all of one type."""
    everyone = sum(each.count for each in scenario().robots if isinstance(each.count, int))
    robots = (replace(scenario().robots[0], type=kind, count=everyone),)
    return replace(scenario(), robots=robots, squads={}, goal=None)


def make_uncoordinated_team(libraries: Libraries, seeds: Sequence[int], doing: Mapping[str, str]) -> Team:
    """Make the mixed team without its coordinator; `doing` gives the behavior of each type."""
    robots = make_team_libraries(scenario(), {kind: libraries[kind] for kind in scenario().types})
    return make_team(scenario(), seeds, robots, {kind: (name, {}) for kind, name in doing.items()})


def make_single_type_team(kind: str, libraries: Libraries, seeds: Sequence[int], behavior: str) -> Team:
    """Make a team of one type, with one world per seed."""
    alone = make_single_type_scenario(kind)
    return make_team(alone, seeds, make_team_libraries(alone, libraries), {kind: (behavior, {})})


def make_coordinated_team(libraries: Libraries, seeds: Sequence[int], behavior: str = "lead") -> Team:
    """Make the mixed team whose coordinator runs a behavior, with one world per seed."""
    return make_team(scenario(), seeds, libraries, {SQUAD: (behavior, {})})


COURSE = TeamCourse(
    scenario,
    {
        SCOUT: salvage_scout_teacher.SCOUTS,
        CARRIER: salvage_carrier_teacher.CARRIERS,
        SQUAD: salvage_carrier_teacher.TOPICS,
    },
    robots_world,
    squad_practices,
    {"goto": LearnerOptions(watched=True, reaction_s=0.2)},
)
"""Lessons about motion record examples while watching, and compensate for late presses."""
teach = COURSE.teach
"""Teach scouts, carriers, and their coordinator."""
