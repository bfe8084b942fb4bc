"""A segmented drive under review: labels set by hand, undone, learned from, compared with, and saved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SessionError, UnknownName
from understudy.learning.fit import learn_automaton
from understudy.model.features import BoundFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.segmentation.candidates import Candidate, SplitState
from understudy.segmentation.lesson_from_drive import DriveLesson, to_lesson
from understudy.segmentation.propose_behaviors import (
    BehaviorProposal,
    make_constant_candidate,
    propose_behaviors,
)
from understudy.segmentation.relabel import relabel
from understudy.segmentation.rerun_drive import measure_agreement, run_over_drive
from understudy.segmentation.segment import Segmentation, segment
from understudy.segmentation.split_states import SplitProposal, propose_splits, split_state
from understudy.storage.library_folder import open_each_automaton, save_automaton

MOST_UNDONE = 200
"""The number of changes that can be undone."""


@dataclass(frozen=True, slots=True)
class LearnedDrive:
    """The automaton that was learned from the labels as they were then.

    `states` has the index of the label whose state the automaton is in at each tick of the drive, and `agreement` the
    share of ticks at which that is the drive's label. `splits` are states that are better split in two.
    """

    made: DriveLesson
    taught: TrainedAutomaton
    states: NDArray[np.int64]
    agreement: float
    splits: tuple[SplitProposal, ...]


class _Labels(NamedTuple):
    """The labels of a drive, the ticks [T] at which they were set by hand, behaviors added, and states split."""

    segmentation: Segmentation
    by_hand: NDArray[np.bool_]
    defined: tuple[Candidate, ...] = ()
    splits: tuple[tuple[str, tuple[str, ...]], ...] = ()


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
        self.name = name
        self.learned: LearnedDrive | None = None
        """The automaton learned from the present labels; None until then."""
        self.saved: Path | None = None
        """The file of the learned automaton; None until it is saved."""
        self.is_growing = False
        """True while somebody drives; then no behaviors are proposed, which takes time in long drives."""
        self._library, self._features, self._folder = library, features, folder
        self._labels = _Labels(segmentation, np.zeros(segmentation.drive.ticks, np.bool_))
        self._before: list[_Labels] = []
        self._proposed: tuple[Segmentation, tuple[BehaviorProposal, ...]] | None = None

    @property
    def segmentation(self) -> Segmentation:
        """The present labels."""
        return self._labels.segmentation

    @property
    def by_hand(self) -> NDArray[np.bool_]:
        """The ticks [T] whose labels were set by hand."""
        return self._labels.by_hand

    @property
    def new_candidates(self) -> tuple[Candidate, ...]:
        """The behaviors that were added to the candidates, because nothing explained some commands."""
        return self._labels.defined

    @property
    def can_undo(self) -> bool:
        """True if a label was changed, a behavior added or a state split, which can be undone."""
        return bool(self._before)

    def set_label(self, first: int, end: int, label: str) -> None:
        """Set the label of a span by hand; see `relabel` for the errors."""
        by_hand = self.by_hand.copy()
        by_hand[first:end] = True
        changed = relabel(self.segmentation, first, end, label)
        self._change(self._labels._replace(segmentation=changed, by_hand=by_hand))

    def list_proposals(self) -> tuple[BehaviorProposal, ...]:
        """List the proposed behaviors for commands that nothing explains; they are found once for the same labels."""
        if self.is_growing:
            return ()
        if self._proposed is None or self._proposed[0] is not self.segmentation:
            self._proposed = self.segmentation, propose_behaviors(self.segmentation)
        return self._proposed[1]

    def define_behavior(self, name: str, command: Mapping[str, float]) -> None:
        """Add a behavior with a constant command, and find the labels again; those set by hand stay.

        DefinitionError is raised if there is a behavior of that name, or it is no name of one, and UnknownName if the
        drive has no such command channel.
        """
        drive = self.segmentation.drive
        channels = [each.name for each in drive.channels]
        for channel in command:
            if channel not in channels:
                raise UnknownName(what="command channel", name=channel, where="the recording", known=channels)
        if name in (*self.segmentation.names, *self._library.kit.behaviors, *self._library.taught):
            problem, remedy = "there is a behavior of that name already", "choose another name"
            raise DefinitionError(what=f"behavior {name!r}", problem=problem, remedy=remedy)
        added = make_constant_candidate(name, command)
        originals = [each for each in self.segmentation.candidates if not isinstance(each, SplitState)]
        sensed = [each for each in self._features or () if not each.is_own]
        found = self._restore(segment(drive, [*originals, added], features=sensed))
        self._change(found._replace(defined=(*self.new_candidates, added)))

    def split_state(self, state: str, entered_from: Sequence[str]) -> None:
        """Give a state of its own to where a state was entered from certain others; see `split_state`."""
        changed = split_state(self.segmentation, state, entered_from)
        splits = (*self._labels.splits, (state, tuple(entered_from)))
        self._change(self._labels._replace(segmentation=changed, splits=splits))

    def extend(self, segmentation: Segmentation) -> None:
        """Take over the labels of a drive that went on.

        What was changed by hand stays, and can no longer be undone.
        """
        self._change(self._restore(segmentation))
        self._before.clear()

    def _restore(self, segmentation: Segmentation) -> _Labels:
        """Split the same states of other labels of the drive, and set those again that were set by hand."""
        before, by_hand = self.segmentation, self.by_hand
        for state, entered_from in self._labels.splits:
            with suppress(
                DefinitionError, UnknownName
            ):  # it may not be there, or not be entered so, any more
                segmentation = split_state(segmentation, state, entered_from)
        grown = np.zeros(segmentation.drive.ticks, np.bool_)
        grown[: len(by_hand)] = by_hand
        marks = np.where(by_hand, before.labels, -1)
        for episode in before.drive.episodes:
            cuts = episode.first + 1 + np.flatnonzero(np.diff(marks[episode.ticks]))
            for first, end in pairwise([episode.first, *cuts.tolist(), episode.end]):
                if by_hand[first]:
                    segmentation = relabel(segmentation, first, end, before.names[marks[first]])
        return self._labels._replace(segmentation=segmentation, by_hand=grown)

    def undo(self) -> None:
        """Take the last change back; SessionError if there is none."""
        if not self._before:
            raise SessionError("nothing was changed: there is nothing to undo")
        self._labels = self._before.pop()
        self.learned = self.saved = None

    def _change(self, labels: _Labels) -> None:
        self._before.append(self._labels)
        del self._before[:-MOST_UNDONE]
        self._labels = labels
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
        agreement = measure_agreement(self.segmentation, states)
        splits = propose_splits(made.lesson)
        self.learned = LearnedDrive(made, taught, states, agreement, splits)
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
