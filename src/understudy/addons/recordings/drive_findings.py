"""What a person should know or answer about a segmented drive, as plain data: doubts, proposals, and latencies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.motion_latency import MotionLatency, estimate_motion_latencies
from understudy.addons.recordings.propose_behaviors import describe_command, propose_behaviors
from understudy.addons.recordings.relabel import list_label_questions
from understudy.addons.recordings.segment import Segmentation
from understudy.addons.recordings.split_states import propose_splits
from understudy.records.record import Record


@dataclass(frozen=True, slots=True)
class DrivePlace:
    """A span of a recording: its file, and its first time and its end in it, s."""

    file: str
    from_s: float
    to_s: float


@dataclass(frozen=True, slots=True)
class QuestionRow:
    """A span whose label is in doubt, with the labels that come into question and the chance of each."""

    place: DrivePlace
    chances: dict[str, float]
    seconds_in_doubt: float


@dataclass(frozen=True, slots=True)
class BehaviorRow:
    """A proposed behavior: its command by channel, also in words, the time it explains, and its longest span."""

    command: Mapping[str, float]
    description: str
    seconds: float
    spans: int
    longest: DrivePlace


@dataclass(frozen=True, slots=True)
class SplitRow:
    """A state that is proposed to be split, the states before that part it, and the evidence in a sentence."""

    state: str
    entered_from: tuple[str, ...]
    stays: int
    wrong_together: int
    wrong_apart: int
    evidence: str


@dataclass(frozen=True, slots=True)
class DriveFindings:
    """What a person should know or answer about a drive.

    `questions` are about spans in doubt, the most useful first. `behaviors` are proposed for commands that nothing
    explains, `splits` for states that end in ways which no feature tells apart. `latencies` say how long after a
    command the motion follows.
    """

    questions: list[QuestionRow]
    behaviors: list[BehaviorRow]
    splits: list[SplitRow]
    latencies: list[MotionLatency]


def make_drive_findings(segmentation: Segmentation, lesson: DriveLesson | None) -> DriveFindings:
    """Find what a person should know or answer about a segmented drive.

    Parameters
    ----------
    segmentation
        The labels of the drive.
    lesson
        The lesson that was made of it. None: no splits are looked for.

    Returns
    -------
    DriveFindings
        The findings.
    """
    drive = segmentation.drive
    return DriveFindings(
        [
            QuestionRow(
                _locate(drive, each.first, each.end),
                {label: round(chance, 4) for label, chance in zip(each.labels, each.chances, strict=True)},
                each.seconds_in_doubt,
            )
            for each in list_label_questions(segmentation)
        ],
        [
            BehaviorRow(
                dict(each.command),
                describe_command(drive.channels, each.command),
                each.seconds,
                len(each.spans),
                _locate(drive, each.spans[0].first, each.spans[0].end),
            )
            for each in propose_behaviors(segmentation)
        ],
        []
        if lesson is None
        else [
            SplitRow(
                each.state, each.entered_from, each.stays, each.wrong_together, each.wrong_apart, str(each)
            )
            for each in propose_splits(lesson.lesson)
        ],
        list(estimate_motion_latencies(drive)),
    )


def _locate(drive: Record, first: int, end: int) -> DrivePlace:
    file = drive.find_episode(first).source
    return DrivePlace(file, float(drive.times[first]), float(drive.times[end - 1] + drive.tick_s))
