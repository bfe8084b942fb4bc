"""Automata learned from the inferred labels of demonstrations, and run over the readings of others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.drive_examples import name_state
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.addons.recordings.recorded_drive import RecordedDrive
from understudy.addons.recordings.segment import Segmentation
from understudy.addons.recordings.stateless_lesson import choose_stateless
from understudy.learning.fit import learn_automaton
from understudy.model.behaviors import Behavior
from understudy.model.features import Feature, ReadingsView, feature
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.value_kinds import Column, Continuous
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link

NAME = "driven"


@feature(Continuous())
def speed_left(robot: ReadingsView) -> Column:
    """Speed left to the limit."""
    return robot.vMax - robot.vel


@feature(Continuous())
def braking_left(robot: ReadingsView) -> Column:
    """Distance left to the place where full braking would have to begin."""
    return robot.target - robot.pos - robot.vel**2 / (-2 * robot.decMax)


@feature(Continuous())
def gap_ahead(robot: ReadingsView) -> Column:
    """Distance to the car ahead."""
    return robot.f_x - robot.x


@feature(Continuous())
def gap_left(robot: ReadingsView) -> Column:
    """Distance to the car at the left."""
    return robot.l_x - robot.x


@feature(Continuous())
def gap_right(robot: ReadingsView) -> Column:
    """Distance to the car at the right."""
    return robot.r_x - robot.x


@feature(Continuous())
def lead_ahead(robot: ReadingsView) -> Column:
    """How much faster the car ahead is."""
    return robot.f_vx - robot.vx


@feature(Continuous())
def lane_offset(robot: ReadingsView) -> Column:
    """Distance from the middle of the lane."""
    return robot.y - 4 * np.round(robot.y / 4)


@feature(Continuous())
def cube_beside(robot: ReadingsView) -> Column:
    """Horizontal distance to the cube."""
    return np.hypot(robot.bx - robot.x, robot.by - robot.y)


@feature(Continuous())
def target_distance(robot: ReadingsView) -> Column:
    """Distance to the target."""
    return np.sqrt((robot.tx - robot.x) ** 2 + (robot.ty - robot.y) ** 2 + (robot.tz - robot.z) ** 2)


FEATURES: Mapping[str, Sequence[Feature]] = {
    "stop-sign": (speed_left, braking_left),
    "merge": (gap_ahead, gap_left, gap_right),
    "pick-place": (cube_beside, target_distance, Feature("end_width", Continuous(), "end_width")),
}
"""The features of each folder that automata decide on, such as a person would choose them."""

MORE_FEATURES: Mapping[str, Sequence[Feature]] = {
    "stop-sign": (*FEATURES["stop-sign"], Feature("vel", Continuous(), "vel")),
    "merge": (*FEATURES["merge"], lead_ahead, lane_offset),
    "pick-place": FEATURES["pick-place"],
}
"""The features of each folder that labels are found with."""


def learn_from_labels(segmentation: Segmentation, features: Sequence[Feature]) -> Library:
    """Learn an automaton from a labelled drive, and return a library that has it.

    The same setting for all folders: whether one tree serves all states is found by leaving demonstrations out.
    """
    names = [each.name for each in segmentation.candidates]
    library = Library(Kit.from_parts(*features, *map(Behavior, names)))
    drive_lesson = to_lesson(
        segmentation, name=NAME, library=library, features=[each.name for each in features], reaction_s=0.0
    )
    lesson = choose_stateless(segmentation, drive_lesson).lesson
    return drive_lesson.library.with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))


def run_over_readings(library: Library, drive: RecordedDrive, names: Sequence[str]) -> NDArray[np.int64]:
    """Run the automaton over recorded readings; return the index of the state's name at each tick, -1 for others."""
    program = link(library, NAME)
    columns = [read_feature_column(each, drive.percept, agents=drive.ticks) for each in program.features]
    rows = np.array(columns).T.tolist()
    states = {name_state(name): index for index, name in enumerate(names)}
    indices = np.empty(drive.ticks, np.int64)
    interpreter = Interpreter(program)
    for episode in drive.episodes:
        interpreter.start(float(drive.times[episode.first]))
        for tick in range(episode.first, episode.end):
            interpreter.pulse(rows[tick], float(drive.times[tick]))
            indices[tick] = states.get(interpreter.path[0], -1)
    return indices
