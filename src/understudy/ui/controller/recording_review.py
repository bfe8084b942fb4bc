"""A segmented drive under review: labels set by hand, undone, learned from, compared with, and saved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SessionError
from understudy.learning.fit import learn_automaton
from understudy.model.features import BoundFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.segmentation.lesson_from_drive import DriveLesson, to_lesson
from understudy.segmentation.relabel import relabel
from understudy.segmentation.rerun_drive import measure_agreement, run_over_drive
from understudy.segmentation.segment import Segmentation
from understudy.storage.library_folder import open_each_automaton, save_automaton

MOST_UNDONE = 200
"""The number of changes that can be undone."""


@dataclass(frozen=True, slots=True)
class LearnedDrive:
    """The automaton that was learned from the labels as they were then.

    `states` has the index of the label whose state the automaton is in at each tick of the drive, and `agreement` the
    share of ticks at which that is the drive's label.
    """

    made: DriveLesson
    taught: TrainedAutomaton
    states: NDArray[np.int64]
    agreement: float


class RecordingReview:
    """The review of a segmented drive.

    Parameters
    ----------
    segmentation
        The labels as they were found.
    library
        The features and behaviors that the automaton uses.
    features
        Features that decisions depend on. None: all readings.
    folder
        The library's folder that the automaton is saved in.
    name
        Name of the automaton.
    """

    def __init__(
        self,
        segmentation: Segmentation,
        library: Library,
        *,
        features: Sequence[BoundFeature] | None,
        folder: Path,
        name: str,
    ) -> None:
        self.segmentation, self.name = segmentation, name
        self.by_hand: NDArray[np.bool_] = np.zeros(segmentation.drive.ticks, np.bool_)
        """The ticks [T] whose labels were set by hand."""
        self.learned: LearnedDrive | None = None
        """The automaton learned from the present labels; None until then."""
        self.saved: Path | None = None
        """The file of the learned automaton; None until it is saved."""
        self._library, self._features, self._folder = library, features, folder
        self._before: list[tuple[Segmentation, NDArray[np.bool_]]] = []

    @property
    def can_undo(self) -> bool:
        """True if a label was set that can be undone."""
        return bool(self._before)

    def set_label(self, first: int, end: int, label: str) -> None:
        """Set the label of a span by hand; see `relabel` for the errors."""
        changed = relabel(self.segmentation, first, end, label)
        self._before.append((self.segmentation, self.by_hand))
        del self._before[:-MOST_UNDONE]
        by_hand = self.by_hand.copy()
        by_hand[first:end] = True
        self._change(changed, by_hand)

    def extend(self, segmentation: Segmentation) -> None:
        """Take over the labels of a drive that went on.

        What was set by hand stays, and can no longer be undone.
        """
        before, by_hand = self.segmentation, self.by_hand
        grown = np.zeros(segmentation.drive.ticks, np.bool_)
        grown[: len(by_hand)] = by_hand
        marks = np.where(by_hand, before.labels, -1)
        for episode in before.drive.episodes:
            cuts = episode.first + 1 + np.flatnonzero(np.diff(marks[episode.ticks]))
            for first, end in pairwise([episode.first, *cuts.tolist(), episode.end]):
                if by_hand[first]:
                    segmentation = relabel(segmentation, first, end, before.names[marks[first]])
        self._before.clear()
        self._change(segmentation, grown)

    def undo(self) -> None:
        """Take the last change of a label back; SessionError if there is none."""
        if not self._before:
            raise SessionError("no label was changed: there is nothing to undo")
        self._change(*self._before.pop())

    def _change(self, segmentation: Segmentation, by_hand: NDArray[np.bool_]) -> None:
        self.segmentation, self.by_hand = segmentation, by_hand
        self.learned = self.saved = None

    def learn(self) -> LearnedDrive:
        """Learn an automaton from the present labels, and run it over the readings.

        DefinitionError is raised if nothing explains any tick, and other errors of `to_lesson`.
        """
        made = to_lesson(self.segmentation, name=self.name, library=self._library, features=self._features)
        taught = TrainedAutomaton(learn_automaton(made.lesson), made.lesson)
        names = tuple(each.name for each in self.segmentation.candidates)
        states = run_over_drive(
            made.library.with_automaton(taught), taught.automaton.name, self.segmentation.drive, names
        )
        self.learned = LearnedDrive(made, taught, states, measure_agreement(self.segmentation, states))
        self.saved = None
        return self.learned

    def save(self, name: str) -> Path:
        """Save what was learned in the library's folder under a name, and return the file.

        SessionError is raised if nothing was learned from the present labels, and the errors of `save_automaton`.
        """
        if self.learned is None:
            raise SessionError("nothing was learned from these labels: learn first")
        if name != self.name:
            self.name = name
            self.learn()
        if self._folder.is_dir():  # an automaton must not contain itself through others of the folder
            open_each_automaton(self._folder, None, lambda _: {}).library.with_automaton(self.learned.taught)
        self.saved = save_automaton(self._folder, self.learned.taught)
        return self.saved
