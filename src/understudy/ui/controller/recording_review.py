"""A segmented drive under review: labels set by hand, undone, learned from, compared with, and saved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.candidates import Candidate, SplitState
from understudy.addons.recordings.driver_contradictions import DriverContradiction
from understudy.addons.recordings.driver_lessons import merge_driver_lessons
from understudy.addons.recordings.joined_segmentation import join_segmentations
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.propose_behaviors import (
    BehaviorProposal,
    make_constant_candidate,
    propose_behaviors,
)
from understudy.addons.recordings.relabel import relabel
from understudy.addons.recordings.rerun_drive import count_repeated, run_over_drive
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.addons.recordings.split_states import SplitProposal, propose_splits, split_state
from understudy.errors import DefinitionError, SessionError, UnknownName
from understudy.learning.fit import learn_automaton
from understudy.model.features import BoundFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.storage.library_folder import open_each_automaton, save_automaton
from understudy.training.reaction_time import ReactionEstimate
from understudy.ui.controller.driver_settlements import DriverSettlement, SettledContradiction, settle_lesson

MOST_UNDONE = 200
"""The number of changes that can be undone."""


@dataclass(frozen=True, slots=True)
class LearnedDrive:
    """The automaton that was learned from the labels as they were then.

    `states` has the index of the label whose state the automaton is in at each tick of the drive, and `agreement` the
    share of ticks at which that is the drive's label. `splits` are states that are better split in two,
    `contradictions` what drivers still disagree on, `settled` what was decided. `reactions` are those of each driver.
    """

    drive: DriveLesson
    taught: TrainedAutomaton
    states: NDArray[np.int64]
    agreement: float
    splits: tuple[SplitProposal, ...]
    contradictions: tuple[DriverContradiction, ...]
    settled: tuple[SettledContradiction, ...]
    reactions: Mapping[str, ReactionEstimate | None]


class _Labels(NamedTuple):
    """The labels of each driver's drive and those of all joined, and all else that can be changed and undone.

    That is the ticks [T] at which labels were set by hand, behaviors added, states split, and settled contradictions.
    """

    parts: tuple[Segmentation, ...]
    joined: Segmentation
    by_hand: NDArray[np.bool_]
    defined: tuple[Candidate, ...] = ()
    splits: tuple[tuple[str, tuple[str, ...]], ...] = ()
    settlements: tuple[DriverSettlement, ...] = ()
    trust: str | None = None

    def replace_parts(self, parts: Sequence[Segmentation], by_hand: NDArray[np.bool_]) -> _Labels:
        """Return these with other labels."""
        return self._replace(parts=tuple(parts), joined=join_segmentations(parts), by_hand=by_hand)


class _Taught(NamedTuple):
    """The lesson made of some labels, before contradictions are settled."""

    parts: tuple[Segmentation, ...]
    drive: DriveLesson
    reactions: Mapping[str, ReactionEstimate | None]


class RecordingReview:
    """The review of a segmented drive, or of the drives of several drivers one after the other.

    Parameters
    ----------
    segmentation
        The labels as they were found; of several drivers, or of one with a name, those of each by name.
    library
        The features and behaviors that the automaton uses.
    features
        Features that decisions depend on. None: all readings.
    folder
        The library's folder that the automaton is saved in.
    name
        Name of the automaton.
    trust
        The driver who is right where drivers contradict each other. None: none yet.
    targets
        Targets of the drive that parameters of the automaton stand for, by parameter.
    """

    def __init__(
        self,
        segmentation: Segmentation | Mapping[str, Segmentation],
        library: Library,
        *,
        features: Sequence[BoundFeature] | None,
        folder: Path,
        name: str,
        trust: str | None = None,
        targets: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self.name = name
        parts = {"": segmentation} if isinstance(segmentation, Segmentation) else segmentation
        self.drivers = tuple(parts)
        """The names of the drivers, in order; an empty one if there is none."""
        self.learned: LearnedDrive | None = None
        """The automaton learned from the present labels; None until then."""
        self.saved: Path | None = None
        """The file of the learned automaton; None until it is saved."""
        self.is_growing = False
        """True while the robot is driven; then no behaviors are proposed, which takes time in long drives."""
        self._library, self._features, self._folder = library, features, folder
        self._targets = targets
        joined = join_segmentations(tuple(parts.values()))
        by_hand = np.zeros(joined.drive.ticks, np.bool_)
        self._labels = _Labels(tuple(parts.values()), joined, by_hand, trust=trust)
        self._before: list[_Labels] = []
        self._taught: _Taught | None = None
        self._proposed: tuple[Segmentation, tuple[BehaviorProposal, ...]] | None = None

    @property
    def segmentation(self) -> Segmentation:
        """The present labels, of all drivers."""
        return self._labels.joined

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
        """True if there is a change that can be undone."""
        return bool(self._before)

    @property
    def trust(self) -> str | None:
        """The driver who is right where drivers contradict each other; None if that is decided one by one."""
        return self._labels.trust

    def find_driver(self, tick: int) -> str:
        """Return the name of the driver at a tick; empty if it is not known."""
        return self.drivers[self._find_part(tick)[0]]

    def _find_part(self, tick: int) -> tuple[int, int]:
        """Return the index of the drive that a tick is of, and its first tick."""
        first = 0
        for index, each in enumerate(self._labels.parts):
            if tick < first + each.drive.ticks:
                return index, first
            first += each.drive.ticks
        return len(self._labels.parts) - 1, first - self._labels.parts[-1].drive.ticks

    def set_label(self, first: int, end: int, label: str) -> None:
        """Set the label of a span by hand; see `relabel` for the errors."""
        by_hand = self.by_hand.copy()
        by_hand[first:end] = True
        relabel(self.segmentation, first, end, label)  # its errors have the ticks that were asked for
        parts = list(self._labels.parts)
        index, begin = self._find_part(first)
        parts[index] = relabel(parts[index], first - begin, end - begin, label)
        self._change(self._labels.replace_parts(parts, by_hand))

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
        channels = [each.name for each in self.segmentation.drive.channels]
        for channel in command:
            if channel not in channels:
                raise UnknownName(what="command channel", name=channel, where="the recording", known=channels)
        if name in (*self.segmentation.names, *self._library.kit.behaviors, *self._library.taught):
            problem, remedy = "there is a behavior of that name already", "choose another name"
            raise DefinitionError(what=f"behavior {name!r}", problem=problem, remedy=remedy)
        added = make_constant_candidate(name, command)
        sensed = [each for each in self._features or () if not each.is_own]
        segmentations = []
        for part in self._labels.parts:
            originals = [each for each in part.candidates if not isinstance(each, SplitState)]
            segmentations.append(segment(part.drive, [*originals, added], features=sensed))
        self._change(self._restore(segmentations)._replace(defined=(*self.new_candidates, added)))

    def split_state(self, state: str, entered_from: Sequence[str]) -> None:
        """Give a state of its own to where a state was entered from certain others; see `split_state`."""
        parts = list(self._labels.parts)
        problem: Exception | None = None
        for index, each in enumerate(parts):
            try:
                parts[index] = split_state(each, state, entered_from)
            except (DefinitionError, UnknownName) as error:  # this driver may not do so
                problem = problem or error
        if problem is not None and all(
            one is other for one, other in zip(parts, self._labels.parts, strict=True)
        ):
            raise problem
        splits = (*self._labels.splits, (state, tuple(entered_from)))
        self._change(self._labels.replace_parts(parts, self.by_hand)._replace(splits=splits))

    def extend(self, segmentation: Segmentation) -> None:
        """Take over the labels of a drive that went on.

        What was changed by hand stays, and can no longer be undone.
        """
        self._change(self._restore([segmentation]))
        self._before.clear()

    def _restore(self, segmentations: Sequence[Segmentation]) -> _Labels:
        """Split the same states of other labels of the drives, and set those again that were set by hand."""
        parts, marks, first = [], [], 0
        for segmentation, before in zip(segmentations, self._labels.parts, strict=True):
            by_hand = self.by_hand[first : first + before.drive.ticks]
            first += before.drive.ticks
            parts.append(self._restore_part(segmentation, before, by_hand))
            grown = np.zeros(segmentation.drive.ticks, np.bool_)
            grown[: len(by_hand)] = by_hand
            marks.append(grown)
        return self._labels.replace_parts(parts, np.concatenate(marks))

    def _restore_part(
        self, segmentation: Segmentation, before: Segmentation, by_hand: NDArray[np.bool_]
    ) -> Segmentation:
        for state, entered_from in self._labels.splits:
            with suppress(
                DefinitionError, UnknownName
            ):  # it may not be there, or not be entered so, any more
                segmentation = split_state(segmentation, state, entered_from)
        marks = np.where(by_hand, before.labels, -1)
        for episode in before.drive.episodes:
            for first, end in episode.list_runs(marks):
                if by_hand[first]:
                    segmentation = relabel(segmentation, first, end, before.names[marks[first]])
        return segmentation

    def settle_contradiction(self, index: int, trust: str) -> None:
        """Settle one of the contradictions of `learned`: the driver who is trusted is right there.

        SessionError is raised if there is no such contradiction, and UnknownName if it is not of that driver.
        """
        contradictions = () if self.learned is None else self.learned.contradictions
        if not 0 <= index < len(contradictions):
            raise SessionError("there is no such contradiction: learn first, and choose one of those listed")
        if trust not in contradictions[index].drivers:
            raise UnknownName(
                what="driver",
                name=trust,
                where="the contradiction",
                known=list(contradictions[index].drivers),
            )
        settlement = DriverSettlement.from_contradiction(contradictions[index], trust)
        self._decide(self._labels._replace(settlements=(*self._labels.settlements, settlement)))

    def trust_driver(self, name: str | None) -> None:
        """Trust a driver where contradictions are not settled one by one; None: no driver. UnknownName for others."""
        if name is not None and name not in self.drivers:
            raise UnknownName(what="driver", name=name, where="the recordings", known=list(self.drivers))
        self._decide(self._labels._replace(trust=name))

    def _decide(self, labels: _Labels) -> None:
        """Take over another decision about contradictions; what was learned is learned again."""
        learned = self.learned is not None
        self._change(labels)
        if learned:
            self._conclude()

    def undo(self) -> None:
        """Take the last change back; SessionError if there is none."""
        if not self._before:
            raise SessionError("nothing was changed: there is nothing to undo")
        learned = self.learned is not None
        self._labels = self._before.pop()
        self.learned = self.saved = None
        if learned and self._taught is not None and self._taught.parts is self._labels.parts:
            self._conclude()

    def _change(self, labels: _Labels) -> None:
        self._before.append(self._labels)
        del self._before[:-MOST_UNDONE]
        self._labels = labels
        self.learned = self.saved = None

    def learn(self) -> LearnedDrive:
        """Learn an automaton from the present labels, and run it over the readings.

        DefinitionError is raised if nothing explains any tick, and other errors of `to_lesson`.
        """
        lessons = {
            driver: to_lesson(
                part,
                name=self.name,
                driver=driver,
                library=self._library,
                features=self._features,
                targets=self._targets,
            )
            for driver, part in zip(self.drivers, self._labels.parts, strict=True)
        }
        drives = list(lessons.values())
        reactions = {driver: each.reaction for driver, each in lessons.items()}
        joined = drives[0] if len(drives) == 1 else merge_driver_lessons(drives)
        self._taught = _Taught(self._labels.parts, joined, reactions)
        return self._conclude()

    def _conclude(self) -> LearnedDrive:
        """Settle the contradictions of the lesson that was made, learn from it, and run it over the readings."""
        if self._taught is None:
            raise SessionError("nothing was learned from these labels: learn first")
        _, drive, reactions = self._taught
        lesson, settled, left = settle_lesson(drive.lesson, self._labels.settlements, self.trust)
        drive = replace(drive, lesson=lesson)
        taught = TrainedAutomaton(learn_automaton(lesson), lesson)
        names = tuple(each.name for each in self.segmentation.candidates)
        states = run_over_drive(
            drive.library.with_automaton(taught),
            taught.automaton.name,
            self.segmentation.drive,
            names,
            targets=self._targets,
        )
        agreement = count_repeated(self.segmentation, states).share
        splits = propose_splits(lesson)
        self.learned = LearnedDrive(drive, taught, states, agreement, splits, left, settled, reactions)
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
