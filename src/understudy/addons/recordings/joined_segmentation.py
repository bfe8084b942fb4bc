"""Labels of several drives of one robot joined, so that they can be looked at and compared as those of one drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.addons.recordings.candidates import Candidate
from understudy.addons.recordings.segment import Segmentation
from understudy.records.join_records import join_records


def join_segmentations(parts: Sequence[Segmentation]) -> Segmentation:
    """Join the labels of several drives, each of which may be of another driver.

    Parameters
    ----------
    parts
        At least one segmentation; candidates with the same name are taken as the same. All drives have the same
        readings, targets, channels and length of a tick.

    Returns
    -------
    Segmentation
        The labels of all drives, one after the other. Its driver is the one with the most noise.

    Raises
    ------
    DefinitionError
        If two drives have different readings, channels or lengths of a tick.
    """
    if len(parts) == 1:
        return parts[0]
    drive = join_records([each.drive for each in parts])
    candidates: dict[str, Candidate] = {}
    for candidate in (candidate for each in parts for candidate in each.candidates):
        candidates.setdefault(candidate.name, candidate)
    names, count = list(candidates), len(candidates)
    labels, posteriors = np.empty(drive.ticks, np.int64), np.zeros((drive.ticks, count + 1))
    begin = 0
    for each in parts:
        places = np.array([*(names.index(candidate.name) for candidate in each.candidates), count])
        end = begin + each.drive.ticks
        labels[begin:end] = places[each.labels]
        posteriors[begin:end, places] = each.posteriors
        begin = end
    noisiest = max(parts, key=lambda each: float(each.driver.noise.sum()))
    likelihood = sum(each.likelihood for each in parts)
    return Segmentation(drive, tuple(candidates.values()), labels, posteriors, noisiest.driver, likelihood)
