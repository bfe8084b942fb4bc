"""Segmentation: the behavior that explains each tick of a drive best, and how certain that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from understudy.addons.recordings.alternation import (
    DriverFit,
    PredictionStack,
    SwitchRules,
    choose_labels,
    find_answered_states,
    find_shares,
    fit_driver,
    make_lattices,
    measure_drive_fit,
    stack_predictions,
)
from understudy.addons.recordings.candidates import Candidate, CommandModel
from understudy.addons.recordings.driver_model import DriverModel
from understudy.addons.recordings.lattice import find_states
from understudy.addons.recordings.posterior import compute_posteriors
from understudy.addons.recordings.speed_share import make_full_shares, widen_noise
from understudy.addons.recordings.switch_model import SwitchModel, learn_switches
from understudy.errors import DefinitionError
from understudy.model.features import BoundFeature
from understudy.records.join_records import join_records
from understudy.records.record import Episode, Floats, Ints, Record, sample_record

UNEXPLAINED = "unexplained"
"""The label of ticks whose commands no candidate explains."""
PRICE = 6.0
SHORTEST_S = 0.25
MOST_TICKS = 8000
"""The number of ticks, spread over the drive, from which the driver is estimated."""
SHARE_ROUNDS, SAME_SHARE = 4, 0.01
"""How often labels and speeds of the episodes are found in turn, and the change of a share that ends it."""
STARTS = 16
"""The number of starts from which unknown constants are looked for; the likeliest outcome counts."""


@dataclass(frozen=True, slots=True)
class SegmentOptions:
    """The settings of a segmentation.

    Parameters
    ----------
    price
        Price of a switch, as the logarithm of a likelihood ratio: by how much the commands must fit better for one.
    shortest_s
        Shortest stay in a behavior, s; at least one tick.
    """

    price: float = PRICE
    shortest_s: float = SHORTEST_S


@dataclass(frozen=True, slots=True)
class Span:
    """Ticks in a row with one label, from `first` to before `end`; `certainty` is the mean over its ticks."""

    label: str
    first: int
    end: int
    certainty: float


@dataclass(frozen=True, slots=True)
class Segmentation:
    """The labels of a drive.

    Parameters
    ----------
    drive
        The drive.
    candidates
        The candidates, with the constants that were found.
    labels
        Index of the candidate that explains each tick, shape [T]; the number of candidates where none does.
    posteriors
        Probability of each candidate at each tick, and of none, shape [T, K + 1].
    driver
        The driver as estimated from the drive.
    likelihood
        Logarithm of the likelihood of the labels, less the price of the switches.
    switches
        The chances of switches, if features were given that they may depend on.
    """

    drive: Record
    candidates: tuple[Candidate, ...]
    labels: Ints
    posteriors: Floats
    driver: DriverModel
    likelihood: float
    switches: SwitchModel | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the labels: those of the candidates, then `UNEXPLAINED`."""
        return (*(each.name for each in self.candidates), UNEXPLAINED)

    @property
    def certainties(self) -> Floats:
        """The probability of the label of each tick, shape [T]."""
        return self.list_certainties(0, len(self.labels))

    def list_certainties(self, first: int, end: int) -> Floats:
        """List the certainties of some ticks only, which for a few takes less time than those of all.

        Parameters
        ----------
        first
            The first tick.
        end
            The tick after the last one.

        Returns
        -------
        array, shape [end - first]
            The probability of the label of each of these ticks.
        """
        return self.posteriors[np.arange(first, end), self.labels[first:end]]

    def list_spans(self, episode: Episode) -> list[Span]:
        """List the spans of an episode in order.

        Parameters
        ----------
        episode
            An episode of the drive.

        Returns
        -------
        list
            The spans.
        """
        labels, certainties = self.labels, self.certainties
        return [
            Span(self.names[labels[first]], first, end, float(certainties[first:end].mean()))
            for first, end in episode.list_runs(labels)
        ]


def segment(
    recording: Record | Sequence[Record],
    candidates: Sequence[Candidate],
    *,
    features: Sequence[BoundFeature] = (),
    options: SegmentOptions | None = None,
) -> Segmentation:
    """Find the behavior that explains each tick of a drive best.

    Labels and the driver's gain and noise and unknown constants are estimated in turn until labels stay as they are.

    Parameters
    ----------
    recording
        The drive, or several of one driver with one robot.
    candidates
        The behaviors that may explain it.
    features
        What the driver's decisions may depend on. Then when to switch is learned from all of the drive, and tells
        behaviors apart that command the same for a while. None: each switch costs the same.
    options
        The price of a switch, and the shortest stay. None: the defaults.

    Returns
    -------
    Segmentation
        Label and certainty of each tick, and the driver as estimated.

    Raises
    ------
    DefinitionError
        If there is no candidate, two have one name, or the recordings do not fit each other.
    """
    drive = recording if isinstance(recording, Record) else join_records(recording)
    names = [each.name for each in candidates]
    if not names or len(set(names)) < len(names):
        problem = "there are none" if not names else f"two are called {max(names, key=names.count)!r}"
        raise DefinitionError(
            what="candidates", problem=problem, remedy="give behaviors with names of their own"
        )
    chosen = options or SegmentOptions()
    rules = SwitchRules(chosen.price, max(1, round(chosen.shortest_s / drive.tick_s)))
    sample = sample_record(drive, most=MOST_TICKS)
    fitted = _fit(sample, candidates, rules)
    driver, switches = fitted.driver, None
    if features:
        stack = stack_predictions(sample, fitted.candidates)
        fit = measure_drive_fit(sample, stack, driver, fitted.shares)
        switches = learn_switches(sample, choose_labels(fit, stack), features)
    return label_drive(drive, fitted.candidates, driver, switches=switches, options=chosen)


def list_unknown(candidates: Sequence[Candidate]) -> dict[str, tuple[float, float]]:
    """List the ranges of the constants of candidates that are to be found."""
    models = [each for each in candidates if isinstance(each, CommandModel)]
    return {name: span for each in models for name, span in each.unknown.items()}


def _fit(drive: Record, candidates: Sequence[Candidate], rules: SwitchRules) -> DriverFit:
    """Estimate the driver and unknown constants, from several starts if there are any."""
    ranges = list_unknown(candidates)
    if not ranges:
        return fit_driver(drive, candidates, rules)
    random, outcomes = np.random.default_rng(0), []
    for _ in range(STARTS):
        drawn = {name: float(random.uniform(*span)) for name, span in ranges.items()}
        start = [
            each.with_constants(drawn) if isinstance(each, CommandModel) else each for each in candidates
        ]
        outcomes.append(fit_driver(drive, start, rules, width=0.5))
    return max(outcomes, key=lambda each: each.likelihood)


def label_drive(
    drive: Record,
    candidates: Sequence[Candidate],
    driver: DriverModel,
    *,
    switches: SwitchModel | None = None,
    options: SegmentOptions | None = None,
) -> Segmentation:
    """Label a drive by a driver that is known, such as from another drive.

    Parameters
    ----------
    drive
        The drive.
    candidates
        The candidates; their constants stay as they are.
    driver
        The driver.
    switches
        The chances of switches. None: each costs the same.
    options
        The price of a switch, and the shortest stay. None: the defaults.

    Returns
    -------
    Segmentation
        Label and certainty of each tick.
    """
    chosen = options or SegmentOptions()
    rules = SwitchRules(chosen.price, max(1, round(chosen.shortest_s / drive.tick_s)))
    stack = stack_predictions(drive, candidates)
    chances = None if switches is None else switches.predict(drive)
    shares = make_full_shares(drive)
    if not list_unknown(candidates) and not stack.follows_last.all():
        shares = _find_speeds(drive, stack, driver, rules, chances)
    fit = measure_drive_fit(drive, stack, driver, shares)
    lattices = make_lattices(drive, stack, fit, rules, chances)
    states = np.concatenate([find_states(each) for each in lattices])
    labels = stack.labels[states]
    switched = sum(np.count_nonzero(np.diff(labels[each.ticks])) for each in drive.episodes)
    likelihood = float(fit[np.arange(drive.ticks), states].sum()) - chosen.price * switched
    posteriors = np.concatenate([compute_posteriors(each) for each in lattices])
    return Segmentation(drive, tuple(candidates), labels, posteriors, driver, likelihood, switches)


def _find_speeds(
    drive: Record,
    stack: PredictionStack,
    driver: DriverModel,
    rules: SwitchRules,
    chances: Floats | None,
) -> Floats:
    """Find the shares [T, C] of full speed and the labels in turn, at first with much noise."""
    shares, judged = make_full_shares(drive), widen_noise(driver)
    for _ in range(SHARE_ROUNDS):
        fit = measure_drive_fit(drive, stack, judged, shares)
        lattices = make_lattices(drive, stack, fit, rules, chances)
        states = np.concatenate([find_states(each) for each in lattices])
        answered = find_answered_states(fit, stack.labels, states)
        former, shares = shares, find_shares(drive, stack, driver, answered)
        if judged is driver and np.allclose(former, shares, atol=SAME_SHARE):
            break
        judged = driver
    return shares
