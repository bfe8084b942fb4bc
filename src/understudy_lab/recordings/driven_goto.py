"""GoTo from drives with a stick: the driver turns to a post, drives to it and lets the stick go, and never presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, tau

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from understudy.learning.fit import learn_automaton
from understudy.model.lesson import TreeOptions
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.segmentation.drive_kit import list_drive_features, make_candidates
from understudy.segmentation.lesson_from_drive import to_lesson
from understudy.segmentation.recorded_drive import DriveEpisode, RecordedDrive
from understudy.segmentation.segment import segment
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy_lab.behavior_suite.task import rover
from understudy_lab.behavior_suite.waypoints import GOTO
from understudy_lab.behavior_suite.waypoints import SCENARIO as POSTS
from understudy_lab.recordings.stick_driver import Stick, StickSettings, draw_stick_settings
from understudy_lab.tasks.forage_teacher import WATCHED
from understudy_lab.teachers.teacher import ScriptedTeacher

POST = "post_1"
MOVES = ("wait", "forward", "rotate_left", "rotate_right")
WAIT, FORWARD, LEFT, RIGHT = range(4)
SCENARIO = structs.replace(POSTS, name="posts", types={"rover": rover(*MOVES)})
KIT: Kit = make_scenario_kit(SCENARIO)
AIMS = np.array(
    [[KIT.behaviors[name].command.get(each, 0.0) for each in ("drive", "turn")] for name in MOVES]
)
DRIVES, DRIVE_S, LIMIT_S = 24, 30.0, 60.0
REST_S = 2.0
THERE_M, ASTRAY, FACING, REACHED_M = 0.4, 0.5, 0.12, 0.5
WORLDS = 100
LEARNER = TreeOptions(pruning=3.0)


@dataclass(frozen=True, slots=True)
class DrivenLesson:
    """How well a drive was understood, as shares from 0 to 1, and the library that it teaches.

    `ticks` compares labels with what the driver means, `answered` with what the hand answers to, which is later by the
    dead time. `switches` counts those within 0.3 s of where the driver decides.
    """

    ticks: float
    answered: float
    switches: float
    library: Library


def intend(intent: NDArray[np.int64], distance: NDArray[np.float64], off: NDArray[np.float64]) -> None:
    """Change what drivers mean to do, in place, from distance and bearing (rad, positive to the left) of the post."""
    for world, (far, angle) in enumerate(zip(distance.tolist(), off.tolist(), strict=True)):
        if far < THERE_M:
            intent[world] = WAIT
        elif intent[world] in (WAIT, FORWARD) and abs(angle) > ASTRAY:
            intent[world] = LEFT if angle > 0 else RIGHT
        elif intent[world] != FORWARD:
            ahead = {LEFT: angle, RIGHT: -angle}.get(int(intent[world]), 0.0)
            intent[world] = FORWARD if ahead < FACING else intent[world]


def drive(hand: StickSettings, seeds: Sequence[int]) -> tuple[RecordedDrive, NDArray[np.int64]]:
    """Drive to the post in each world; return the recording and what the driver meant in each tick."""
    world, keys = World(SCENARIO, seeds), (("range", POST), ("bearing", POST))
    random = np.random.default_rng([seeds[0], 17])
    stick, intent = Stick(hand, world.agents, 2, random), np.full(world.agents, WAIT)
    rows, meant, commands, rested = [], [], [], np.zeros(world.agents)
    ticks = round(DRIVE_S / world.tick_s)
    ends = np.full(world.agents, ticks)
    for tick in range(ticks):
        percept = world.sense(keys)
        rows.append([percept[key] for key in keys])
        intend(intent, percept[keys[0]], (percept[keys[1]] + pi) % tau - pi)
        place = stick.move(AIMS[intent])
        meant.append(intent.copy())
        commands.append(place)
        rested = np.where(intent == WAIT, rested + world.tick_s, 0.0)
        ends = np.where((rested > REST_S) & (ends == ticks), tick + 1, ends)
        world.act({"drive": place[:, 0].copy(), "turn": place[:, 1].copy()})
    table, stops = np.array(rows), ends.tolist()
    firsts = np.cumsum([0, *stops]).tolist()

    def join(columns: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([columns[:end, world] for world, end in enumerate(stops)])

    recording = RecordedDrive(
        np.concatenate([np.arange(end) * world.tick_s for end in stops]),
        {key: join(table[:, index]) for index, key in enumerate(keys)},
        join(np.array(commands)),
        tuple(world.channels),
        tuple(each for each in world.readings if each.name in ("range", "bearing")),
        (POST,),
        world.tick_s,
        tuple(
            DriveEpisode(f"world {seed}", a, a + n) for seed, a, n in zip(seeds, firsts, stops, strict=False)
        ),
    )
    return recording, join(np.array(meant)).astype(np.int64)


def learn_from_drives(seed: int) -> DrivenLesson:
    """Drive with the hand of a seed, segment the drives, and learn GoTo from them."""
    hand = draw_stick_settings(seed)
    recording, meant = drive(hand, range(1000 * seed, 1000 * seed + DRIVES))
    library = Library(KIT)
    features = list_drive_features(library, recording)
    found = segment(recording, make_candidates(library, recording, MOVES), features=features)
    made = to_lesson(found, name="goto", library=library, features=features, learner=LEARNER)
    learned = made.library.with_automaton(TrainedAutomaton(learn_automaton(made.lesson), made.lesson))
    late = np.arange(recording.ticks)
    for episode in recording.episodes:
        late[episode.ticks] = np.maximum(late[episode.ticks] - hand.dead_ticks, episode.first)
    right, answered = ((found.labels == each).mean() for each in (meant, meant[late]))
    return DrivenLesson(
        float(right), float(answered), share_switches(found.labels, meant, recording), learned
    )


NEAR_S = 0.3


def share_switches(labels: NDArray[np.int64], meant: NDArray[np.int64], recording: RecordedDrive) -> float:
    """Return the share of true switches with one to the same label within 0.3 s."""
    hits = []
    for episode in recording.episodes:
        truth, ours = meant[episode.ticks], labels[episode.ticks]
        found = np.flatnonzero(np.diff(ours)) + 1
        for tick in (np.flatnonzero(np.diff(truth)) + 1).tolist():
            near = found[np.abs(found - tick) * recording.tick_s <= NEAR_S + 1e-9]
            hits.append(bool((ours[near] == truth[tick]).any()))
    return float(np.mean(hits))


def teach_by_presses(seed: int) -> Library:
    """Teach GoTo(A) by presses, as in the other experiments."""
    teacher = ScriptedTeacher(
        Library(KIT), lambda practice, world: World(SCENARIO, [world]), seed, options=WATCHED
    )
    return teacher.teach(GOTO).library


def measure_success(library: Library, seed: int, *, parameter: str | None = None) -> float:
    """Return the share of unseen worlds in which the robot stands within 0.5 m of the post in the end."""
    world = World(SCENARIO, range(WORLDS * seed, WORLDS * (seed + 1)))
    binding = {} if parameter is None else {parameter: POST}
    engine = Engine.from_program(world, link(library, "goto", binding))
    for _ in range(round(LIMIT_S / world.tick_s)):
        engine.tick()
    before = world.sense([("range", POST), ("bearing", POST)])
    for _ in range(round(REST_S / world.tick_s)):
        engine.tick()
    after = world.sense([("range", POST), ("bearing", POST)])
    still = np.abs(after["range", POST] - before["range", POST]) < 0.05
    return float((still & (after["range", POST] <= REACHED_M)).mean())
