"""Labels that a person gives: spans of a drive set by hand, and the doubtful spans that are worth asking about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from understudy.addons.recordings.drive_examples import DOUBT
from understudy.addons.recordings.segment import UNEXPLAINED, Segmentation
from understudy.errors import DefinitionError, UnknownName


@dataclass(frozen=True, slots=True)
class LabelQuestion:
    """A span whose label is in doubt.

    Parameters
    ----------
    first
        Its first tick.
    end
        The tick after its last one.
    labels
        The labels that come into question, the likeliest first, at most three.
    chances
        The mean probability of each over the span.
    seconds_in_doubt
        The expected time with a wrong label, s; questions with more of it come first.
    """

    first: int
    end: int
    labels: tuple[str, ...]
    chances: tuple[float, ...]
    seconds_in_doubt: float


def relabel(segmentation: Segmentation, first: int, end: int, label: str) -> Segmentation:
    """Set the label of a span by hand; it is certain from then on.

    Parameters
    ----------
    segmentation
        The labels of a drive.
    first
        The first tick of the span.
    end
        The tick after its last one.
    label
        Name of a candidate, or `UNEXPLAINED` to leave the span out of lessons.

    Returns
    -------
    Segmentation
        The labels with that span changed.

    Raises
    ------
    UnknownName
        If no candidate has that name.
    DefinitionError
        If the span has no tick of the drive, or ticks of several episodes.
    """
    names = segmentation.names
    if label not in names:
        raise UnknownName(what="behavior", name=label, where="the recording", known=names)
    drive = segmentation.drive
    if not 0 <= first < end <= drive.ticks or drive.find_episode(first) is not drive.find_episode(end - 1):
        raise DefinitionError(
            what=f"span from tick {first} to {end}",
            problem=f"it is no part of an episode of the {drive.ticks} ticks",
            remedy="name ticks of one episode, the end after the beginning",
        )
    index = names.index(label)
    labels, posteriors = segmentation.labels.copy(), segmentation.posteriors.copy()
    labels[first:end] = index
    posteriors[first:end] = np.arange(len(names)) == index
    return replace(segmentation, labels=labels, posteriors=posteriors)


def list_label_questions(segmentation: Segmentation, *, most: int = 20) -> Sequence[LabelQuestion]:
    """List the spans whose labels are in doubt, those first whose answer changes the most.

    Parameters
    ----------
    segmentation
        The labels of a drive.
    most
        The largest number of questions.

    Returns
    -------
    Sequence[LabelQuestion]
        The questions. Lessons leave out the switches to and from these spans until they are answered.
    """
    questions = []
    names, tick_s = segmentation.names, segmentation.drive.tick_s
    for episode in segmentation.drive.episodes:
        for span in segmentation.list_spans(episode):
            if (
                span.label == UNEXPLAINED
                or segmentation.list_certainties(span.first, span.end).max() >= DOUBT
            ):
                continue
            chances = segmentation.posteriors[span.first : span.end].mean(axis=0)
            likeliest = [
                int(each) for each in np.argsort(-chances, kind="stable")[:3] if chances[each] > 0.01
            ]
            questions.append(
                LabelQuestion(
                    span.first,
                    span.end,
                    tuple(names[each] for each in likeliest),
                    tuple(float(chances[each]) for each in likeliest),
                    float((1 - chances.max()) * (span.end - span.first) * tick_s),
                )
            )
    questions.sort(key=lambda each: -each.seconds_in_doubt)
    return questions[:most]
