"""Four patrols in a world with four homes, under a coordinator of coordinators (paper section 5, Figure 4 C)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.runtime.team.team import Team
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, make_team
from understudy_lab.declaration import ColumnPerGroup, Goal
from understudy_lab.lesson_stats import examples_in, lessons_of
from understudy_lab.patrol.evaluate import TICKS, rounds, worlds_of
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.practice import NEVER, ROBOT, SQUAD, robots_world, teach
from understudy_lab.patrol.tracks import PatrolTracks, watch
from understudy_lab.rows import Median, Rows
from understudy_lab.study import ResultTable, Row, StudyGoal
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher
from understudy_lab.teams import TeamCourse, TeamTeaching, make_team_libraries

TOP, BEHAVIOR = "garrison", "guard"
HOMES = ("home_north", "home_east", "home_south", "home_west")
"""The home of each patrol, in order."""


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


COURSE = TeamCourse(
    scenario,
    {TOP: patrol_squad_teacher.GUARD_TOPICS},
    robots_world,
    lambda: {"on guard": make_quiet_scenario()},
)


def teach_four_patrols(seed: int) -> TeamTeaching:
    """Teach robots and one patrol in the world `patrol`, then the top coordinator in the world of four patrols."""
    one = teach(seed, {ROBOT: patrol_teacher.TOPICS, SQUAD: patrol_squad_teacher.PATROL_TOPICS})
    return TeamTeaching({**one.by_sort, **COURSE.teach(seed, taught=one.libraries).by_sort})


def make_guarding_team(libraries: Libraries, seeds: Sequence[int]) -> Team:
    """Make the taught team, with one world per seed."""
    return make_team(scenario(), seeds, make_team_libraries(scenario(), libraries), {TOP: (BEHAVIOR, {})})


WORLDS = 50
GOOD = 0.9


def measure_four_patrols(seed: int) -> Row:
    """Teach all agents with one seed and test them in their own unseen worlds."""
    taught = teach_four_patrols(seed)
    team = make_guarding_team(taught.libraries, worlds_of(seed)[:WORLDS])
    return {
        "together": summarize_four_patrols(watch(team, TICKS, homes=HOMES)),
        "lessons": [lesson for sort in (SQUAD, TOP) for lesson in lessons_of(taught.by_sort[sort])],
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
