"""The speed of the paper's patrol world (section 6): four robots with cameras and sonar, and an intruder.

Robots disperse, attack an intruder that they see, and go home once they have reached it, uncoordinated or under a
coordinator. The automata are hand-written, in the shape of figure 5: patrol > wander | servo.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, collect_libraries
from understudy_lab.bench.harness import (
    BenchCase,
    BenchGoal,
    Row,
    TeamCase,
    UnderstudyCase,
    measure,
    result,
    speed,
)
from understudy_lab.tree_builder import (
    TreeBranch,
    TreeTest,
    build_automaton,
    split_below,
    split_on_flag,
    split_on_presence,
)

BASICS = ("forwards", "left", "right")
SECTORS = ("front_left", "front_right", "rear")
ROBOTS, WORLDS, TICKS, ROUNDS = 4, 1_000, 500, 7
ONE, MANY, LED = "patrol, one world", "patrol, 1000 worlds", "patrol, one world with a coordinator"


def scenario() -> Scenario:
    """Return the built-in patrol scenario: home base, obstacles, an intruder and a boss that come and go."""
    return load_scenario("patrol")


def library() -> Library:
    """Return the behavior `patrol` and its parts: `wander` by sonar, `servo` toward a color by camera."""
    kit = make_scenario_kit(scenario())
    blob_x, blob_size = kit.features["blob_x"], kit.features["blob_size"]
    sonars = {name: BoundFeature(kit.features[f"sonar_{name}"]) for name in SECTORS}
    readings = {
        "blob_x": BoundFeature(blob_x, Binding(A="A")),
        "blob_size": BoundFeature(blob_size, Binding(A="A")),
        "intruder_size": BoundFeature(blob_size, Binding(A="intruder")),
        "time_in_state": BoundFeature(TimeInState()),
        **sonars,
    }
    free = split_below("front_left", 0.5, "right", split_below("front_right", 0.5, "left", "forwards"))
    wander: dict[str, TreeBranch] = {
        "start": free,
        "forwards": free,
        "left": split_below("front_right", 1.0, "left", split_below("front_left", 0.8, "left", "forwards")),
        "right": split_below(
            "front_left", 1.0, "right", split_below("front_right", 0.8, "right", "forwards")
        ),
    }
    servo = dict.fromkeys(("start", *BASICS), _servo())
    return Library.from_automata(
        kit,
        build_automaton("wander", wander, readings=readings, basics=BASICS),
        build_automaton("servo", servo, readings=readings, flags=("done",), basics=BASICS, parameters=("A",)),
        _patrol(readings),
    )


def _servo() -> TreeBranch:
    """Return a tree that steers to the middle of the blob until it is large, and turns left where none is visible."""
    toward = split_below("blob_x", 65.0, "left", split_below("blob_x", 95.0, "forwards", "right"))
    return split_on_presence("blob_size", split_below("blob_size", 1500.0, toward, "done"), "left")


def _patrol(readings: Mapping[str, BoundFeature]) -> Automaton:
    attack = split_on_presence("intruder_size", "attack", "disperse")
    return build_automaton(
        "patrol",
        {
            "start": attack,
            "disperse": split_on_presence(
                "intruder_size", "attack", split_below("time_in_state", 30.0, "disperse", "home")
            ),
            "attack": split_on_flag("done", "home", split_below("time_in_state", 20.0, "attack", "disperse")),
            "home": split_on_flag("done", "disperse", split_below("time_in_state", 30.0, "home", "disperse")),
        },
        readings=readings,
        runs={"disperse": "wander", "attack": "servo", "home": "servo"},
        bindings={"attack": Binding(A="intruder"), "home": Binding(A="home")},
    )


def lead() -> Automaton:
    """Return the coordinator's automaton: disperse, attack on a sighting, go home on arrival, then disperse again."""
    features = collect_libraries(scenario(), library())["patrol"].kit.features
    readings = {
        "sees": BoundFeature(features["someone_sees"], Binding(A="intruder")),
        "someone_there": BoundFeature(features["someone_done"]),
        "all_there": BoundFeature(features["all_done"]),
    }
    return build_automaton(
        "lead",
        {
            "start": "out",
            "out": TreeTest("sees", "attack", "out"),
            "attack": split_on_flag("someone_there", "home", "attack"),
            "home": split_on_flag("all_there", "out", "home"),
        },
        readings=readings,
        runs={"out": "wander", "attack": "servo", "home": "servo"},
        bindings={"attack": Binding(A="intruder"), "home": Binding(A="home")},
    )


def make_libraries() -> Libraries:
    """Return the libraries of robots and coordinators."""
    return collect_libraries(scenario(), library(), lambda name, kit: Library.from_automata(kit, lead()))


def cases() -> list[BenchCase]:
    """Return the cases: one world on one thread, and many on two."""
    made = scenario(), library(), "patrol"
    return [
        BenchCase(ONE, partial(UnderstudyCase, *made), 1, 10 * TICKS),
        BenchCase(LED, partial(TeamCase, scenario(), make_libraries(), {"patrol": "lead"}), 1, 10 * TICKS),
        BenchCase(MANY, partial(UnderstudyCase, *made, worlds=WORLDS, threads=2), 2, TICKS),
    ]


GOALS = (
    BenchGoal("one world: ticks/s", lambda rows: speed(rows, ONE, ROBOTS) / ROBOTS, least=20_000),
    BenchGoal("with a coordinator: ticks/s", lambda rows: speed(rows, LED, ROBOTS) / ROBOTS, least=15_000),
    BenchGoal("side by side: robot-ticks/s", lambda rows: speed(rows, MANY, ROBOTS * WORLDS), least=2e6),
)


def run(*, rounds: int = ROUNDS) -> Row:
    """Measure all cases, and compare them with the goals."""
    return result(measure(cases(), rounds=rounds), GOALS)
