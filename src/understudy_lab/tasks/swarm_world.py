"""The built-in swarm scenario, the same with other numbers of platoons, and hand-written automata for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import ceil, isqrt
from typing import Any

from msgspec.structs import replace

from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.library import Kit, Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import ArenaRegion, ObjectClass, RobotGroup, Scenario
from understudy.sim.team.libraries import Libraries, collect_libraries
from understudy_lab.tree_builder import (
    TreeBranch,
    TreeTest,
    build_automaton,
    split_below,
    split_on_flag,
    split_on_left,
    split_on_presence,
    split_within,
)

ROBOT, SQUAD, PLATOON, SWARM = "puller", "squad", "platoon", "swarm"
EACH = 25
"""The number of robots in a platoon."""
CELL_M = 20.0
"""The side in m of the square in which a platoon starts, with its depot in the middle."""


@cache
def scenario() -> Scenario:
    """Return the built-in swarm scenario, with eight platoons."""
    return load_scenario("swarm")


def of_platoons(platoons: int) -> Scenario:
    """Return the swarm scenario with another number of platoons, each in its own square with its depot."""
    across = ceil(platoons / isqrt(platoons))
    down = ceil(platoons / across)
    corners = [(CELL_M * (number % across), CELL_M * (number // across)) for number in range(platoons)]
    depots = tuple((x + CELL_M / 2, y + CELL_M / 2) for x, y in corners)
    home, *things = scenario().objects
    share = platoons / len(scenario().robots)
    return replace(
        scenario(),
        size=(CELL_M * across, CELL_M * down),
        regions={
            f"cell_{number}": ArenaRegion(box=(x + 1, y + 1, x + CELL_M - 1, y + CELL_M - 1))
            for number, (x, y) in enumerate(corners)
        },
        objects=(
            replace(home, at=depots),
            *(replace(thing, count=_share(thing, share)) for thing in things),
        ),
        robots=tuple(
            RobotGroup(type=ROBOT, count=EACH, within=f"cell_{number}") for number in range(platoons)
        ),
    )


def _share(thing: ObjectClass, share: float) -> int:
    return max(1, round(thing.count * share)) if isinstance(thing.count, int) else 1


@dataclass(frozen=True)
class ExpertParams:
    """The parameters of the hand-written robots and coordinators: lengths in m, angles in rad, times in s."""

    there: float = 0.4
    at: float = 1.0
    ahead: float = 0.15
    astray: float = 0.4
    waits: float = 40.0
    away: float = 15.0
    gives_up: float = 60.0
    musters: float = 120.0
    spreads: float = 10.0


def robots(kit: Kit, manners: ExpertParams = ExpertParams()) -> Library:
    """Return the hand-written automata of a robot; `alone` and `alone_answering` serve robots without a coordinator."""
    return Library.from_automata(
        kit,
        _wander(kit),
        _approach(kit, manners),
        _haul(kit, manners),
        _search(kit),
        _join(kit, manners, "help", "crate", "caller", "hold_and_call"),
        _join(kit, manners, "muster", "container", "musterer", "hold_and_muster"),
        _alone(kit, manners, answers=False),
        _alone(kit, manners, answers=True),
    )


def _timed(seconds: float, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    return split_below("time", seconds, no, yes)


def _vain(seconds: float, unheard: str, other: str, here: str) -> TreeTest:
    """Return a test that stays `here` until no robot calls for a while or the given seconds are over, then `other`."""
    return _timed(seconds, other, _timed(4.0, split_on_flag(unheard, other, here), here))


def _readings(kit: Kit, targets: tuple[str, ...] = ()) -> Mapping[str, BoundFeature]:
    readings = {name: BoundFeature(each) for name, each in kit.features.items() if not each.parameters}
    for name, each in kit.features.items():
        if each.parameters:
            readings |= {f"{name} {target}": BoundFeature(each, Binding(A=target)) for target in targets}
    return readings | {"time": BoundFeature(TimeInState())}


def _automaton(kit: Kit, name: str, asks: Mapping[str, TreeBranch], *of: str, **more: Any) -> Automaton:
    return build_automaton(name, asks, readings=_readings(kit, of), **more)


def _wander(kit: Kit) -> Automaton:
    turned = split_below("chance", 0.3, "{}", "forward")
    return _automaton(
        kit,
        "wander",
        {
            "start": "forward",
            "forward": split_on_flag("stuck", "left", split_below("chance", 0.04, "left", "forward")),
            "left": TreeTest(turned.feature, "left", "forward", below=0.3),
        },
        runs={"forward": "forward", "left": "rotate_left"},
    )


def _approach(kit: Kit, m: ExpertParams) -> Automaton:
    def way(ahead: float) -> TreeBranch:
        turn = split_within("angle_to A", ahead, "forward", split_on_left("angle_to A", "left", "right"))
        return split_on_presence(
            "distance_to A", split_below("distance_to A", m.there, "done", turn), "failed"
        )

    return _automaton(
        kit,
        "approach",
        {"start": way(m.ahead), "forward": way(m.astray), "left": way(m.ahead), "right": way(m.ahead)},
        "A",
        runs={"forward": "forward", "left": "rotate_left", "right": "rotate_right"},
        flags=("done", "failed"),
        parameters=("A",),
    )


def _haul(kit: Kit, m: ExpertParams) -> Automaton:
    def way(ahead: float) -> TreeBranch:
        turn = split_within(
            "angle_to home", ahead, "forward", split_on_left("angle_to home", "left", "right")
        )
        return split_on_flag("enough", turn, split_on_flag("holding", "drop", "done"))

    return _automaton(
        kit,
        "haul",
        {
            "start": way(m.ahead),
            "forward": way(m.astray),
            "left": way(m.ahead),
            "right": way(m.ahead),
            "drop": split_on_flag("holding", "drop", "done"),
        },
        "home",
        runs={"forward": "pull_forward", "left": "pull_left", "right": "pull_right", "drop": "let_go"},
        flags=("done",),
    )


def _search(kit: Kit) -> Automaton:
    look = split_on_presence(
        "distance_to free_container",
        "container",
        split_on_presence("distance_to free_crate", "crate", "wander"),
    )
    begin = split_on_flag("enough", "haul", split_on_flag("holding", "drop", look))
    return _automaton(
        kit,
        "search",
        {
            "start": begin,
            "haul": split_on_flag("done", "wander", "haul"),
            "drop": begin,
            "wander": look,
            "crate": split_on_flag("done", "done", split_on_flag("failed", "wander", "crate")),
            "container": split_on_flag("done", "done", split_on_flag("failed", "wander", "container")),
        },
        "free_crate",
        "free_container",
        runs={
            "haul": "haul",
            "drop": "let_go",
            "wander": "wander",
            "crate": "approach",
            "container": "approach",
        },
        bindings={"crate": Binding(A="free_crate"), "container": Binding(A="free_container")},
        flags=("done",),
    )


def _join(kit: Kit, m: ExpertParams, name: str, thing: str, caller: str, calls: str) -> Automaton:
    of_caller, free = f"distance_to {caller}", f"distance_to free_{thing}"
    begin = split_below(free, m.at, "call", split_on_presence(of_caller, "come", "wait"))
    begin = split_on_flag("enough", "haul", split_on_flag("holding", "drop", begin))
    return _automaton(
        kit,
        name,
        {
            "start": begin,
            "drop": begin,
            "wait": split_on_presence(of_caller, "come", "wait"),
            "come": split_on_flag("done", "hold", split_on_flag("failed", "wait", "come")),
            "call": split_on_flag("enough", "haul", "call"),
            "hold": split_on_flag("enough", "haul", split_on_flag("holding", "hold", "wait")),
            "haul": split_on_flag("done", "wait", "haul"),
        },
        f"free_{thing}",
        caller,
        runs={
            "drop": "let_go",
            "wait": "wander",
            "come": "approach",
            "call": calls,
            "hold": "hold",
            "haul": "haul",
        },
        bindings={"come": Binding(A=caller)},
    )


def _alone(kit: Kit, m: ExpertParams, *, answers: bool) -> Automaton:
    """Return the automaton of a robot without a coordinator, which may answer calls of others."""
    heard = split_on_presence("distance_to caller", "help", "search") if answers else "search"
    helps = {"help": _timed(m.gives_up, "leave", split_on_flag("holding", "help", "help"))} if answers else {}
    asks: dict[str, TreeBranch] = {
        "start": "search",
        "search": split_on_flag("done", "call", heard),
        "call": split_on_flag("enough", "haul", _timed(m.waits, "leave", "call")),
        **helps,
        "haul": split_on_flag("done", "search", "haul"),
        "leave": split_on_flag("holding", "leave", "away"),
        "away": _timed(m.away, "search", "away"),
    }
    runs = {"search": "search", "call": "hold_and_call", "help": "help", "haul": "haul", "leave": "let_go"}
    name = "alone_answering" if answers else "alone"
    return _automaton(kit, name, asks, "caller", runs={**runs, "away": "wander"})


def _joint(
    kit: Kit, name: str, runs: Mapping[str, str], found: tuple[str, str], caller: str, seconds: float
) -> Library:
    """Return the automaton of a coordinator: all run the first behavior until one has found a thing, then the other."""
    work, join = runs
    asks: dict[str, TreeBranch] = {
        "start": work,
        work: split_on_flag(" ".join(found), join, work),
        join: _vain(seconds, f"unheard {caller}", work, join),
    }
    return Library.from_automata(kit, _automaton(kit, name, asks, found[1], caller, runs=runs))


def squad(kit: Kit, m: ExpertParams = ExpertParams()) -> Library:
    """Return the hand-written automata of a squad's coordinator."""
    runs = {"search": "search", "help": "help"}
    return _joint(kit, "squad_work", runs, ("someone_at", "free_crate"), "caller", m.gives_up)


def platoon(kit: Kit, m: ExpertParams = ExpertParams()) -> Library:
    """Return the hand-written automata of a platoon's coordinator."""
    runs = {"work": "squad_work", "muster": "muster"}
    return _joint(kit, "platoon_work", runs, ("found", "free_container"), "musterer", m.musters)


def swarm(kit: Kit, m: ExpertParams = ExpertParams()) -> Library:
    """Return the hand-written automata of the swarm's coordinator."""
    made = _automaton(
        kit,
        "swarm_work",
        {"start": "spread", "spread": _timed(m.spreads, "work", "spread"), "work": "work"},
        runs={"spread": "forward", "work": "platoon_work"},
    )
    return Library.from_automata(kit, made)


_OF = {SQUAD: squad, PLATOON: platoon, SWARM: swarm}


def make_expert_libraries() -> Libraries:
    """Return the hand-written libraries of the robots and of all levels of coordinators."""
    return collect_libraries(
        scenario(), robots(make_scenario_kit(scenario())), lambda name, kit: _OF[name](kit)
    )
