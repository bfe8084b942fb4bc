"""Alternation between labels and what they depend on: the driver's reaction and noise, and unknown constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.candidates import Candidate, CommandModel
from understudy.addons.recordings.driver_model import (
    DriverModel,
    estimate_gain,
    estimate_noise,
    guess_driver,
    guess_still_driver,
)
from understudy.addons.recordings.lattice import Lattice, find_states
from understudy.addons.recordings.speed_share import estimate_shares, make_full_shares, scale_aims
from understudy.records.record import Episode, Floats, Ints, Record

MOST_ROUNDS = 15
STEPS = (-1.0, -0.5, -0.25, -0.1, -0.03, 0.0, 0.03, 0.1, 0.25, 0.5, 1.0)
"""The changes of a constant that are tried, as shares of the range that is still searched."""
NARROWER = 0.75
"""The factor by which the range that is searched for a constant shrinks from one round to the next."""

UNEXPLAINED_PRICE = 6.0
"""The price of a switch to the label for none of the candidates, beside that of any switch.

What is not known is rarer than what is known, and takes longer than the two ticks in which a stick overshoots.
"""
MISTIMED = 0.05
"""The share of ticks at which a driver does what another state of the same automaton does: earlier or later than it."""

LEARNED_PRICE = 2.0
"""The price of a switch in addition to its probability, if that was learned from few switches."""


@dataclass(frozen=True, slots=True)
class SwitchRules:
    """The price of a switch, and the fewest ticks of a stay."""

    price: float
    shortest: int


@dataclass(frozen=True, slots=True)
class PredictionStack:
    """The predictions of all candidates: X states of K candidates, and a last state and label for none of them.

    Parameters
    ----------
    commands
        Commands in each state, shape [X, T, C].
    labels
        Label of each state, shape [X + 1].
    follows_last
        Which states give commands rather than aims, shape [X].
    entry
        State in which each label begins at each tick, shape [T, K + 1].
    following
        State after each state, shape [T, X + 1]. None: states never change.
    """

    commands: Floats
    labels: Ints
    follows_last: NDArray[np.bool_]
    entry: Ints
    following: Ints | None


def stack_predictions(drive: Record, candidates: Sequence[Candidate]) -> PredictionStack:
    """Predict the commands of all candidates, and number their states."""
    predictions = [each.predict(drive) for each in candidates]
    counts = [len(each.commands) for each in predictions]
    firsts, states = np.cumsum([0, *counts]), sum(counts) + 1
    entry = np.empty((drive.ticks, len(candidates) + 1), np.int64)
    entry[:, -1] = states - 1
    plain = all(each.following is None for each in predictions)
    following = None if plain else np.tile(np.arange(states), (drive.ticks, 1))
    for label, (each, first) in enumerate(zip(predictions, firsts.tolist(), strict=False)):
        entry[:, label] = first + (0 if each.entry is None else each.entry)
        if following is not None and each.following is not None:
            following[:, first : first + counts[label]] = first + each.following
    return PredictionStack(
        np.concatenate([each.commands for each in predictions]),
        np.repeat(np.arange(len(candidates) + 1), [*counts, 1]),
        np.repeat([each.follows_last for each in candidates], counts),
        entry,
        following,
    )


def measure_residuals(drive: Record, stack: PredictionStack, driver: DriverModel, shares: Floats) -> Floats:
    """Return the difference of the commands from those expected in each state, shape [X, T, C].

    Aims are scaled by the shares [T, C] of full speed. A driver with a dead time responds to a tick that much later;
    answers after the end of an episode are NaN.
    """
    last, commands = drive.list_last_commands(), drive.commands
    if driver.dead_ticks and not stack.follows_last.all():
        last_answer, answer = (
            shift_ticks(each, driver.dead_ticks, drive.episodes) for each in (last, commands)
        )
    else:
        last_answer, answer = last, commands
    residuals = np.empty(stack.commands.shape)
    for state, aims in enumerate(stack.commands):
        if stack.follows_last[state]:
            residuals[state] = commands - aims
        else:
            scaled = scale_aims(drive, aims, shares)
            residuals[state] = answer - driver.expect_commands(scaled, last_answer)
    return residuals


def shift_ticks(columns: Floats, ticks: int, episodes: Sequence[Episode]) -> Floats:
    """Return columns [T, C] as they are some ticks later.

    Parameters
    ----------
    columns
        Columns over the ticks of a drive, shape [T, C].
    ticks
        The number of ticks.
    episodes
        The episodes of the drive.

    Returns
    -------
    array, shape [T, C]
        The columns; NaN beyond the end of an episode.
    """
    shifted = np.full(columns.shape, np.nan)
    for each in episodes:
        if each.end - each.first > ticks:
            shifted[each.first : each.end - ticks] = columns[each.first + ticks : each.end]
    return shifted


def measure_fit(drive: Record, driver: DriverModel, residuals: Floats) -> Floats:
    """Return the fit [T, X + 1] of each tick in each state, the last of which stands for no candidate."""
    states, ticks, _ = residuals.shape
    fit = np.empty((ticks, states + 1))
    fit[:, :states] = driver.measure_fit(residuals).T
    rest = np.array([channel.rest for channel in drive.channels])
    fit[:, states] = driver.measure_unexplained_fit(drive.commands - rest)
    return fit


def allow_mistimed(fit: Floats, labels: Ints) -> Floats:
    """Return the fit [T, X + 1] where drivers may do what another state of the same label does.

    An automaton as a candidate switches a little earlier or later than the driver. Until the other has switched, too,
    they do not do the same.
    """
    allowed = fit.copy()
    for label in np.unique(labels):
        states = labels == label
        if states.sum() > 1:
            best = fit[:, states].max(axis=1, keepdims=True)
            allowed[:, states] = np.logaddexp(np.log1p(-MISTIMED) + fit[:, states], np.log(MISTIMED) + best)
    return allowed


def find_answered_states(fit: Floats, labels: Ints, states: Ints) -> Ints:
    """Return the states [T] that commands answer to, where drivers are mistimed; `fit` allows for it."""
    answered, best = states.copy(), np.empty(len(states))
    for label in np.unique(labels):
        alike, ticks = np.flatnonzero(labels == label), np.flatnonzero(labels[states] == label)
        choices = fit[np.ix_(ticks, alike)]
        answered[ticks], best[ticks] = alike[choices.argmax(axis=1)], choices.max(axis=1)
    # There, the driver more probably does what the better state does than what the present one does.
    mistimed = fit[np.arange(len(states)), states] < best + np.log(2 * MISTIMED)
    return np.where(mistimed, answered, states)


def measure_drive_fit(drive: Record, stack: PredictionStack, driver: DriverModel, shares: Floats) -> Floats:
    """Measure the fit [T, X + 1] of a drive; ticks whose answer the end of an episode cuts off fit all states alike."""
    fit = measure_fit(drive, driver, measure_residuals(drive, stack, driver, shares))
    fit = allow_mistimed(fit, stack.labels)
    if driver.dead_ticks and not stack.follows_last.all():
        for each in drive.episodes:
            fit[max(each.first, each.end - driver.dead_ticks) : each.end] = 0.0
    return fit


def choose_labels(fit: Floats, stack: PredictionStack) -> Floats:
    """Return the fit [T, K] of each candidate: that of the state that fits best."""
    count = int(stack.labels[-1])
    return np.column_stack([fit[:, stack.labels == label].max(axis=1) for label in range(count)])


def make_lattices(
    drive: Record,
    stack: PredictionStack,
    fit: Floats,
    rules: SwitchRules,
    chances: Floats | None = None,
) -> list[Lattice]:
    """Make the lattice of each episode.

    Parameters
    ----------
    drive
        The drive.
    stack
        The predictions of the candidates.
    fit
        Fit of each tick in each state, shape [T, X + 1].
    rules
        The price of a switch, also to and from the label for none of the candidates, and the shortest stay.
    chances
        Logarithm of the chance of each next candidate after each, shape [T, K, K], instead of the price. None: unknown.

    Returns
    -------
    list
        A lattice for each episode.
    """
    moves = None
    if chances is not None:
        count = chances.shape[1]
        stays = np.zeros((drive.ticks, count + 1))
        stays[:, :count] = np.diagonal(chances, axis1=1, axis2=2)
        moves = np.full((drive.ticks, count + 1, count + 1), -rules.price)
        moves[:, :count, :count] = chances
        moves -= stays[:, None, :]
        stays[[each.first for each in drive.episodes]] = 0.0
        fit = fit + stays[:, stack.labels]
        rules = replace(rules, price=LEARNED_PRICE)
    prices = np.append(np.full(int(stack.labels[-1]), rules.price), rules.price + UNEXPLAINED_PRICE)
    return [
        Lattice(
            fit[each.ticks],
            stack.labels,
            stack.entry[each.ticks],
            None if stack.following is None else stack.following[each.ticks],
            prices,
            rules.shortest,
            None if moves is None else moves[each.ticks],
        )
        for each in drive.episodes
    ]


@dataclass(frozen=True, slots=True)
class DriverFit:
    """Candidates with their constants, the driver, the states that follow, and their likelihood less the prices.

    `shares` [T, C] are those of full speed.
    """

    candidates: tuple[Candidate, ...]
    driver: DriverModel
    shares: Floats
    states: Ints
    likelihood: float


def fit_driver(
    drive: Record, candidates: Sequence[Candidate], rules: SwitchRules, *, width: float = 0.0
) -> DriverFit:
    """Alternate between the labels of a drive and the driver until the labels stay as they are.

    Parameters
    ----------
    drive
        The drive.
    candidates
        The candidates, whose unknown constants begin at the values that they have.
    rules
        The price of a switch, and the fewest ticks of a stay.
    width
        How far unknown constants are looked for at first, as a share of their ranges. 0: they stay as they are.

    Returns
    -------
    DriverFit
        Candidates, driver and states of the last round.
    """
    stack = stack_predictions(drive, candidates)
    fitted = _alternate(drive, candidates, rules, guess_driver(drive.commands, stack.commands), width)
    if drive.ticks > 1 and (stack.labels[fitted.states] == stack.labels[-1]).all():
        # Stays of a few ticks are not worth their switches for a driver with much noise. This one has little.
        return _alternate(drive, candidates, rules, guess_still_driver(drive.commands), width)
    return fitted


def _alternate(
    drive: Record,
    candidates: Sequence[Candidate],
    rules: SwitchRules,
    driver: DriverModel,
    width: float,
) -> DriverFit:
    """Alternate between the labels and the driver, from a first guess of the driver."""
    fitted = tuple(candidates)
    stack = stack_predictions(drive, fitted)
    shares = make_full_shares(drive)
    fit, states, former = np.zeros((0, 0)), np.zeros(0, np.int64), np.zeros(0, np.int64)
    for turn in range(MOST_ROUNDS):
        residuals = measure_residuals(drive, stack, driver, shares)
        fit = allow_mistimed(measure_fit(drive, driver, residuals), stack.labels)
        states = np.concatenate([find_states(each) for each in make_lattices(drive, stack, fit, rules)])
        settled = np.array_equal(states, former)
        if settled and width * NARROWER**turn < 1e-3:
            break
        former = states
        answered = find_answered_states(fit, stack.labels, states)
        if width:
            labels = stack.labels[states]
            fitted = find_constants(drive, fitted, labels, driver, width * NARROWER**turn)
            stack = stack_predictions(drive, fitted)
        else:  # constants that are looked for already say how fast
            shares = find_shares(drive, stack, driver, answered)
        driver = _estimate_driver(drive, stack, driver, answered, shares)
    likelihood = float(fit[np.arange(drive.ticks), states].sum())
    labels = stack.labels[states]
    switches = sum(np.count_nonzero(np.diff(labels[each.ticks])) for each in drive.episodes)
    return DriverFit(fitted, driver, shares, states, likelihood - rules.price * switches)


def find_shares(drive: Record, stack: PredictionStack, driver: DriverModel, states: Ints) -> Floats:
    """Estimate the shares [T, C] of full speed from ticks whose states are known."""
    aimed, aims, answers = _list_answers(drive, stack, driver, states)
    return estimate_shares(drive, driver, aimed, aims, answers) if len(aimed) else make_full_shares(drive)


def _list_answers(
    drive: Record, stack: PredictionStack, driver: DriverModel, states: Ints
) -> tuple[Ints, Floats, tuple[Floats, Floats]]:
    """List the ticks with known aims, these aims, and the commands before the driver's answers and the answers."""
    explained = np.flatnonzero(states < len(stack.commands))
    aimed = explained[~stack.follows_last[states[explained]]]
    last = shift_ticks(drive.list_last_commands(), driver.dead_ticks, drive.episodes)
    answer = shift_ticks(drive.commands, driver.dead_ticks, drive.episodes)
    return aimed, stack.commands[states[aimed], aimed], (last[aimed], answer[aimed])


def _estimate_driver(
    drive: Record, stack: PredictionStack, driver: DriverModel, states: Ints, shares: Floats
) -> DriverModel:
    """Estimate gain and noise from ticks whose states are known."""
    aimed, aims, (last, answer) = _list_answers(drive, stack, driver, states)
    if len(aimed):
        scaled = scale_aims(drive, aims, shares[aimed])
        driver = replace(driver, gain=estimate_gain(driver, scaled, last, answer))
    explained = np.flatnonzero(states < len(stack.commands))
    residuals = measure_residuals(drive, stack, driver, shares)[states[explained], explained]
    return replace(driver, noise=estimate_noise(driver, residuals))


def find_constants(
    drive: Record, candidates: Sequence[Candidate], labels: Ints, driver: DriverModel, width: float
) -> tuple[Candidate, ...]:
    """Change unknown constants, one after the other, to the values with which known labels fit best.

    Parameters
    ----------
    drive
        The drive.
    candidates
        The candidates.
    labels
        Label of each tick, shape [T].
    driver
        The driver's noise.
    width
        How far from its value a constant is looked for, as a share of its range.

    Returns
    -------
    tuple
        The candidates with their constants changed.
    """
    fitted = list(candidates)
    models = {index: each for index, each in enumerate(fitted) if isinstance(each, CommandModel)}
    ranges = {name: span for each in models.values() for name, span in each.unknown.items()}
    for name, (low, high) in ranges.items():
        users = [index for index, each in models.items() if name in each.constants]
        used = {index: np.flatnonzero(labels == index) for index in users}
        if not any(map(len, used.values())):
            continue
        middle = models[users[0]].constants[name]
        values = np.unique(np.clip(middle + width * (high - low) * np.array(STEPS), low, high)).tolist()
        fits = []
        for value in values:
            total = 0.0
            for index in users:
                model = models[index].with_constants({name: value})
                residuals = drive.commands - model.predict(drive).commands[0]
                total += float(driver.measure_fit(residuals[used[index]]).sum())
            fits.append(total)
        best = values[int(np.argmax(fits))] if max(fits) > min(fits) else middle
        for index in users:
            fitted[index] = models[index] = models[index].with_constants({name: best})
    return tuple(fitted)
