"""The experiment: independent teachings of robots and three levels of coordinators, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, cast

import numpy as np

from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab import teams
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.lesson_stats import LIVE_TEACHINGS, LessonTable, LiveComparison, examples_in, lessons_of
from understudy_lab.rows import Groups, Median, Rows
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.swarm.practice import make_swarm_team, teach
from understudy_lab.tasks.swarm_world import (
    EACH,
    PLATOON,
    ROBOT,
    SQUAD,
    SWARM,
    make_expert_libraries,
    of_platoons,
)
from understudy_lab.teachers.live_teacher import LIVE
from understudy_lab.teams import FAILING, run_with_failures, world_of

WORLDS, TICKS = 10, 6_000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: ten minutes."""
LOADS: Mapping[str, int] = {"crate": 1, "container": 10}
"""A container, which takes sixteen robots, holds as much as ten crates, which take four each."""
PLATOONS, LARGE_TICKS = 400, 3_000
"""The number of platoons of the ten thousand robots, and the ticks they run: five minutes."""
FAILS_TICK = (1_000, 3_000)
"""The range of ticks in which robots fail at random; only the yield after it counts."""
THREE, TWO, ONE, ANSWERING, ALONE = (
    "three levels",
    "platoons",
    "squads",
    "alone, answering calls",
    "alone",
)
WAYS: Mapping[str, tuple[str, str]] = {
    THREE: (SWARM, "swarm_work"),
    TWO: (PLATOON, "platoon_work"),
    ONE: (SQUAD, "squad_work"),
    ANSWERING: (ROBOT, "alone_answering"),
    ALONE: (ROBOT, "alone"),
}
"""The type of agent that starts a behavior, and that behavior, by degree of coordination."""


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_swarm(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Measure the hourly yield of a swarm in all variants.

    The variants are: each degree of coordination, hand-written automata, a third of the robots failing, and ten
    thousand robots.
    """
    by_way = {
        way: measure_gathered(make_swarm_team(libraries, worlds, way=runs), ticks)
        for way, runs in WAYS.items()
    }
    whole, killed = (
        measure_late_gathering(make_swarm_team(libraries, worlds), ticks, fails)
        for fails in ({}, schedule_failures(worlds))
    )
    large = make_swarm_team(libraries, worlds[:1], of_platoons(PLATOONS))
    same = make_swarm_team(libraries, worlds)
    return {
        "taught": by_way,
        "by_hand": measure_gathered(make_swarm_team(make_expert_libraries(), worlds), ticks),
        "kept": round(killed / whole, 4) if whole else 0.0,
        "large": _each(large, min(ticks, LARGE_TICKS)),
        "small": _each(same, min(ticks, LARGE_TICKS)),
    }


def measure_gathered(team: Team, ticks: int) -> dict[str, float]:
    """Run a team and return its crates, containers and loads (see LOADS) per hour."""
    team.run(ticks)
    return _rates(world_of(team))


def measure_late_gathering(team: Team, ticks: int, fails: Mapping[int, Sequence[int]]) -> float:
    """Return the loads per hour after the last possible failure; `fails` maps a tick to the robots that fail in it."""
    world, at = world_of(team), FAILS_TICK[1]
    run_with_failures(team, at, fails)
    early = _loads(world)
    team.run(ticks - at)
    return (_loads(world) - early) / ((ticks - at) * world.tick_s / 3600 * world.worlds)


schedule_failures = partial(teams.schedule_failures, robots=8 * EACH, within=FAILS_TICK)


def _each(team: Team, ticks: int) -> float:
    """Run a team and return the loads that one robot gathers per hour."""
    world = world_of(team)
    team.run(ticks)
    return round(_rates(world)["loads"] * world.worlds / world.agents, 2)


def _rates(world: World) -> dict[str, float]:
    hours = world.worlds * world.time_s / 3600
    things = {f"{name}s": count / hours for name, count in _counted(world).items()}
    rates = {**things, "loads": _loads(world) / hours}
    return {name: round(rate, 1) for name, rate in rates.items()}


def _loads(world: World) -> float:
    return sum(count * LOADS[name] for name, count in _counted(world).items())


def _counted(world: World) -> dict[str, float]:
    """Return the number of gathered objects of each class over all worlds."""
    rules, objects = world.rules.classes, world.state.objects["gathered"].sum(axis=0)
    counts = {}
    for name in LOADS:
        number = world.names.classes.index(name)
        of_class = slice(int(rules["first"][number]), int(rules["end"][number]))
        counts[name] = float(objects[of_class].sum())
    return counts


TEACHINGS = range(60_100, 60_110)
"""The teaching seeds of the published result; none was used during development."""
AS_GOOD, WITHOUT = 0.8, 0.7
WEIGHTS = (1, 4, 10)
"""The numbers of crates that a container may count as: one box, the squads it needs, the crates it holds."""
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
BY_HAND = "by hand"
NAMES = {
    THREE: "all, platoons, squads",
    TWO: "platoons, squads",
    ONE: "squads",
    ANSWERING: "none; calls answered",
    ALONE: "none",
    BY_HAND: "all three, hand-written",
}
SHORT = ("three\nlevels", "platoons,\nsquads", "squads", "alone,\nanswering", "alone")
LARGE = f"{EACH * PLATOONS:,}".replace(",", " ")


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per seed, and unless quick, a few that are taught live."""
    live = [] if plan.quick else plan.seeds[:LIVE_TEACHINGS]
    return [*({"seed": seed} for seed in plan.seeds), *({"method": LIVE, "seed": seed} for seed in live)]


def work(task: Task) -> Row:
    """Teach a swarm with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"], method=task.get("method", "watched"))
    lessons = {sort: lessons_of(teaching) for sort, teaching in taught.by_sort.items()}
    return {**measure_swarm(taught.libraries, worlds_of(task["seed"])), "lessons": lessons}


def _yield(row: Row, way: str) -> Mapping[str, float]:
    return cast("Mapping[str, float]", row["by_hand"] if way == BY_HAND else row["taught"][way])


def _compare(way: str, to: str = BY_HAND) -> Callable[[Row], float]:
    """Return a function that compares the loads that are gathered in two ways."""
    return lambda row: _divide(_yield(row, way)["loads"], _yield(row, to)["loads"])


def _weigh(row: Row, way: str, weight: int) -> float:
    """Return the yield per hour in crates, with a container counted as `weight` crates."""
    return _yield(row, way)["crates"] + weight * _yield(row, way)["containers"]


def _divide(one: float, other: float) -> float:
    return round(one / max(1e-9, other), 3)


def _large(row: Row) -> float:
    """Return the yield per robot among ten thousand, relative to that among two hundred in the same time."""
    return _divide(row["large"], row["small"])


def _examples(row: Row) -> int:
    return examples_in([row])[0]


def _by_way(*ways: str) -> Groups:
    return lambda rows: {way: Rows({**row, **_yield(row, way), "way": way} for row in rows) for way in ways}


def _share(rows: Rows) -> str:
    way = rows[0]["way"]
    return "1" if way == BY_HAND else Median(_compare(way), 2)(rows)


def _headline(rows: Rows) -> str:
    three, alone, answering = (rows.median(_compare(way)) for way in (THREE, ALONE, ANSWERING))
    return (
        "Two hundred taught robots under three levels of taught coordinators gather "
        f"{three:.2f} times as much as hand-written automata, in unseen worlds. The same robots gather {alone:.2f} "
        f"times as much without coordinators, and {answering:.2f} times as much if they answer each other's calls. Ten "
        f"thousand robots with the same libraries gather {rows.median(_large):.2f} times as much per robot. All "
        f"lessons together take {rows.median(_examples):.0f} examples."
    )


def _notes(rows: Rows) -> tuple[str, ...]:
    squads, platoons = (rows.median(_compare(way, THREE)) for way in (ONE, TWO))
    crates, alone = (
        min((compare(row), row["task"]["seed"]) for row in rows)
        for compare in (
            lambda row: row["taught"][THREE]["crates"] / row["by_hand"]["crates"],
            _compare(ALONE),
        )
    )
    least = max(
        np.median(
            [_divide(_weigh(row, way, n), max(_weigh(row, ONE, n), _weigh(row, THREE, n))) for row in rows]
        )
        for way in (ANSWERING, ALONE)
        for n in WEIGHTS
    )
    return (
        f"Contribution of each level: with coordinators of squads only, robots gather {squads:.2f} of what all three "
        f"levels gather; with coordinators of platoons, too, {platoons:.2f}. The top coordinator costs some yield, "
        "because it first has all robots spread out. Its only benefit here is that one order moves two hundred robots.",
        f"That a container holds {LOADS['container']} crates is a property of this world, and it decides whether "
        "platoons pay. If a container counts as one crate, or as four (it takes four squads), coordinators of squads "
        "alone gather more, because gathering sixteen robots costs the crates that they leave. With any of these "
        f"weights, robots without coordinators gather at most {least:.2f} of the better of these two (median).",
        f"Worst teachings: under three levels, {crates[0]:.2f} of the crates of the hand-written automata (seed "
        f"{crates[1]}); robots alone, {alone[0]:.2f} of their loads (seed {alone[1]}). In these teachings, a lesson "
        "never succeeded.",
        f"Each of {LARGE} robots, in 400 platoons, gathers {Median(_large, 2)(rows)} times as much in five minutes as "
        "each of the two hundred robots for which the lessons were made. In both worlds, robots pass through each "
        "other.",
    )


EXPERIMENT = Study(
    name="swarm",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            LinePerGroup(
                f"Yield per hour, in runs of ten minutes, teachings {{seeds}}, {WORLDS} unseen worlds each: "
                f"median (worst–best). A container holds {LOADS['container']} loads, a crate one",
                ["coordinators of"],
                _by_way(*NAMES),
                {
                    **{f"{what}/h": Median(what) for what in ("crates", "containers", "loads")},
                    "loads / hand-written": _share,
                },
                lambda way: [NAMES[way]],
            ),
            LinePerGroup(
                "Yield relative to all three taught levels, if a container counts as that number of crates",
                ["coordinators of"],
                _by_way(ONE, ANSWERING, ALONE),
                {
                    str(n): Median(
                        lambda row, n=n: _divide(_weigh(row, row["way"], n), _weigh(row, THREE, n)), 2
                    )
                    for n in WEIGHTS
                },
                lambda way: [NAMES[way]],
            ),
            LessonTable("agent"),
        ),
        goals=(
            Goal(
                "yield of the taught hierarchy, relative to a hand-written one",
                Median(_compare(THREE), 2),
                "",
                AS_GOOD,
            ),
            *(
                Goal(
                    f"yield without coordinators ({way}), relative to the taught hierarchy",
                    Median(_compare(way, THREE), 2),
                    "",
                    most=WITHOUT,
                )
                for way in (ALONE, ANSWERING)
            ),
            Goal(
                "share of the yield kept after a third of the robots was killed",
                Median("kept", percent=True),
                least=KEPT,
                wanted=f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            ),
        ),
        notes=_notes,
        numbers=lambda rows: {
            "teachings": len(rows),
            "shares": {way: rows.values(_compare(way)) for way in WAYS},
            "large": rows.values(_large),
            "examples": examples_in(rows),
        },
        live=LiveComparison(
            _examples,
            {
                "loads, relative to hand-written automata": _compare(THREE),
                "share of the yield kept after a third of the robots was killed": "kept",
            },
        ),
    ),
    draw=Panels(
        (
            Dots(
                "with fewer levels of coordinators",
                "loads / hand-coded",
                by_value(dict(zip(map(_compare, WAYS), SHORT, strict=True))),
                limits=(0, None),
                dotted=1.0,
            ),
            Dots(
                "with fewer and more robots",
                "of what 200 gather, each",
                by_value({"kept": "a third\nkilled", _large: f"{LARGE}\nrobots"}),
                limits=(0, None),
                dotted=1.0,
            ),
        ),
        wide=4.2,
        prepare=lambda rows: rows.where(method=None),
    ),
    worlds=("swarm",),
)
