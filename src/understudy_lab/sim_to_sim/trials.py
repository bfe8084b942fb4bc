"""Trials in two worlds: the 2-D world of the lessons, and physics with the same seeds and start positions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nan
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.runtime.team.team import Team
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.scenario.schema import ElapsedSensor, Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab.forage.teach import make_practice
from understudy_lab.patrol import practice
from understudy_lab.patrol.metrics import count_cycles
from understudy_lab.patrol.tracks import watch
from understudy_lab.servoing import trials as servoing
from understudy_lab.tasks import forage_teacher, soccer
from understudy_lab.tasks.patrol_wander_teacher import DISPERSE
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.teachers.teacher import ScriptedTeacher, TeachingResult

WORLDS = 20
"""The number of worlds in which each automaton is tested; CollectivePatrol uses PATROLS."""
PATROLS, PATROL_TICKS = 2, 3000

# GoTo(A): to the station, from the place that the seed gives the robot.

GOTO_S, THERE_M = 60.0, 0.55


def teach_goto(seed: int) -> TeachingResult:
    """Teach only GoTo, as in the experiment `forage`."""
    return ScriptedTeacher(Library(FORAGE_KIT), make_practice, seed, options=forage_teacher.WATCHED).teach(
        forage_teacher.GOTO
    )


def goto(library: Library, ground: World | MujocoBody) -> list[float]:
    """Return the seconds until each robot raises `done` at the station; NaN if it never does or does so elsewhere."""
    engine = Engine.from_program(ground, link(library, "goto", {"A": "station"}))
    seconds = np.full(ground.agents, nan)
    is_done = np.zeros(ground.agents, np.bool_)
    while ground.time_s < GOTO_S and not is_done.all():
        engine.tick()
        new = engine.find_raised("done") & ~is_done
        is_done |= new
        for agent in np.flatnonzero(new).tolist():
            if _to_station(ground, agent) <= THERE_M:
                seconds[agent] = ground.time_s
    return _rounded(seconds)


def _to_station(ground: World | MujocoBody, agent: int) -> float:
    view = ground.view(agent)
    (home,) = np.flatnonzero(view.objects.home)
    return float(np.hypot(view.robots.x[0] - view.objects.x[home], view.robots.y[0] - view.objects.y[home]))


# Visual servoing: to the ball by what the camera sees.


def teach_servoing(seed: int) -> TeachingResult:
    """Teach the approach with four states, as in the experiment `servoing`."""
    return servoing.teach(seed, next(iter(topics("left"))))


def make_physics_field(body: soccer.Soccer) -> MujocoBody:
    """Return the field in physics, with each robot at its start pose in the 2-D world."""
    ground = MujocoBody(soccer.scenario(), body.seeds)
    for world in range(body.worlds):
        robot = body.view(world).robots
        ground.place(world, float(robot.x[0]), float(robot.y[0]), float(robot.heading[0]))
    return ground


def approach(library: Library, ground: soccer.Soccer | MujocoBody) -> list[float]:
    """Return the seconds until each robot is within 15 cm of the ball; NaN if the time limit came first."""
    engine = Engine.from_program(ground, link(library, "approach", {}))
    while np.isnan(ground.finished_s).any() and ground.time_s < soccer.LIMIT_S:
        engine.tick()
    return _rounded(ground.finished_s)


# Disperse: four robots wander by their sonar, and keep away from all that is near.

WANDER_S, STUCK_S, AWAY_M = 60.0, 2.0, 2.0


def teach_disperse(seed: int) -> TeachingResult:
    """Teach only Disperse, as in the experiment `patrol`."""
    teacher = ScriptedTeacher(Library(kit_of_patrol()), practice.robots_world, seed, options={})
    return teacher.teach(DISPERSE)


def kit_of_patrol() -> Any:
    """Return the kit of the patrol scenario."""
    return World(practice.scenario()).kit


def disperse(library: Library, ground: World | MujocoBody) -> list[float]:
    """Return for each world the distance in m from its start of the robot that got least far; NaN if one got stuck.

    A robot is stuck when it hardly moves for `STUCK_S` while it is commanded to drive, for example against a wall.
    """
    engine = Engine.from_program(ground, link(library, "disperse", {}))
    shape = (ground.worlds, ground.robots)
    start, last = _places(ground), _places(ground)
    farthest, still, stuck = np.zeros(shape), np.zeros(shape), np.zeros(shape, np.bool_)
    for _ in range(round(WANDER_S / ground.tick_s)):
        engine.tick()
        now = _places(ground)
        moved = np.hypot(*(now - last).T).T
        drives = np.array([engine.path(agent)[-1] == "forwards" for agent in range(ground.agents)]).reshape(
            shape
        )
        still = np.where(drives & (moved < 0.1 * 0.4 * ground.tick_s), still + ground.tick_s, 0.0)
        stuck |= still >= STUCK_S
        farthest = np.maximum(farthest, np.hypot(*(now - start).T).T)
        last = now
    return _rounded(np.where(stuck.any(axis=1), nan, farthest.min(axis=1)))


def _places(ground: World | MujocoBody) -> np.ndarray[Any, Any]:
    """Return the positions of all robots [W, N, 2], m."""
    views = [ground.view(world).robots for world in range(ground.worlds)]
    return np.array([np.stack([view.x, view.y], axis=1) for view in views])


def make_quiet_patrol_scenario() -> Scenario:
    """Return the patrol world without intruder, boss, and sensors for the time since a sighting."""
    scenario = practice.practices()["among others"]
    kind = scenario.types[practice.ROBOT]
    deaf = tuple(each for each in kind.sensors if not isinstance(each, ElapsedSensor))
    return replace(scenario, types={practice.ROBOT: replace(kind, sensors=deaf)})


# CollectivePatrol: four robots and their coordinator.


def patrol_cycles(libraries: Libraries, ground: World | MujocoBody) -> dict[str, Any]:
    """Return the numbers of captures, `cycles` and `complete` cycles, the duration of each in s, and their success.

    A cycle lasts from the capture of an intruder until the robots are ordered to disperse again. It is complete if all
    robots were at home by then, and in time. `success` is the share of complete cycles.
    """
    team = Team(
        ground, assign_team_members(practice.scenario()), libraries, {practice.SQUAD: ("collective_patrol", {})},
        worlds=ground.worlds, makes=Engine, seeds=ground.seeds,
    )  # fmt: skip
    counts = count_cycles(watch(team, PATROL_TICKS))
    values, ended = counts.pop("cycle_s"), counts["cycles"]
    return {"success": counts["complete"] / ended if ended else nan, **counts, "values": values}


def _rounded(seconds: np.ndarray[Any, Any]) -> list[float]:
    rounded: list[float] = np.round(seconds, 1).tolist()
    return rounded


def worlds_of(seed: int, count: int = WORLDS) -> range:
    """Return the seeds of the unseen worlds of a teaching; neither other teachings nor other experiments use them."""
    return range(10_000_000 + WORLDS * seed, 10_000_000 + WORLDS * seed + count)


def measure_transfer(behavior: str, seed: int) -> dict[str, Any]:
    """Teach one behavior once and return its results in both worlds."""
    return TRIED[behavior](seed)


def count_successes(values: Sequence[float], *, least: float = 0.0) -> dict[str, Any]:
    """Return the values and the share of them that are at least `least`; NaN counts as a failure."""
    return {"success": float(np.mean([value >= least for value in values])), "values": list(values)}


def _goto(seed: int) -> dict[str, Any]:
    taught, seeds = teach_goto(seed), worlds_of(seed)
    return {
        "examples": taught.examples,
        FLAT: count_successes(goto(taught.library, Forage(seeds))),
        PHYSICS: count_successes(goto(taught.library, MujocoBody(Forage([0]).scenario, seeds))),
    }


def _servoing(seed: int) -> dict[str, Any]:
    taught, seeds = teach_servoing(seed), worlds_of(seed)
    body = soccer.Soccer(seeds, soccer.ANYWHERE)
    ground = make_physics_field(body)
    return {
        "examples": taught.examples,
        FLAT: count_successes(approach(taught.library, body)),
        PHYSICS: count_successes(approach(taught.library, ground)),
    }


def _disperse(seed: int) -> dict[str, Any]:
    taught, seeds = teach_disperse(seed), worlds_of(seed)
    return {
        "examples": taught.examples,
        FLAT: count_successes(
            disperse(taught.library, World(make_quiet_patrol_scenario(), seeds)), least=AWAY_M
        ),
        PHYSICS: count_successes(
            disperse(taught.library, MujocoBody(make_quiet_patrol_scenario(), seeds)), least=AWAY_M
        ),
    }


def _patrol(seed: int) -> dict[str, Any]:
    taught, seeds = practice.teach(seed), worlds_of(seed, PATROLS)
    return {
        "examples": taught.examples,
        FLAT: patrol_cycles(taught.libraries, World(practice.scenario(), seeds)),
        PHYSICS: patrol_cycles(taught.libraries, MujocoBody(practice.scenario(), seeds)),
    }


FLAT, PHYSICS = "flat", "physics"
GOTO, SERVOING, DISPERSING, PATROL = "GoTo", "visual servoing", "Disperse", "CollectivePatrol"
TRIED: Mapping[str, Callable[[int], dict[str, Any]]] = {
    GOTO: _goto,
    SERVOING: _servoing,
    DISPERSING: _disperse,
    PATROL: _patrol,
}
