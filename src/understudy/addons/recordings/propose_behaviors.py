"""Proposals of new basic behaviors: commands that no candidate explains, but that the driver gave again and again.

Each unexplained tick says what the driver would have aimed at, had the aim been constant. Where many agree, there is a
behavior without a name. It is proposed with the spans that it explains, once it has stood the same test as candidates.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, log10
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.alternation import shift_ticks
from understudy.addons.recordings.candidates import BehaviorCandidate, Candidate
from understudy.addons.recordings.driver_model import DriverModel, guess_still_driver
from understudy.addons.recordings.segment import UNEXPLAINED, Segmentation, Span, label_drive, segment
from understudy.errors import DefinitionError
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding
from understudy.records.record import Floats, Record
from understudy.runtime.body import Channel
from understudy.runtime.link import GroundBehavior

LEAST_S = 1.0
"""The shortest time, s, that a proposed behavior has to explain in all."""
LEAST_SPAN_S = 0.5
"""The shortest span, s, that counts; a stick on its way from one aim to another passes faster."""
MOST_STARTS = 400
"""The largest number of ticks, spread over the unexplained ones, at which commands in common are looked for."""
MOST_VOTES = 5000
ROUNDS = 20
NEAR, FAR = 2.5, 5.0
"""Votes agree if they are apart by up to `NEAR` standard deviations; those up to `FAR` are no further behavior."""


@dataclass(frozen=True, slots=True)
class BehaviorProposal:
    """A constant command that explains ticks which nothing else explains.

    Parameters
    ----------
    command
        Value by channel; channels at rest are left out.
    spans
        The spans that it explains, those with the most ticks first.
    seconds
        The time that it explains, s.
    """

    command: Mapping[str, float]
    spans: tuple[Span, ...]
    seconds: float


def propose_behaviors(
    segmentation: Segmentation, *, most: int = 3, least_s: float = LEAST_S
) -> tuple[BehaviorProposal, ...]:
    """Propose basic behaviors for the ticks of a drive that no candidate explains.

    Parameters
    ----------
    segmentation
        The labels of a drive.
    most
        The largest number of proposals.
    least_s
        The shortest time, s, that a proposal has to explain in all.

    Returns
    -------
    tuple
        The proposals, those that explain the most time first.
    """
    proposals = _propose(
        segmentation.drive,
        segmentation.candidates,
        segmentation.labels == len(segmentation.candidates),
        segmentation.driver,
        most=most,
        least_s=least_s,
    )
    return tuple(sorted(proposals, key=lambda each: -each.seconds))


def discover_behaviors(drive: Record, *, most: int = 8) -> tuple[BehaviorProposal, ...]:
    """Propose basic behaviors for a drive of which nothing is known: the constant commands that recur in it.

    Parameters
    ----------
    drive
        The drive.
    most
        The largest number of proposals.

    Returns
    -------
    tuple
        The proposals, those first that were found first.
    """
    still = guess_still_driver(drive.commands)
    proposals = _propose(drive, (), np.ones(drive.ticks, np.bool_), still, most=most, least_s=LEAST_S)
    while proposals and len(proposals) < most:
        named = [
            make_constant_candidate(f"proposal_{number}", each.command)
            for number, each in enumerate(proposals)
        ]
        more = propose_behaviors(segment(drive, named), most=most - len(proposals))
        if not more:
            break
        proposals.extend(more)
    return tuple(proposals)


def _propose(
    drive: Record,
    candidates: Sequence[Candidate],
    unexplained: NDArray[np.bool_],
    driver: DriverModel,
    *,
    most: int,
    least_s: float,
) -> list[BehaviorProposal]:
    """Propose behaviors for unexplained ticks [T] of a drive, beside candidates."""
    least_ticks = least_s / drive.tick_s
    if (~unexplained).sum() < least_ticks:
        driver = guess_still_driver(drive.commands)
    votes, deviation = _vote(drive, driver)
    open_ticks = np.flatnonzero(unexplained & np.isfinite(votes).all(axis=1))
    commands: list[dict[str, float]] = []
    while len(open_ticks) >= least_ticks and len(commands) < most:
        center = _find_common(votes[open_ticks], deviation)
        apart = np.abs(votes[open_ticks] - center) / deviation
        if (apart <= NEAR).all(axis=1).sum() < least_ticks:
            break
        commands.append(_round_command(drive.channels, center, deviation))
        open_ticks = open_ticks[(apart > FAR).any(axis=1)]
    return _select_proposals(drive, candidates, unexplained, driver, commands, least_s)


def _vote(drive: Record, driver: DriverModel) -> tuple[Floats, Floats]:
    """Return the constant aim [T, C] that would explain each tick's command exactly, and its standard deviation [C]."""
    last = shift_ticks(drive.list_last_commands(), driver.dead_ticks, drive.episodes)
    answer = shift_ticks(drive.commands, driver.dead_ticks, drive.episodes)
    votes: Floats = last + (answer - last) / driver.gain
    return votes, driver.noise / driver.gain


def _find_common(votes: Floats, deviation: Floats) -> Floats:
    """Return the center [C] on which most votes [n, C] agree: mean shift from many starts."""
    votes = votes[:: -(-len(votes) // MOST_VOTES)]
    best: Floats = votes[0]
    most = 0
    for start in np.linspace(0, len(votes) - 1, min(MOST_STARTS, len(votes))).astype(int).tolist():
        center, agree = votes[start], np.zeros(len(votes), np.bool_)
        for _ in range(ROUNDS):
            near = (np.abs(votes - center) <= NEAR * deviation).all(axis=1)
            if np.array_equal(near, agree):
                break
            agree, center = near, votes[near].mean(axis=0)
        if agree.sum() > most:
            best, most = center, int(agree.sum())
    return best


def _round_command(channels: Sequence[Channel], center: Floats, deviation: Floats) -> dict[str, float]:
    """Return the command, rounded as the driver's noise allows, without channels that are at rest within it."""
    command = {}
    for channel, value, noise in zip(channels, center.tolist(), deviation.tolist(), strict=True):
        if abs(value - channel.rest) > noise:
            command[channel.name] = round(value, max(0, ceil(-log10(noise / 2))))
    return command


def _select_proposals(
    drive: Record,
    candidates: Sequence[Candidate],
    unexplained: NDArray[np.bool_],
    driver: DriverModel,
    commands: Sequence[dict[str, float]],
    least_s: float,
) -> list[BehaviorProposal]:
    """Label the drive with the commands as candidates too, and return those that explain enough unexplained ticks."""
    if not commands:
        return []
    taken = {each.name for each in candidates}
    free = (name for name in (f"proposal_{number}" for number in itertools.count(1)) if name not in taken)
    added = [make_constant_candidate(next(free), each) for each in commands]
    tried = label_drive(drive, (*candidates, *added), driver)
    proposals = []
    for index, command in enumerate(commands, len(candidates)):
        spans = _list_long_spans(tried, unexplained & (tried.labels == index))
        seconds = sum(each.end - each.first for each in spans) * drive.tick_s
        if seconds >= least_s:
            proposals.append(BehaviorProposal(MappingProxyType(command), spans, seconds))
    return proposals


def _list_long_spans(tried: Segmentation, ticks: NDArray[np.bool_]) -> tuple[Span, ...]:
    """Return the runs of ticks within episodes that last, the longest first, as spans of what is unexplained yet."""
    long_spans = []
    for episode in tried.drive.episodes:
        edges = np.flatnonzero(np.diff(ticks[episode.ticks], prepend=False, append=False)) + episode.first
        for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if (end - first) * tried.drive.tick_s >= LEAST_SPAN_S:
                long_spans.append(Span(UNEXPLAINED, first, end, float(tried.certainties[first:end].mean())))
    return tuple(sorted(long_spans, key=lambda each: each.first - each.end))


def make_constant_candidate(name: str, command: Mapping[str, float]) -> BehaviorCandidate:
    """Make a candidate that always commands the same.

    Parameters
    ----------
    name
        Name of the behavior.
    command
        Value by channel.

    Returns
    -------
    BehaviorCandidate
        The candidate, to segment drives with.

    Raises
    ------
    DefinitionError
        If the name is no name of a behavior, or stands for ticks that nothing explains.
    """
    if name == UNEXPLAINED or not name.isidentifier():
        raise DefinitionError(
            what=f"behavior {name!r}",
            problem="it cannot be called so",
            remedy=f"choose a name of letters, digits and _, other than {UNEXPLAINED!r}",
        )
    return BehaviorCandidate(GroundBehavior(Behavior(name, Command(**command)), Binding()))


def describe_command(channels: Sequence[Channel], command: Mapping[str, float]) -> str:
    """Describe a command, such as "drive 0.6 m/s, turn 0.2 rad/s"; "at rest" if it is empty."""
    units = {each.name: each.unit for each in channels}
    parts = (f"{name} {value:g} {units[name]}".rstrip() for name, value in command.items())
    return ", ".join(parts) or "at rest"
