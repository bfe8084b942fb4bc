"""Lessons from simulated drives, and how well their labels fit what the driver meant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.drive_kit import list_drive_features, make_candidates
from understudy.addons.recordings.lesson_from_drive import to_lesson
from understudy.addons.recordings.recorded_drive import RecordedDrive
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.learning.fit import learn_automaton
from understudy.model.learner_options import TreeOptions
from understudy.model.library import Library, TrainedAutomaton
from understudy.training.lesson_design import parse_feature
from understudy_lab.recordings.drive_recording import MeantDrive, StickSettings

Flags = NDArray[np.bool_]

LEARNER = TreeOptions(pruning=3.0)
NEAR_S = 0.3


@dataclass(frozen=True, slots=True)
class LabelHits:
    """The labels of a drive that are right.

    `ticks` [T] are those labelled as the driver meant, `answered` [T] as the hand answered, which is later by the dead
    time, and `switches` [S] those found within 0.3 s of where the driver decides.
    """

    ticks: Flags
    answered: Flags
    switches: Flags

    def __add__(self, other: LabelHits) -> LabelHits:
        """Return the hits of two drives."""
        pairs = [
            (self.ticks, other.ticks),
            (self.answered, other.answered),
            (self.switches, other.switches),
        ]
        return LabelHits(*map(np.concatenate, pairs))

    def score(self) -> dict[str, float]:
        """Return the share of each, from 0 to 1."""
        hits = {"ticks": self.ticks, "answered": self.answered, "switches": self.switches}
        return {name: float(each.mean()) for name, each in hits.items()}


@dataclass(frozen=True, slots=True)
class DrivenLesson:
    """The labels of a drive, and the library that it teaches."""

    hits: LabelHits
    library: Library


def learn_from_drive(
    drive: MeantDrive,
    hand: StickSettings,
    library: Library,
    name: str,
    behaviors: Sequence[str],
    *,
    features: Sequence[str] | None = None,
    targets: Mapping[str, str] = MappingProxyType({}),
    learner: TreeOptions = LEARNER,
) -> DrivenLesson:
    """Segment a drive with behaviors as candidates, and learn an automaton from the labels.

    Parameters
    ----------
    drive
        The recording, and what the driver meant, as an index of the behaviors.
    hand
        The driver's hand, whose dead time the scores allow for.
    library
        The behaviors, to which the automaton is added.
    name
        Name of the automaton.
    behaviors
        The candidates, such as "forward".
    features
        Names of the features that decisions depend on. None: all readings of the recording that the kit has.
    targets
        Targets that parameters of the automaton stand for.
    learner
        How trees are learned.

    Returns
    -------
    DrivenLesson
        The labels, and the automaton.
    """
    recording = drive.recording
    used = (
        list_drive_features(library, recording)
        if features is None
        else [parse_feature(library, each) for each in features]
    )
    segmentation = segment(recording, make_candidates(library, recording, behaviors), features=used)
    drive_lesson = to_lesson(
        segmentation, name=name, library=library, features=used, targets=targets, learner=learner
    )
    learned = drive_lesson.library.with_automaton(
        TrainedAutomaton(learn_automaton(drive_lesson.lesson), drive_lesson.lesson)
    )
    return DrivenLesson(judge_labels(segmentation, drive.meant, hand), learned)


def judge_labels(segmentation: Segmentation, meant: NDArray[np.int64], hand: StickSettings) -> LabelHits:
    """Compare the labels of a drive with what its driver meant."""
    recording = segmentation.drive
    late = np.arange(recording.ticks)
    for episode in recording.episodes:
        late[episode.ticks] = np.maximum(late[episode.ticks] - hand.dead_ticks, episode.first)
    return LabelHits(
        segmentation.labels == meant,
        segmentation.labels == meant[late],
        find_switches(segmentation.labels, meant, recording),
    )


def find_switches(labels: NDArray[np.int64], meant: NDArray[np.int64], recording: RecordedDrive) -> Flags:
    """Return for each true switch whether there is one to the same label within 0.3 s."""
    hits = []
    for episode in recording.episodes:
        truth, ours = meant[episode.ticks], labels[episode.ticks]
        switches = np.flatnonzero(np.diff(ours)) + 1
        for tick in (np.flatnonzero(np.diff(truth)) + 1).tolist():
            near = switches[np.abs(switches - tick) * recording.tick_s <= NEAR_S + 1e-9]
            hits.append(bool((ours[near] == truth[tick]).any()))
    return np.array(hits, np.bool_)
