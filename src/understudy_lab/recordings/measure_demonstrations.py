"""Measure labels and automata on the demonstrations published with PLUNDER, which are not part of the repository.

    python -m understudy_lab.recordings.measure_demonstrations FOLDER [--odd]

FOLDER has the folders stop-sign, merge and pick-place with one CSV file for each demonstration. Those with even numbers
serve to develop: labels are found in all of them together, and automata are learned from three quarters of them and
run over the readings of the rest, in turn. With --odd, automata are learned from all even ones, and those with odd
numbers are labelled and run over. True actions serve only to score.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from understudy.addons.recordings.candidates import CommandModel
from understudy.addons.recordings.recorded_drive import join_drives
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.model.binding import NOTHING_BOUND
from understudy.model.features import BoundFeature, Feature
from understudy_lab.recordings.automata import FEATURES, MORE_FEATURES, learn_from_labels, run_over_readings
from understudy_lab.recordings.plunder import MODELS, Demonstration, read_demonstrations, with_unknown

EVEN, ODD = 0, 1
QUARTERS = 4
LABELS, UNKNOWN, AGREEMENT = "labels", "labels, constants unknown", "automaton"


class Shares(NamedTuple):
    """The share of ticks (%) of each demonstration of a folder that agrees with the true action."""

    folder: str
    what: str
    shares: list[float]

    def __str__(self) -> str:
        middle, least = float(np.median(self.shares)), min(self.shares)
        return f"{self.folder:10}  {self.what:25}  median {middle:5.1f} %  worst {least:5.1f} %"


def label_demonstrations(
    demonstrations: Sequence[Demonstration], models: Sequence[CommandModel], features: Sequence[Feature]
) -> Segmentation:
    """Label demonstrations together, with chances of switches that depend on features."""
    bound = [BoundFeature(each, NOTHING_BOUND) for each in features]
    return segment([each.drive for each in demonstrations], models, features=bound)


def score_labels(segmentation: Segmentation, demonstrations: Sequence[Demonstration]) -> list[float]:
    """Return the share of ticks (%) of each demonstration whose label is the true action."""
    episodes = zip(demonstrations, segmentation.drive.episodes, strict=True)
    return [
        100 * float((segmentation.labels[episode.ticks] == each.truth).mean()) for each, episode in episodes
    ]


def score_automaton(
    learned: Sequence[Demonstration], unseen: Sequence[Demonstration], folder: str
) -> list[float]:
    """Learn an automaton from the labels of some demonstrations; return how far it agrees with others, %."""
    models = MODELS[folder]
    library = learn_from_labels(
        label_demonstrations(learned, models, MORE_FEATURES[folder]), FEATURES[folder]
    )
    drive = join_drives([each.drive for each in unseen])
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
    if odd:
        agreement = score_automaton(even, demonstrations, folder)
    else:
        agreement = [
            share
            for part in range(QUARTERS)
            if even[part::QUARTERS]
            for share in score_automaton(
                [each for index, each in enumerate(even) if index % QUARTERS != part],
                even[part::QUARTERS],
                folder,
            )
        ]
    return [*rows, Shares(folder, AGREEMENT, agreement)]


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
