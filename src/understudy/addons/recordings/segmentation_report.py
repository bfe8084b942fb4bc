"""Reports of segmentations as plain data, which commands print: labels, spans, driver, and what was left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isinf
from types import MappingProxyType

from understudy.addons.recordings.candidates import CommandModel
from understudy.addons.recordings.drive_examples import DOUBT
from understudy.addons.recordings.drive_findings import DriveFindings, make_drive_findings
from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.rerun_drive import Agreement, measure_agreement
from understudy.addons.recordings.segment import Segmentation


@dataclass(frozen=True, slots=True)
class LabelShare:
    """How much of a drive a label explains: seconds, spans, and the mean certainty of its ticks."""

    label: str
    seconds: float
    spans: int
    certainty: float


@dataclass(frozen=True, slots=True)
class SpanRow:
    """A span of a drive: its file, the times of its first tick and its end in s, its label, and how certain that is."""

    file: str
    from_s: float
    to_s: float
    label: str
    certainty: float
    doubtful: bool


@dataclass(frozen=True, slots=True)
class ChannelRow:
    """The driver on one channel: noise, share of the way to an aim in a tick, and the largest step in a tick."""

    channel: str
    noise: float
    gain: float
    rate: float | None


@dataclass(frozen=True, slots=True)
class DriveReport:
    """The result of a segmentation as plain data.

    `constants` are those that were found, by candidate. `reaction_s` is None if the drive does not tell it;
    `reaction_evidence` says why it is taken. `quarantined` is the number of examples left out as doubtful. `agreement`
    counts the ticks that are repeated by what was learned without them. `findings` are for a person to know or to
    answer.
    """

    ticks: int
    tick_s: float
    labels: list[LabelShare]
    spans: list[SpanRow]
    driver: list[ChannelRow]
    dead_s: float
    constants: dict[str, dict[str, float]]
    examples: dict[str, int]
    quarantined: int
    reaction_s: float | None
    reaction_evidence: str
    omissions: list[str]
    agreement: Agreement
    findings: DriveFindings


def make_drive_report(
    segmentation: Segmentation, lesson: DriveLesson, *, targets: Mapping[str, str] = MappingProxyType({})
) -> DriveReport:
    """Make the report of a segmented drive and of the lesson that was made of it.

    `targets` are those of the drive that parameters of the automaton stand for.
    """
    drive, driver = segmentation.drive, segmentation.driver
    spans = [(episode, span) for episode in drive.episodes for span in segmentation.list_spans(episode)]
    labels = []
    for index, name in enumerate(segmentation.names):
        mine = segmentation.labels == index
        if mine.any():
            certainty = float(segmentation.certainties[mine].mean())
            count = sum(span.label == name for _, span in spans)
            labels.append(LabelShare(name, float(mine.sum() * drive.tick_s), count, certainty))
    kinds = [each.kind.value for each in lesson.lesson.examples]
    return DriveReport(
        drive.ticks,
        drive.tick_s,
        labels,
        [
            SpanRow(
                episode.source,
                float(drive.times[span.first]),
                float(drive.times[span.end - 1] + drive.tick_s),
                span.label,
                span.certainty,
                bool(segmentation.certainties[span.first : span.end].max() < DOUBT),
            )
            for episode, span in spans
        ],
        [
            ChannelRow(channel.name, float(noise), float(gain), None if isinf(rate) else float(rate))
            for channel, noise, gain, rate in zip(
                drive.channels, driver.noise, driver.gain, driver.rate, strict=True
            )
        ],
        driver.dead_ticks * drive.tick_s,
        {
            each.name: {name: float(each.constants[name]) for name in each.unknown}
            for each in segmentation.candidates
            if isinstance(each, CommandModel) and each.unknown
        },
        {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)},
        sum(bool(each.quarantined) for each in lesson.lesson.examples),
        None if lesson.reaction is None else lesson.reaction.reaction_s,
        "" if lesson.reaction is None else lesson.reaction.evidence,
        list(drive.omissions),
        measure_agreement(segmentation, lesson, targets=targets),
        make_drive_findings(segmentation, lesson),
    )
