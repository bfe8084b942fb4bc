"""How fast the patrol world of the paper runs (section 6): four robots with cameras and sonar, and an intruder.

Robots disperse, attack an intruder that they see, and go home once they have it; each by itself, without a
coordinator. The automata are written by hand, in the shape of figure 5: patrol > wander | servo.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from understudy.bench.asking import Question, automaton, below, raised, seen
from understudy.bench.measuring import Case, Goal, Row, measure, result, speed
from understudy.bench.ours import Ours
from understudy.bench.standard import COMMANDS, SECTORS
from understudy.model.automaton import Automaton
from understudy.model.behavior import Behavior, Command
from understudy.model.binding import Binding
from understudy.model.feature import BoundFeature, Feature, TimeInState
from understudy.model.kinds import Continuous
from understudy.model.kit import Kit
from understudy.model.library import Library
from understudy.model.target import Target
from understudy.worlds.scenario import (
    Camera,
    Capture,
    Objects,
    Obstacle,
    Presence,
    Robots,
    RobotType,
    Scenario,
    Sonar,
    TargetOf,
)

ROBOTS, WORLDS, TICKS, ROUNDS = 4, 1_000, 500, 7
ONE, MANY = "patrol, one world", "patrol, 1000 worlds"


def scenario() -> Scenario:
    """A yard of 20 m with a home base, four robots, and an intruder that comes again and again."""
    pioneer = RobotType(
        radius=0.25,
        speed=0.7,
        turning_deg=60.0,
        color="blue",
        sensors=(Camera(), Sonar(sectors=SECTORS)),
        behaviors=COMMANDS,
    )
    intruder = Objects(
        name="intruder",
        radius=0.25,
        color="red",
        count=1,
        presence=Presence(away_s=(10.0, 30.0)),
        capture=Capture(range=1.0),
    )
    return Scenario(
        name="patrol",
        size=(20.0, 20.0),
        obstacles=(Obstacle(count=4, radius=0.5),),
        objects=(Objects(name="home", radius=0.3, color="green", at=((10.0, 10.0),), home=True), intruder),
        types={"pioneer": pioneer},
        robots=(Robots(type="pioneer", count=ROBOTS),),
        targets={"home": TargetOf(nearest="home"), "intruder": TargetOf(nearest="intruder")},
    )


def library() -> Library:
    """`patrol`, and what it runs: `wander` by sonar, `servo` toward a color by camera."""
    features = [
        Feature("blob_x", Continuous(), "blob_x", "A"),
        Feature("blob_size", Continuous(), "blob_size", "A"),
        *(Feature(f"sonar_{name}", Continuous(), name) for name in SECTORS),
    ]
    blob_x, blob_size, *sonars = features
    readings = {
        "blob_x": BoundFeature(blob_x, Binding(A="A")),
        "blob_size": BoundFeature(blob_size, Binding(A="A")),
        "intruder_size": BoundFeature(blob_size, Binding(A="intruder")),
        "time_in_state": BoundFeature(TimeInState()),
        **{name: BoundFeature(sonar) for name, sonar in zip(SECTORS, sonars, strict=True)},
    }
    free = below("left", 0.5, "right", below("right", 0.5, "left", "forward"))
    wander: dict[str, Question] = {
        "start": below("front", 0.8, "left", free),
        "forward": below("front", 0.8, below("left", 1.0, "right", "left"), free),
        "left": below("front", 1.2, "left", "forward"),
        "right": below("front", 1.2, "right", "forward"),
    }
    servo = dict.fromkeys(("start", *COMMANDS), _servo())
    basics = [Behavior(name, Command(**channels)) for name, channels in COMMANDS.items()]
    return Library.of(
        Kit.of(*features, *basics, Target("home"), Target("intruder")),
        automaton("wander", wander, readings=readings, basics=COMMANDS),
        automaton("servo", servo, readings=readings, flags=("there",), basics=COMMANDS, parameters=("A",)),
        _patrol(readings),
    )


def _servo() -> Question:
    """Toward the middle of the blob, until it is large; turn left where none is seen."""
    toward = below("blob_x", 65.0, "left", below("blob_x", 95.0, "forward", "right"))
    return seen("blob_size", below("blob_size", 1500.0, toward, "there"), "left")


def _patrol(readings: Mapping[str, BoundFeature]) -> Automaton:
    attack = seen("intruder_size", "attack", "disperse")
    return automaton(
        "patrol",
        {
            "start": attack,
            "disperse": seen("intruder_size", "attack", below("time_in_state", 30.0, "disperse", "home")),
            "attack": raised("there", "home", below("time_in_state", 20.0, "attack", "disperse")),
            "home": raised("there", "disperse", below("time_in_state", 30.0, "home", "disperse")),
        },
        readings=readings,
        runs={"disperse": "wander", "attack": "servo", "home": "servo"},
        bindings={"attack": Binding(A="intruder"), "home": Binding(A="home")},
    )


def cases() -> list[Case]:
    """One world on one thread, and many on two."""
    made = scenario(), library(), "patrol"
    return [
        Case(ONE, partial(Ours, *made), 1, 10 * TICKS),
        Case(MANY, partial(Ours, *made, worlds=WORLDS, threads=2), 2, TICKS),
    ]


GOALS = (
    Goal("one world: ticks/s", lambda rows: speed(rows, ONE, ROBOTS) / ROBOTS, least=20_000),
    Goal("side by side: robot-ticks/s", lambda rows: speed(rows, MANY, ROBOTS * WORLDS), least=2e6),
)


def run(*, rounds: int = ROUNDS) -> Row:
    """Both, and whether they are fast enough."""
    return result(measure(cases(), rounds=rounds), GOALS)
