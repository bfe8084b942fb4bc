"""Four patrols in a world with four homes, under a coordinator of coordinators (paper section 5, Figure 4 C)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from understudy.model.library import Kit, Library
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, collect_libraries, make_coordinator_body, make_team
from understudy_lab.declaration import ColumnPerGroup, Goal
from understudy_lab.lesson_stats import examples_in, lessons_of
from understudy_lab.patrol.evaluate import TICKS, rounds, worlds_of
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.practice import NEVER, SQUAD
from understudy_lab.patrol.teach import teach
from understudy_lab.patrol.tracks import PatrolTracks, watch
from understudy_lab.rows import Median, Rows
from understudy_lab.study import ResultTable, Row, StudyGoal
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher
from understudy_lab.teachers.teacher import Progress, ScriptedTeacher, TeachingResult

TOP, BEHAVIOR = "garrison", "guard"
HOMES = ("home_north", "home_east", "home_south", "home_west")
"""The home of each patrol, in order."""


class RegionsTeaching(NamedTuple):
    """The results of teaching the robots, the coordinators of a patrol, and the coordinator of those."""

    robots: TeachingResult
    patrols: TeachingResult
    garrison: TeachingResult


@cache
def scenario() -> Scenario:
    """Return the built-in scenario with four regions."""
    return load_scenario("regions")


@cache
def make_quiet_scenario() -> Scenario:
    """Return the same scenario without a boss, for practice."""
    whole = scenario()
    objects = (replace(each, presence=NEVER) if each.name == "boss" else each for each in whole.objects)
    return replace(whole, objects=tuple(objects))


def collect_regions_libraries(robots: Library, patrols: Library, top: Library | None = None) -> Libraries:
    """Return the libraries of all agents; robots and patrols have those taught in the world of one patrol."""

    def squads(name: str, kit: Kit) -> Library:
        taught = patrols if name == SQUAD else top
        return Library(kit, {} if taught is None else taught.taught)

    return collect_libraries(scenario(), Library(make_scenario_kit(scenario()), robots.taught), squads)


def troops(libraries: Libraries) -> Callable[[str, int], CoordinatorBody]:
    """Return a function that makes the team on which the coordinator of coordinators is taught."""
    return lambda practice, seed: make_coordinator_body(make_quiet_scenario(), TOP, libraries, seed=seed)


def teach_all(seed: int, *, progress: Progress = lambda name, what, account: None) -> RegionsTeaching:
    """Teach robots and one patrol in the world `patrol`, then the top coordinator in the world of four patrols."""
    taught = teach(seed, patrol_teacher.TOPICS, patrol_squad_teacher.PATROL_TOPICS, progress=progress)
    libraries = collect_regions_libraries(taught.robots.library, taught.coordinators.library)
    teacher = ScriptedTeacher(libraries[TOP], troops(libraries), seed, options={}, progress=progress)
    return RegionsTeaching(
        taught.robots, taught.coordinators, teacher.teach(*patrol_squad_teacher.GUARD_TOPICS)
    )


def make_guarding_team(taught: RegionsTeaching, seeds: Sequence[int]) -> Team:
    """Make the taught team, with one world per seed."""
    libraries = collect_regions_libraries(
        taught.robots.library, taught.patrols.library, taught.garrison.library
    )
    return make_team(scenario(), seeds, libraries, {TOP: (BEHAVIOR, {})})


WORLDS = 50
GOOD = 0.9


def measure_four_patrols(seed: int) -> Row:
    """Teach all agents with one seed and test them in their own unseen worlds."""
    taught = teach_all(seed)
    return {
        "together": summarize_four_patrols(
            watch(make_guarding_team(taught, worlds_of(seed)[:WORLDS]), TICKS, homes=HOMES)
        ),
        "lessons": [*lessons_of(taught.patrols), *lessons_of(taught.garrison)],
    }


def summarize_four_patrols(tracks: PatrolTracks) -> dict[str, Any]:
    """Return the results of four patrols, and the median and 90 % quantile of the cycle time in s."""
    seconds = [cycle.seconds for cycle in cycles(tracks) if not np.isnan(cycle.seconds)]
    lasted = [round(float(each), 1) for each in np.quantile(seconds, (0.5, 0.9))] if seconds else None
    return {**rounds(tracks), "cycle_s": lasted}


def table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of results over all teachings."""
    names = [lesson["name"] for lesson in rows[0]["lessons"]]
    return ColumnPerGroup(
        f"Four patrols under a coordinator of coordinators, {WORLDS} unseen worlds each: median (worst–best)",
        lambda rows: {"together (C)": Rows({**row, **row["together"]} for row in rows)},
        {
            "cycles completed": Median("complete", 1, percent=True),
            "cycles": Median("cycles"),
            "from capture to all told to hunt again, s": Median(lambda row: (row["cycle_s"] or [None])[0], 1),
            "captures an hour": Median("captures_per_hour"),
            "robots attacking when an intruder is caught, of 16": Median("attackers", 1),
            "gatherings without a capture": Median("false_captures", 1, percent=True),
            f"examples for {', '.join(names[:-1])} and {names[-1]}": Median(
                lambda row: examples_in([row])[0]
            ),
        },
    )(rows)


def goal(rows: Sequence[Row]) -> StudyGoal:
    """Return the goal that 90 % of the cycles are completed, with the measured share."""
    what, wanted = "cycles completed by four squads, each with its own home", f"{GOOD:.0%}"
    return Goal(what, "together.complete", ".1%", GOOD, wanted=wanted)(Rows(rows))
