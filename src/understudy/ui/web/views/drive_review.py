"""Describe a drive under review as data for the page: labels, series, questions, and what was learned."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.drive_examples import DOUBT
from understudy.addons.recordings.driver_contradictions import DriverContradiction
from understudy.addons.recordings.propose_behaviors import describe_command
from understudy.addons.recordings.relabel import list_label_questions
from understudy.model.example_source import ExampleSource
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import Continuous, Kind
from understudy.ui.controller.recording_review import LearnedDrive, RecordingReview
from understudy.ui.web.messages.base import Data
from understudy.ui.web.views.scene import FeatureData
from understudy.ui.web.views.session import NestedStateData, TransitionData, list_ways

MOST_POINTS = 3000
"""The largest number of points of a series; longer ones are thinned."""


class EpisodeData(Data, frozen=True, kw_only=True):
    """A piece of a recording without a gap: its file, who drove, its ticks, and the time of its first one, s."""

    source: str
    driver: str
    """Who drove; empty if that is not known."""
    first: int
    end: int
    from_s: float


class LabelSpanData(Data, frozen=True, kw_only=True):
    """Ticks in a row with one label, which is an index into the labels."""

    first: int
    end: int
    label: int
    certainty: float
    doubtful: bool
    by_hand: bool


class StateSpanData(Data, frozen=True, kw_only=True):
    """Ticks in a row in which the learned automaton is in one state; the label is -1 for a state that is no label."""

    first: int
    end: int
    label: int


class LabelQuestionData(Data, frozen=True, kw_only=True):
    """A span whose label is in doubt, with the labels that come into question, the likeliest first."""

    first: int
    end: int
    labels: list[int]
    chances: list[float]


class BehaviorProposalData(Data, frozen=True, kw_only=True):
    """Commands that nothing explains, but that recur: by channel, in words, for how long, and their longest span."""

    command: dict[str, float]
    description: str
    seconds: float
    spans: int
    first: int
    end: int


class SplitProposalData(Data, frozen=True, kw_only=True):
    """A state that is better split in two, after which others it is to be a state of its own, and the evidence."""

    state: str
    entered_from: list[str]
    evidence: str


class DriverChoiceData(Data, frozen=True, kw_only=True):
    """What one of two drivers did who contradict each other, in words, and the tick of an example of it."""

    driver: str
    description: str
    tick: int


class ContradictionData(Data, frozen=True, kw_only=True):
    """A contradiction between two drivers, and the one whose examples are kept if it is settled."""

    state: str
    choices: list[DriverChoiceData]
    trust: str | None


class SeriesData(FeatureData, frozen=True, kw_only=True):
    """A reading or a command over the ticks, thinned; null where it is absent."""

    is_command: bool
    ticks: list[int]
    values: list[float | None]


class LearnedDriveData(Data, frozen=True, kw_only=True):
    """The automaton learned from the labels, and how it agrees with them."""

    agreement: float
    """The share of ticks that it repeats, from 0 to 1."""
    repeats: str
    """How many ticks it repeats, in words."""
    unseen: float
    """The share of ticks that are repeated by what is learned without them, from 0 to 1."""
    repeats_unseen: str
    """How many ticks are repeated by what is learned without them, in words."""
    spans: list[StateSpanData]
    states: list[NestedStateData]
    edges: list[TransitionData]
    examples: int
    quarantined: int
    reactions: list[str]
    """The reaction time of each driver in a sentence."""
    splits: list[SplitProposalData]
    contradictions: list[ContradictionData]
    """The contradictions between drivers; those that are settled come last."""


class ReviewData(Data, frozen=True, kw_only=True):
    """A drive under review, as it stands."""

    name: str
    tick_s: float
    labels: list[str]
    """The labels, of which the last means that nothing explains the commands."""
    episodes: list[EpisodeData]
    drivers: list[str]
    """The names of the drivers; an empty one for a driver without a name."""
    trust: str | None
    """The driver who is right where drivers contradict each other, if one is."""
    spans: list[LabelSpanData]
    questions: list[LabelQuestionData]
    proposals: list[BehaviorProposalData]
    omissions: list[str]
    """Sentences about all that was left out when the recording was read."""
    learned: LearnedDriveData | None
    can_undo: bool
    saved: str | None
    """The file of the learned automaton."""


class RecordedSeriesData(Data, frozen=True, kw_only=True):
    """The recorded series and path, which do not change during a review."""

    series: list[SeriesData]
    path_ticks: list[int]
    path: list[tuple[float, float]]
    """The place of the robot at each of the `path_ticks`, m; empty if it is not known."""


def describe_review(review: RecordingReview) -> ReviewData:
    """Return a drive under review as data."""
    segmentation = review.segmentation
    drive, names = segmentation.drive, segmentation.names
    return ReviewData.of(
        review,
        tick_s=drive.tick_s,
        labels=list(names),
        episodes=[
            EpisodeData.of(each, driver=review.find_driver(each.first), from_s=float(drive.times[each.first]))
            for each in drive.episodes
        ],
        spans=list(_list_label_spans(review)),
        questions=[
            LabelQuestionData.of(
                each,
                labels=[names.index(label) for label in each.labels],
                chances=[round(chance, 3) for chance in each.chances],
            )
            for each in list_label_questions(segmentation)
        ],
        proposals=[
            BehaviorProposalData.of(
                each,
                description=describe_command(drive.channels, each.command),
                seconds=round(each.seconds, 2),
                spans=len(each.spans),
                first=each.spans[0].first,
                end=each.spans[0].end,
            )
            for each in review.list_proposals()
        ],
        omissions=list(drive.omissions),
        learned=None if review.learned is None else _describe_learned(review, review.learned),
        saved=None if review.saved is None else str(review.saved),
    )


def _list_label_spans(review: RecordingReview) -> Iterator[LabelSpanData]:
    segmentation, by_hand = review.segmentation, review.by_hand
    sure = segmentation.certainties
    for episode in segmentation.drive.episodes:
        for first, end in episode.list_runs(segmentation.labels * 2 + by_hand):
            yield LabelSpanData(
                first=first,
                end=end,
                label=int(segmentation.labels[first]),
                certainty=round(float(sure[first:end].mean()), 3),
                doubtful=bool(sure[first:end].max() < DOUBT),
                by_hand=bool(by_hand[first]),
            )


def _describe_learned(review: RecordingReview, learned: LearnedDrive) -> LearnedDriveData:
    automaton, lesson = learned.taught.automaton, learned.drive.lesson
    library = learned.drive.library.with_automaton(learned.taught)
    return LearnedDriveData.of(
        learned,
        agreement=learned.agreement.share,
        repeats=str(learned.agreement),
        unseen=learned.unseen.share,
        repeats_unseen=str(learned.unseen),
        spans=[
            StateSpanData(first=first, end=end, label=int(learned.states[first]))
            for episode in review.segmentation.drive.episodes
            for first, end in episode.list_runs(learned.states)
        ],
        states=[NestedStateData.of_state(state, library) for state in automaton.states],
        edges=list_ways(automaton, learned.taught.lesson),
        examples=len(lesson.examples),
        quarantined=sum(bool(each.quarantined) for each in lesson.examples),
        reactions=[
            f"Reaction time{' of ' * bool(driver)}{driver} {each.reaction_s:g} s. {each.evidence}"
            for driver, each in learned.reactions.items()
            if each is not None
        ],
        splits=[SplitProposalData.of(each, evidence=str(each)) for each in learned.splits],
        contradictions=[
            *(_describe_contradiction(review, each, None) for each in learned.contradictions),
            *(_describe_contradiction(review, each, trust) for each, trust in learned.settled),
        ],
    )


def _describe_contradiction(
    review: RecordingReview, contradiction: DriverContradiction, trust: str | None
) -> ContradictionData:
    return ContradictionData.of(
        contradiction,
        choices=[
            DriverChoiceData(
                driver=driver,
                description=contradiction.describe_side(side),
                tick=_find_tick(review, driver, contradiction.examples[side].source),
            )
            for side, driver in enumerate(contradiction.drivers)
        ],
        trust=trust,
    )


def _find_tick(review: RecordingReview, driver: str, source: ExampleSource | None) -> int:
    """Find the tick of a driver that is nearest in time to the source of an example."""
    drive = review.segmentation.drive
    ticks = [
        each.first + int(np.argmin(np.abs(drive.times[each.ticks] - source.time_s)))
        for each in drive.episodes
        if source is not None
        and Path(each.source).name == source.file
        and review.find_driver(each.first) == driver
    ]
    if source is None or not ticks:
        return 0
    return min(ticks, key=lambda tick: abs(float(drive.times[tick]) - source.time_s))


def describe_series(review: RecordingReview, places: NDArray[np.float64] | None) -> RecordedSeriesData:
    """Return the commands and readings of a drive, and where the robot was [T, 2] if that is known, as data."""
    drive = review.segmentation.drive
    ticks = np.arange(0, drive.ticks, max(1, -(-drive.ticks // MOST_POINTS)))
    readings = {each.name: each for each in drive.readings}
    series = [
        _describe_column(
            channel.name, channel.unit, Continuous(), drive.commands[ticks, index], ticks, is_command=True
        )
        for index, channel in enumerate(drive.channels)
    ]
    for key, column in drive.values.items():
        label, reading = format_reading_label(key), readings[key[0]]
        series.append(
            _describe_column(label, reading.unit, reading.kind, column[ticks], ticks, is_command=False)
        )
    located = np.empty(0, np.int64) if places is None else ticks[np.isfinite(places[ticks]).all(axis=1)]
    return RecordedSeriesData(
        series=series,
        path_ticks=located.tolist(),
        path=[] if places is None else [(round(x, 3), round(y, 3)) for x, y in places[located].tolist()],
    )


def _describe_column(
    label: str,
    unit: str,
    kind: Kind,
    column: NDArray[np.float64],
    ticks: NDArray[np.int64],
    *,
    is_command: bool,
) -> SeriesData:
    values = [round(value, 5) if isfinite(value) else None for value in column.tolist()]
    return SeriesData.of_kind(kind, label, unit, is_command=is_command, ticks=ticks.tolist(), values=values)
