"""Measure labels and automata on the demonstrations published with PLUNDER, which are not part of the repository.

    python -m understudy_lab.recordings.measure_demonstrations FOLDER [--odd]

FOLDER has the folders stop-sign, merge and pick-place with one CSV file for each demonstration. Those with even numbers
serve to develop: labels are found in all of them together, and automata are learned from three quarters of them and
run over the readings of the rest, in turn, with the features given and with the pairs of readings that are taken where
they are worth it. With --odd, automata are learned from all even ones, and those with odd numbers are labelled and run
over. True actions serve only to score.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.candidates import CommandModel
from understudy.addons.recordings.drive_examples import name_state
from understudy.addons.recordings.drive_kit import list_drive_features
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.pair_report import take_pairs
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.addons.recordings.stateless_lesson import choose_stateless
from understudy.learning.fit import learn_automaton
from understudy.model.behaviors import Behavior
from understudy.model.features import BoundFeature, Feature, ReadingsView, feature
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.value_kinds import Column, Continuous
from understudy.records.join_records import join_records
from understudy.records.record import Record
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy.training.lesson_design import parse_feature
from understudy_lab.recordings.plunder import MODELS, Demonstration, read_demonstrations, with_unknown

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


COMPUTED = (speed_left, braking_left, lead_ahead, lane_offset, cube_beside, target_distance)
"""The features that are computed of readings."""

FEATURES: Mapping[str, Sequence[str]] = {
    "stop-sign": ("speed_left", "braking_left"),
    "merge": ("f_x - x", "l_x - x", "r_x - x"),
    "pick-place": ("cube_beside", "target_distance", "end_width"),
}
"""The features of each folder that automata decide on, such as a person would choose them."""

MORE_FEATURES: Mapping[str, Sequence[str]] = {
    "stop-sign": (*FEATURES["stop-sign"], "vel"),
    "merge": (*FEATURES["merge"], "lead_ahead", "lane_offset"),
    "pick-place": FEATURES["pick-place"],
}
"""The features of each folder that labels are found with."""


def make_demonstration_library(drive: Record, behaviors: Sequence[str]) -> Library:
    """Make a library of the readings of demonstrations, what is computed of them, and behaviors by name."""
    readings = (Feature(each.name, each.kind, each.name) for each in drive.readings)
    return Library(Kit.from_parts(*readings, *COMPUTED, *map(Behavior, behaviors)))


def learn_from_labels(segmentation: Segmentation, features: Sequence[str], *, pairs: bool = False) -> Library:
    """Learn an automaton from a labelled drive, and return a library that has it.

    The same setting for all folders: whether one tree serves all states is found by leaving demonstrations out, and so
    are pairs of these features and the readings, if asked for.
    """
    library = make_demonstration_library(segmentation.drive, [each.name for each in segmentation.candidates])

    def make(chosen: Sequence[str | BoundFeature]) -> DriveLesson:
        made = to_lesson(segmentation, name=NAME, library=library, features=chosen, reaction_s=0.0)
        return choose_stateless(segmentation, made)

    made = make(features)
    if pairs:
        sides = [parse_feature(library, each) for each in features]
        sides += list_drive_features(library, segmentation.drive)
        made, _ = take_pairs(segmentation, made, sides, make)
    lesson = made.lesson
    return made.library.with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))


def run_over_readings(library: Library, drive: Record, names: Sequence[str]) -> NDArray[np.int64]:
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


EVEN, ODD = 0, 1
QUARTERS = 4
LABELS, UNKNOWN = "labels", "labels, constants unknown"
AGREEMENT, WITH_PAIRS = "automaton", "automaton, with pairs"


class Shares(NamedTuple):
    """The share of ticks (%) of each demonstration of a folder that agrees with the true action."""

    folder: str
    what: str
    shares: list[float]

    def __str__(self) -> str:
        middle, least = float(np.median(self.shares)), min(self.shares)
        return f"{self.folder:10}  {self.what:25}  median {middle:5.1f} %  worst {least:5.1f} %"


def label_demonstrations(
    demonstrations: Sequence[Demonstration], models: Sequence[CommandModel], features: Sequence[str]
) -> Segmentation:
    """Label demonstrations together, with chances of switches that depend on features."""
    drives = [each.drive for each in demonstrations]
    library = make_demonstration_library(drives[0], ())
    return segment(drives, models, features=[parse_feature(library, each) for each in features])


def score_labels(segmentation: Segmentation, demonstrations: Sequence[Demonstration]) -> list[float]:
    """Return the share of ticks (%) of each demonstration whose label is the true action."""
    episodes = zip(demonstrations, segmentation.drive.episodes, strict=True)
    return [
        100 * float((segmentation.labels[episode.ticks] == each.truth).mean()) for each, episode in episodes
    ]


def score_automaton(
    learned: Sequence[Demonstration], unseen: Sequence[Demonstration], folder: str, *, pairs: bool
) -> list[float]:
    """Learn an automaton from the labels of some demonstrations; return how far it agrees with others, %."""
    models = MODELS[folder]
    labels = label_demonstrations(learned, models, MORE_FEATURES[folder])
    library = learn_from_labels(labels, FEATURES[folder], pairs=pairs)
    drive = join_records([each.drive for each in unseen])
    states = run_over_readings(library, drive, [each.name for each in models])
    episodes = zip(unseen, drive.episodes, strict=True)
    return [100 * float((states[episode.ticks] == each.truth).mean()) for each, episode in episodes]


def measure_folder(root: Path, folder: str, *, odd: bool) -> list[Shares]:
    """Measure the demonstrations of one folder."""
    even, features = read_demonstrations(root / folder, parity=EVEN), MORE_FEATURES[folder]
    demonstrations = read_demonstrations(root / folder, parity=ODD) if odd else even
    rows = []
    for what, models in (
        (LABELS, MODELS[folder]),
        (UNKNOWN, [with_unknown(each) for each in MODELS[folder]]),
    ):
        rows.append(
            Shares(
                folder,
                what,
                score_labels(label_demonstrations(demonstrations, models, features), demonstrations),
            )
        )
    parts = (
        [(even, demonstrations)]
        if odd
        else [
            ([each for index, each in enumerate(even) if index % QUARTERS != part], even[part::QUARTERS])
            for part in range(QUARTERS)
            if even[part::QUARTERS]
        ]
    )
    for what, pairs in ((AGREEMENT, False), (WITH_PAIRS, True)):
        shares = [
            share
            for learned, unseen in parts
            for share in score_automaton(learned, unseen, folder, pairs=pairs)
        ]
        rows.append(Shares(folder, what, shares))
    return rows


def main() -> None:
    """Print what was measured in each folder that is there."""
    parser = ArgumentParser(description="Measure labels and automata on the demonstrations of PLUNDER.")
    parser.add_argument("folder", type=Path, help="folder with stop-sign, merge and pick-place")
    parser.add_argument("--odd", action="store_true", help="measure on demonstrations with odd numbers")
    arguments = parser.parse_args()
    folders = [name for name in MODELS if (arguments.folder / name).is_dir()]
    if not folders:
        parser.error(
            f"{arguments.folder} has none of the folders {', '.join(MODELS)}; name one that has them"
        )
    for name in folders:
        for row in measure_folder(arguments.folder, name, odd=arguments.odd):
            sys.stdout.write(f"{row}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
