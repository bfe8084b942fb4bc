"""The tasks of the novices: approaching a ball (paper section 4.2), and GoTo (paper section 4.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import atan2, cos, isnan, pi, radians, sin, tau
from types import MappingProxyType

import numpy as np

from understudy.errors import SettingError
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.sim.forage import FORAGE_KIT as forage_kit
from understudy.sim.forage import Forage, make_practice_worlds
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.novices.novice import UNDERSTOOD, Novice
from understudy_lab.novices.study import judge as judge_servoing
from understudy_lab.novices.teach_live import BY_THE_BALL, Placement, draw_seed
from understudy_lab.tasks import soccer
from understudy_lab.tasks.forage_teacher import GOTO
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import Soccer

THERE_M = 0.3
"""The distance in m that counts as arrived for a novice without misjudgment."""
PLAINLY = 1.5
"""The multiple of that distance at which the robot has clearly not arrived."""
ASTRAY, FACING = 0.6, 0.12
"""The bearings in rad from which the robot has to turn, and at which it has turned enough."""
OFF_RAD = 0.15
"""The largest error of a novice in judging straight ahead, rad."""


class GotoNovice(Novice):
    """A novice who teaches GoTo(A); a misunderstanding concerns the direction of a turn."""

    buttons = ("forward", "rotate_left", "rotate_right", "done")

    def there(self, screen: SessionView) -> bool:
        """Return whether the robot has raised `done` and also looks arrived to this novice."""
        return screen.flag is not None and self.wish(screen) is None

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where this novice accepts the current one."""
        distance, state = screen.features["distance_to(A)"], screen.state
        if isnan(distance):
            return None
        there_m = THERE_M * (1.0 + self.traits.misjudged)
        if distance < (PLAINLY * there_m if screen.flag is not None else there_m):
            return None if screen.flag is not None else "done"
        off = (screen.features["angle_to(A)"] + OFF_RAD * self.traits.off_middle_px / 20.0 + pi) % tau - pi
        if state in ("start", "forward", "done"):
            return self._turn(off) if abs(off) > ASTRAY else None if state == "forward" else "forward"
        ahead = off if state == "rotate_left" else -off
        return "forward" if -ASTRAY < ahead < FACING else None

    def _turn(self, off: float) -> str:
        """Return the turn that this novice chooses for a target `off` rad to the left."""
        side = "rotate_left" if off > 0 else "rotate_right"
        if self.traits.mistake == UNDERSTOOD:
            return side
        if self.traits.mistake == "one only":
            return "rotate_left"
        return "rotate_left" if self._either == "forwardL" else "rotate_right"


PLACES = 30
"""The number of test worlds for GoTo, equal to the trials of the approach to a ball."""
REACTION_S = 0.3
"""The reaction time in s set in the lesson of GoTo: that of the fastest novices."""
LIMIT_S, REACHED_M = 60.0, 0.6
"""The time limit in s, and the distance in m from the station within which `done` counts."""


@dataclass(frozen=True)
class CoachingTask:
    """A task: its world and empty lesson, the class of its novices, how they place the robot, and how it is tested.

    `judge` returns the share of successful trials, and whether each kind of trial succeeds at least half of the time.
    """

    kit: Kit
    person: type[Novice]
    body: Callable[[int], World | Soccer]
    lesson: Callable[[], Lesson]
    placement: Placement
    judge: Callable[[TrainedAutomaton, int], tuple[float, bool]]
    targets: Mapping[str, str] = field(default_factory=dict)


def _servoed(taught: TrainedAutomaton, seed: int) -> tuple[float, bool]:
    reached = [[each == each for each in times] for times in judge_servoing(taught, seed).values()]
    return float(np.mean(reached)), all(2 * sum(of) >= len(of) for of in reached)


ASIDE_DEG: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"ball left": (20.0, 130.0), "ball right": (-130.0, -20.0), "ball lost": (120.0, 240.0)}
)
"""The range of the station's bearing in degrees where the robot is put down, by situation."""
FARTHEST_M, TRIES = 4.0, 50


def _put_down_by_the_station(novice: Novice, session: Session, situation: str) -> None:
    session.reset(draw_seed(novice))
    body = session.body
    station = find_target_place(body, "station", session.agent) if isinstance(body, World) else None
    if not isinstance(body, World) or station is None:
        return
    for _ in range(TRIES):
        far, side = novice.draws.uniform(0.2 * FARTHEST_M, FARTHEST_M), novice.draws.uniform(0.0, tau)
        bearing = radians(novice.draws.uniform(*ASIDE_DEG[situation]))
        x, y = station[0] + far * cos(side), station[1] + far * sin(side)
        try:
            body.place(session.agent, x, y, atan2(station[1] - y, station[0] - x) - bearing)
        except SettingError:  # no free place: they try another
            continue
        break
    session.note_moved()


def _went(taught: TrainedAutomaton, seed: int) -> tuple[float, bool]:
    body = Forage(range(PLACES * seed, PLACES * (seed + 1)), make_practice_worlds()["an arena"])
    engine = Engine.from_program(
        body, link(Library(forage_kit).with_automaton(taught), "goto", {"A": "station"})
    )
    engine.run(round(LIMIT_S / body.tick_s))
    distance = body.sense([("range", "station")])["range", "station"]
    there = [engine.path(agent)[0] == "done" and distance[agent] < REACHED_M for agent in range(PLACES)]
    return float(np.mean(there)), 2 * sum(there) >= PLACES


EXERCISES: Mapping[str, CoachingTask] = MappingProxyType(
    {
        "servoing": CoachingTask(
            soccer.kit,
            Novice,
            lambda seed: Soccer([seed]),
            lambda: four_states(Library(soccer.kit)),
            BY_THE_BALL,
            _servoed,
        ),
        "goto": CoachingTask(
            forage_kit,
            GotoNovice,
            lambda seed: Forage([seed], make_practice_worlds()["an arena"]),
            lambda: replace(GOTO.choose(Library(forage_kit)), options=LearnerOptions(reaction_s=REACTION_S)),
            Placement(_put_down_by_the_station),
            _went,
            {"A": "station"},
        ),
    }
)
