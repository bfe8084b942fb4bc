"""The experiment: independent teachings of scouts, carriers and their coordinator, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.model.learner_options import LearnerOptions
from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import CaptureRule, ObjectClass, RobotGroup, Scenario
from understudy.sim.team.libraries import Libraries, make_team
from understudy.sim.world import World
from understudy_lab import teams
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, Units
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.lesson_stats import LessonTable, examples_in, lessons_of
from understudy_lab.rows import Median, Rows, group_by_arm
from understudy_lab.study import Row, Study, Task
from understudy_lab.tasks import salvage_carrier_teacher, salvage_scout_teacher
from understudy_lab.tasks.salvage_carrier_teacher import CAPACITY
from understudy_lab.teams import FAILING, TeamCourse, make_team_libraries, run_with_failures, world_of

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


WORLDS, TICKS = 50, 12_000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: twenty minutes."""
FAILS_TICK = (2_000, 6_000)
"""The range of ticks in which robots fail at random; only the yield after it counts."""
ALONE: Mapping[str, str] = {SCOUT: "lookout", CARRIER: "haul"}
"""The behavior of each type in a mixed team without a coordinator."""
SINGLE: Mapping[str, tuple[str, str]] = {
    "all carriers, searching": (CARRIER, "gather"),
    "all carriers, going back": (CARRIER, "return"),
    "all scouts": (SCOUT, "lookout"),
}
"""The teams of one type: the type and its behavior."""
LED, MIXED = "led", "mixed, each by itself"


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_mixed_teams(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Measure the yield of each team, and of the mixed ones also after a third of their members failed."""
    makers: dict[str, Callable[[], Team]] = {
        LED: lambda: make_coordinated_team(libraries, worlds),
        MIXED: lambda: make_uncoordinated_team(libraries, worlds, ALONE),
    }
    whole = {name: measure_delivered(make(), ticks) for name, make in makers.items()}
    killed = {
        name: measure_delivered(make(), ticks, schedule_failures(worlds)) for name, make in makers.items()
    }
    single = {
        name: measure_delivered(make_single_type_team(kind, libraries, worlds, behavior), ticks)
        for name, (kind, behavior) in SINGLE.items()
    }
    return {
        "rate": {name: each["rate"] for name, each in (whole | single).items()},
        "kept": {name: _share(killed[name]["late"], whole[name]["late"]) for name in makers},
        "after_failures": {name: killed[name]["late"] for name in makers},
        "found": whole[LED]["total"],
    }


def measure_delivered(
    team: Team, ticks: int, fails: Mapping[int, Sequence[int]] | None = None
) -> dict[str, float]:
    """Run a team and return units per hour and world in the whole run and after all failures, and the initial units.

    `fails` maps a tick to the robots that fail in it.
    """
    world = world_of(team)
    total = float(world.total.mean())
    at = max([*(fails or {}), min(FAILS_TICK[1], ticks)])
    run_with_failures(team, at, fails or {})
    early = float(world.delivered.mean())
    team.run(ticks - at)
    hours, rest = ticks * world.tick_s / 3600, (ticks - at) * world.tick_s / 3600
    end = float(world.delivered.mean())
    late = round((end - early) / rest, 1) if rest else 0.0
    return {"rate": round(end / hours, 1), "late": late, "total": total}


schedule_failures = partial(teams.schedule_failures, robots=12, within=FAILS_TICK)


def _share(part: float, whole: float) -> float:
    return round(part / whole, 4) if whole else 0.0


TEACHINGS = range(59_000, 59_010)
"""The teaching seeds of the published result; none was used during development."""
BETTER = 1.5
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
NAMES = {LED: "mixed, under their coordinator", MIXED: MIXED} | {name: name for name in SINGLE}
"""The teams, and what they are called in tables."""


def work(task: Task) -> Row:
    """Teach a mixed team with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"])
    lessons = {
        "coordinator" if sort == SQUAD else sort: lessons_of(each) for sort, each in taught.by_sort.items()
    }
    return {**measure_mixed_teams(taught.libraries, worlds_of(task["seed"])), "lessons": lessons}


def compare_with_single(row: Row) -> float:
    """Return the yield of a coordinated team relative to the best team of one type."""
    best = max(float(row["rate"][name]) for name in SINGLE)
    return float(round(row["rate"][LED] / max(1.0, best), 3))


def compare_with_uncoordinated(row: Row, what: str = "rate") -> float:
    """Return the yield of a coordinated team relative to the same robots without their coordinator."""
    return float(row[what][LED] / max(1.0, row[what][MIXED]))


def write_headline(rows: Rows) -> str:
    """Return what the mix and the coordinator are worth."""
    return (
        "A mixed team of four scouts and eight carriers, each type taught its own behaviors, brings home "
        f"{rows.median(compare_with_single):.1f} times as much under its coordinator as the best team of twelve robots "
        f"of one type, in unseen worlds (median: {Median(f'rate.{LED}')(rows)} units an hour). All automata together "
        f"take {np.median(examples_in(rows)):.0f} examples. Without the coordinator, the same robots bring home "
        f"{1 / rows.median(compare_with_uncoordinated):.2f} times as much as with it."
    )


def write_contribution(rows: Rows) -> str:
    """Return a note on the contribution of the coordinator."""
    failing = rows.median(lambda row: compare_with_uncoordinated(row, "after_failures"))
    return (
        f"The mix makes the difference: under the coordinator, the team brings home "
        f"×{rows.median(compare_with_uncoordinated):.2f} of what the same robots bring home on their own, and "
        f"×{failing:.2f} after a third was killed. A carrier that follows an exploring scout is close by when the "
        "scout finds something, so the coordinator can add little."
    )


BY_TEAM = ("rate", "after_failures", "kept")
SHORT = ("mixed,\nled", "mixed,\nalone", "carriers,\nsearching", "carriers,\ngoing back", "scouts")
"""What the teams are called in the figure."""

EXPERIMENT = Study(
    name="roles",
    seeds=TEACHINGS,
    quick=1,
    tasks=Units({}),
    work=work,
    conclude=Conclusion(
        headline=write_headline,
        tables=(
            LinePerGroup(
                f"Salvage, teachings {{seeds}}, {WORLDS} unseen worlds of 20 minutes each: median (worst–best)",
                ["team of twelve"],
                group_by_arm(NAMES, *BY_TEAM),
                {"units an hour": Median("rate")},
                lambda team: [NAMES[team]],
            ),
            LinePerGroup(
                "Yield after a third of the members was killed at random moments",
                ["team of twelve"],
                group_by_arm((LED, MIXED), *BY_TEAM),
                {
                    "units an hour": Median("after_failures"),
                    "share of the yield without failures": Median("kept", percent=True),
                },
                lambda team: [NAMES[team]],
            ),
            LessonTable("type"),
        ),
        goals=(
            Goal(
                "units brought home, relative to the best team of one type",
                lambda rows: rows.median(compare_with_single),
                "×{}",
                BETTER,
                measured=lambda rows: (
                    f"×{rows.median(compare_with_single):.2f}, "
                    f"worst ×{min(rows.values(compare_with_single)):.2f}"
                ),
            ),
            Goal(
                "share of the yield kept after a third of the members was killed",
                f"kept.{LED}",
                least=KEPT,
                wanted=f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            ),
        ),
        notes=(
            write_contribution,
            "A carrier cannot distinguish a dead scout at an empty wreck from a scout on guard. This is what failures "
            "cost beyond the loss of the members themselves.",
            lambda rows: (
                "Scouts cannot carry anything: a team of scouts brings home "
                f"{max(rows.values('rate.all scouts')):.0f} units."
            ),
        ),
        numbers=lambda rows: {
            "teachings": len(rows),
            "better": rows.values(compare_with_single),
            "examples": examples_in(rows),
        },
    ),
    draw=Panels(
        (
            Dots(
                "all twelve",
                "units an hour",
                by_value(dict(zip((f"rate.{name}" for name in NAMES), SHORT, strict=True))),
            ),
            Dots(
                "after a third was killed",
                "units an hour",
                by_value(
                    dict(zip((f"after_failures.{name}" for name in (LED, MIXED)), SHORT[:2], strict=True))
                ),
            ),
        ),
        wide=4.2,
    ),
    worlds=("salvage",),
)
