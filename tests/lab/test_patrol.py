"""Judging a patrol: cycles, sightings, and encounters with the boss, in worlds written down by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.make.programs import make_automaton

from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.patrol.evaluate import DEFER, count_flat_states, states_of
from understudy_lab.patrol.metrics import (
    captures,
    count_joint_attacks,
    cycles,
    encounters,
    false_homes,
    residual_s,
)
from understudy_lab.patrol.practice import (
    ROBOT,
    SQUAD,
    make_coordinated_team,
    practices,
    scenario,
    squad_practices,
    teach,
)
from understudy_lab.patrol.tracks import ATTACK, DISPERSE, HOME, RUN_AWAY, ObjectTrack, PatrolTracks, watch
from understudy_lab.results import load_published
from understudy_lab.teams import make_team_libraries

TICK_S = 1.0


def tracks(
    *spans: tuple[int, int], until: int | None = None, away: float = 1.0, **given: Any
) -> PatrolTracks:
    """One world with one robot `away` meters from home: for so many ticks it does this; an intruder `until` a tick."""
    doing = np.concatenate([np.full(ticks, what, np.int8) for what, ticks in spans])[:, None, None]
    shape = doing.shape
    there = np.zeros(shape[:2], np.bool_)
    there[:until] = until is not None
    nothing = np.zeros(shape, np.bool_)
    place = np.zeros(shape[:2], np.float32)
    made: dict[str, Any] = {
        "tick_s": TICK_S,
        "doing": doing,
        "x": np.full(shape, away, np.float32),
        "y": np.zeros(shape, np.float32),
        "heading": np.zeros(shape, np.float32),
        "sees": nothing,
        "sees_boss": nothing,
        "intruder": ObjectTrack(there, place + 50.0, place),
        "boss": ObjectTrack(np.ones(shape[:2], np.bool_), place - 4.0, place),
        "home": np.zeros((shape[2], 2)),
        "firsts": np.arange(shape[2]),
        "obstacles": np.zeros((1, 0, 3)),
    }
    return PatrolTracks(**(made | given))


CYCLES = [  # what it does for how many ticks, when the intruder is gone, how far from home: complete or not
    (((ATTACK, 10), (HOME, 30), (DISPERSE, 9)), 11, 1.0, [True]),
    (((ATTACK, 10), (HOME, 30), (DISPERSE, 9)), 11, 3.5, [False]),
    (((ATTACK, 10), (HOME, 150), (DISPERSE, 9)), 11, 1.0, [False]),
    (((ATTACK, 10), (HOME, 70)), 11, 1.0, [False]),  # still open after a minute
    (((ATTACK, 10), (HOME, 40)), 11, 1.0, []),  # nobody knows yet
    (((ATTACK, 10), (HOME, 5), (RUN_AWAY, 9)), 11, 1.0, []),
    (((DISPERSE, 40),), 11, 1.0, []),  # nobody attacked it
]


@pytest.mark.parametrize(("spans", "gone", "away", "complete"), CYCLES)
def test_cycles(spans: tuple[tuple[int, int], ...], gone: int, away: float, complete: list[bool]) -> None:
    assert [cycle.complete for cycle in cycles(tracks(*spans, until=gone, away=away))] == complete


def test_attacking_nobody() -> None:
    seen = tracks((ATTACK, 20), (HOME, 5), until=12)
    assert captures(seen) == [(0, 12)]
    assert residual_s(seen) == 8.0
    assert false_homes(seen) == 0


def test_going_home_with_the_intruder_still_there() -> None:
    assert false_homes(tracks((ATTACK, 20), (HOME, 10), until=30)) == 1


def test_who_joins() -> None:
    sees = np.zeros((10, 1, 1), np.bool_)
    sees[5] = True
    assert count_joint_attacks(tracks((DISPERSE, 5), (ATTACK, 5), sees=sees)) == (1, 1)
    assert count_joint_attacks(tracks((DISPERSE, 6), (ATTACK, 4), sees=sees)) == (1, 0)


def test_an_encounter() -> None:
    sees = np.zeros((40, 1, 1), np.bool_)
    sees[5:16] = True
    heading = np.zeros((40, 1, 1), np.float32)
    heading[8:] = np.pi  # to the boss, who is at (-4, 0)
    facing, not_facing = (
        list(encounters(tracks((DISPERSE, 5), (RUN_AWAY, 20), (DISPERSE, 15), sees_boss=sees, heading=each)))
        for each in (heading, 0 * heading)
    )
    assert [(each.in_sight, each.turned, each.resumed_s) for each in facing] == [(1, 1, 10.0)]
    assert not not_facing[0].deferred


def test_an_obstacle_hides_the_boss() -> None:
    hidden = tracks((DISPERSE, 5), (RUN_AWAY, 20), (DISPERSE, 15), obstacles=np.array([[[-2.0, 0.0, 0.3]]]))
    assert [each.in_sight for each in encounters(hidden)] == [0]


@pytest.mark.parametrize("name", sorted({*practices(), *squad_practices()}))
def test_practices_can_be(name: str) -> None:
    for found in (practices(), squad_practices()):
        if name in found:
            World(found[name], [1])


def test_the_coordinator_knows_what_its_robots_know() -> None:
    library = make_team_libraries(scenario())[SQUAD]
    assert {"someone_sees", "all_done", "someone_done", "seen_lately"} <= set(library.kit.features)
    assert "forwards" in library.kit.behaviors


@pytest.mark.retrains
def test_a_teaching_goes_as_published_and_its_team_patrols() -> None:
    known = load_published("patrol")
    assert known is not None
    taught = teach(known.rows[0]["task"]["seed"])
    lessons = [lesson for teaching in taught.by_sort.values() for lesson in lessons_of(teaching)]
    assert lessons == known.rows[0]["lessons"]
    libraries = taught.libraries
    assert list(count_flat_states(libraries[ROBOT], libraries[SQUAD], DEFER)) == [
        known.rows[0][f"states_of_{who}"] for who in ("one", "all")
    ]
    seen = watch(make_coordinated_team(libraries, range(4), "collective_patrol"), 3000)
    found = list(cycles(seen))
    assert len(found) > 10
    assert sum(cycle.complete for cycle in found) >= 0.8 * len(found)
    sighted, joined = count_joint_attacks(seen)
    assert joined == sighted > 0


def test_how_large_a_patrol_would_be_in_one_piece() -> None:
    """Two states that each run one of two are four; four robots who act side by side are in any of four times four."""
    nothing = Library(make_scenario_kit(practices()["alone"]))
    robots = Library.from_automata(
        nothing.kit, make_automaton("wander", ["forwards", "left"], library=nothing)
    )
    squads = make_team_libraries(scenario(), {ROBOT: robots})[SQUAD]
    coordinators = Library.from_automata(
        squads.kit, make_automaton("both", ["wander", "stop"], library=squads)
    )
    assert states_of(robots, "wander") == 2
    assert count_flat_states(robots, coordinators, "both") == (2 + 1, 2**4 + 1)
