"""A patrol written by hand: robots that wander and servo, and a coordinator that sends them out and home."""

from __future__ import annotations

from understudy.bench.asking import Ask, automaton, raised
from understudy.bench.patrol import library
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.feature import BoundFeature
from understudy.model.library import Library
from understudy.worlds.scenario_files import load_scenario
from understudy.worlds.teams import Libraries, libraries_of

SCENARIO = load_scenario("patrol")
ROBOTS = library()


def lead() -> Automaton:
    """Out; where somebody sees an intruder, all at it; where somebody is there, all home; where all are, out again."""
    features = libraries_of(SCENARIO, ROBOTS)["patrol"].kit.features
    readings = {
        "sees": BoundFeature(features["someone_sees"], Binding(A="intruder")),
        "someone_there": BoundFeature(features["someone_done"]),
        "all_there": BoundFeature(features["all_done"]),
    }
    return automaton(
        "lead",
        {
            "start": "out",
            "out": Ask("sees", "attack", "out"),
            "attack": raised("someone_there", "home", "attack"),
            "home": raised("all_there", "out", "home"),
        },
        readings=readings,
        runs={"out": "wander", "attack": "servo", "home": "servo"},
        bindings={"attack": Binding(A="intruder"), "home": Binding(A="home")},
    )


def known() -> Libraries:
    """What everybody knows."""
    return libraries_of(SCENARIO, ROBOTS, lambda name, kit: Library.of(kit, lead()))
