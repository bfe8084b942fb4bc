"""Three robots that line up in an equilateral triangle: one automaton for all, each with its own A and B."""

from __future__ import annotations

from math import pi

import numpy as np
from msgspec.structs import replace

from understudy.experiments.repertoire.feat import Feat, Judged, Trial
from understudy.experiments.repertoire.rovers import SPEED, Turning, bearing, rover
from understudy.experiments.repertoire.tracks import Column, Table, Tracks, held, signed
from understudy.model.feature import Percept
from understudy.model.lesson import Options
from understudy.runtime.body import Commands
from understudy.training.demonstrators.person import Seen, Wish
from understudy.training.demonstrators.teacher import Case, Push, Topic
from understudy.training.design import new_lesson
from understudy.training.screen import Screen
from understudy.worlds.kits import kit_of
from understudy.worlds.scenario import Region, Robots, Scenario, TargetOf
from understudy.worlds.world import World

SIDE_M, WITHIN_M, WITHIN_DEG = 2.0, 0.4, 12.0
HELD_S, LIMIT_S = 5.0, 90.0
ROBOTS = ("ant", "bee", "cat")
BINDINGS = tuple({"A": ROBOTS[k - 2], "B": ROBOTS[k - 1]} for k in range(3))
"""Each robot's A and B are the two after it."""

SCENARIO = Scenario(
    name="triangle",
    about="Three rovers that know where the others are.",
    size=(14.0, 14.0),
    limit_s=LIMIT_S,
    regions={"middle": Region(box=(4.0, 4.0, 10.0, 10.0))},
    types={name: rover("forward", "backward", "rotate_left", "rotate_right", "wait", team=name) for name in ROBOTS},
    robots=tuple(Robots(type=name, within="middle", apart=0.6) for name in ROBOTS),
    targets={name: TargetOf(team=name, doc="A robot.") for name in ROBOTS},
)

GOES_M, THERE_M = 0.22, 0.06
FACING, ASTRAY = 0.12, 0.4


def facing(state: str, off: float, goes: str, slack: float) -> str | None:
    """What a person wants of a robot that is to face something and then to go, who lets this much (rad) pass."""
    toward = "rotate_left" if off > 0 else "rotate_right"
    if state in ("start", goes):
        return toward if abs(off) > ASTRAY + slack else goes
    ahead = off if state == "rotate_left" else -off
    return goes if ahead < FACING - slack else None


def going(name: str, goes: str) -> Topic:
    """Facing A and going to it, or back from it."""
    return Topic(
        name,
        lambda library: new_lesson(
            library,
            name,
            parameters=["A"],
            states=[goes, "rotate_left", "rotate_right"],
            features=["angle_to(A)"],
        ),
        lambda screen: facing(screen.state, bearing(screen), goes, 0.0),
        lambda screen: facing(screen.state, bearing(screen), goes, 0.3),
        lambda screen: screen.time_s > 4.0 and screen.state == goes,
        cases=(
            Case("two wait", {"A": "bee"}, _aside(1), lambda screen: screen.state == goes),
            Case("two wait", {"A": "cat"}, _aside(-1), lambda screen: screen.state == goes),
            Case("two wait", {"A": "cat"}, _aside(1), _went(goes), push=Push(goes, "rotate_left", 0.7)),
            Case("two wait", {"A": "bee"}, _aside(-1), _went(goes), push=Push(goes, "rotate_right", 0.7)),
        ),
        tries=4,
        limit_s=20.0,
    )


def _went(goes: str) -> Seen:
    return lambda screen: screen.state == goes and abs(bearing(screen)) < ASTRAY


def _aside(side: int) -> Seen:
    return lambda screen: 0.8 < side * bearing(screen) < 2.6


def wanted(state: str, far: dict[str, float], slack: float) -> str | None:
    """Nearer to A or off from it until that is right, then the same with B, then wait."""
    going, _, of = state.partition("_")
    if of and abs(off := far[of] - SIDE_M) < 1.0 and off * (1 if going == "toward" else -1) < THERE_M - slack:
        return "wait"
    if of and state != "start":
        return None
    for of, distance in far.items():
        if abs(distance - SIDE_M) > GOES_M + slack:
            return f"{'toward' if distance > SIDE_M else 'away'}_{of}"
    return "wait" if state == "start" else None


def _pressing(slack: float) -> Wish:
    return lambda screen: wanted(
        screen.state, {of: screen.features[f"distance_to({of})"] for of in "AB"}, slack
    )


def _in_place(screen: Screen) -> bool:
    return screen.state == "wait" and wanted("wait", {of: screen.features[f"distance_to({of})"] for of in "AB"}, 0) is None


def _begins(nearer: str, least: float, most: float) -> Seen:
    return lambda screen: least < screen.features[f"distance_to({nearer})"] < most


LINE_UP = Topic(
    "line_up",
    lambda library: new_lesson(
        library,
        "line_up",
        parameters=["A", "B"],
        states=["toward_A=toward(A)", "away_A=away(A)", "toward_B=toward(B)", "away_B=away(B)", "wait"],
        features=["distance_to(A)", "distance_to(B)"],
    ),
    _pressing(0.0),
    _pressing(0.12),
    _in_place,
    cases=(
        Case("two wait", {"A": "bee", "B": "cat"}, _begins("A", 2.6, 5.0)),
        Case("two wait", {"A": "bee", "B": "cat"}, _begins("A", 0.4, 1.5)),
        Case("two wait", {"A": "bee", "B": "cat"}, _begins("B", 0.4, 1.5)),
    ),
    tries=5,
    limit_s=90.0,
)


def practice(name: str, seed: int) -> World:
    """Two robots wait two meters apart; the third is anywhere."""
    waiting = (Robots(type="bee", at=((6.0, 7.0, 0.0),)), Robots(type="cat", at=((8.0, 7.0, 0.0),)))
    return World(replace(SCENARIO, robots=(SCENARIO.robots[0], *waiting)), [seed])


class Hand:
    """The same by hand, reacting at once."""

    keys = tuple((what, name) for name in ROBOTS for what in ("range", "bearing"))

    def __init__(self, world: World) -> None:
        self._turning = Turning(world.agents)
        self._going = np.zeros(world.agents)
        self._to_b = np.zeros(world.agents, np.bool_)
        self._a, self._b = ([ROBOTS.index(BINDINGS[k % 3][of]) for k in range(world.agents)] for of in "AB")

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        rows = np.arange(len(self._going))
        far = np.stack([percept["range", name] for name in ROBOTS])
        off = signed(np.stack([percept["bearing", name] for name in ROBOTS]))
        error_a, error_b = far[self._a, rows] - SIDE_M, far[self._b, rows] - SIDE_M
        error = np.where(self._to_b, error_b, error_a)
        self._going = np.where(self._going * error < THERE_M, 0.0, self._going)
        rests = self._going == 0
        self._to_b = np.where(rests, np.abs(error_a) <= GOES_M, self._to_b)
        error = np.where(self._to_b, error_b, error_a)
        self._going = np.where(rests & (np.abs(error) > GOES_M), np.sign(error), self._going)
        faced = np.where(self._to_b, off[self._b, rows], off[self._a, rows])
        turn = self._turning.toward(faced, self._going != 0)
        return {"drive": np.where(turn == 0, self._going, 0.0), "turn": turn}


def sides(tracks: Tracks) -> Table:
    """The sides of each triangle [3, T+1, B], m: the first is across from the first robot."""
    x, y = (each.reshape(len(each), -1, 3) for each in (tracks.x, tracks.y))
    return np.stack([np.hypot(x[..., k - 2] - x[..., k - 1], y[..., k - 2] - y[..., k - 1]) for k in range(3)])


def angles(lengths: Table) -> Table:
    """The angles of triangles from their sides [3, ...], rad, by the law of cosines."""
    a, b, c = (np.roll(lengths, -k, axis=0) for k in range(3))
    return np.arccos(np.clip((b**2 + c**2 - a**2) / np.maximum(2 * b * c, 1e-9), -1.0, 1.0))


def judge(tracks: Tracks) -> Judged:
    """When sides and angles had been right for five seconds; and how far off the worst angle was at the end."""
    lengths = sides(tracks)
    off = np.degrees(np.abs(angles(lengths) - pi / 3)).max(axis=0)
    right = (np.abs(lengths - SIDE_M).max(axis=0) <= WITHIN_M) & (off <= WITHIN_DEG)
    return Judged(tracks.first(held(right, tracks.ticks(HELD_S))), {"worst angle off, degrees": off[-1]})


def bound(tracks: Tracks) -> Column:
    """When the side that is farthest off could be right, its ends going straight, and the time it is to hold [W], s."""
    off = np.abs(sides(tracks)[:, 0] - SIDE_M).max(axis=0) - WITHIN_M
    return np.maximum(0.0, off) / (2 * SPEED) + HELD_S


FEAT = Feat(
    name="triangle",
    does="three robots line up in an equilateral triangle",
    measured="sides within 0.4 m of 2 m and angles within 12 degrees of 60, for 5 s, in 90 s",
    bounded="the side farthest off, its ends going straight, and 5 s",
    kit=kit_of(SCENARIO),
    topics=(going("toward", "forward"), going("away", "backward"), LINE_UP),
    options={
        "toward": Options(watched=True, reaction_s=0.2),
        "away": Options(watched=True, reaction_s=0.2),
        "line_up": Options(watched=True, reaction_s=0.2),
    },
    practice=practice,
    trial=lambda seeds: Trial(World(SCENARIO, seeds), LIMIT_S, judge, bound, BINDINGS),
    hand=Hand,
)
