"""The most likely labels and their certainties, against all ways to label a short episode."""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.addons.recordings.lattice import Lattice, find_states
from understudy.addons.recordings.posterior import compute_posteriors
from understudy.records.record import Floats


def make_plain_lattice(fit: Floats, *, price: float, shortest: int) -> Lattice:
    """The lattice of labels that have one state each, from their fit [T, K]."""
    every = np.arange(fit.shape[1])
    return Lattice(fit, every, np.broadcast_to(every, fit.shape), None, price, shortest)


def make_lattice(seed: int, *, states: bool, moves: bool) -> Lattice:
    """A random episode, whose labels have one state each or several, and whose switches cost alike or not."""
    random = np.random.default_rng(seed)
    ticks, count, shortest = (int(random.integers(1, most)) for most in (8, 4, 4))
    labels = np.arange(count)
    if states:
        labels = np.sort(np.concatenate([labels, random.integers(0, count, 2)]))
    members = [np.flatnonzero(labels == label) for label in range(count)]
    entry = np.array([[random.choice(each) for each in members] for _ in range(ticks)])
    following = np.array([[random.choice(members[label]) for label in labels] for _ in range(ticks)])
    fit = 2 * random.normal(size=(ticks, len(labels)))
    gains = random.normal(size=(ticks, count, count)) if moves else None
    price = random.uniform(0, 3, count) if seed % 2 else float(random.uniform(0, 3))
    return Lattice(fit, labels, entry, following if states else None, price, shortest, gains)


def list_labelings(lattice: Lattice) -> dict[tuple[int, ...], tuple[float, list[int]]]:
    """Each way to label the episode, with its score and states; only its first and last stay may be short."""
    ticks, count = lattice.entry.shape
    found = {}
    for labels in product(range(count), repeat=ticks):
        edges = [0, *(tick for tick in range(1, ticks) if labels[tick] != labels[tick - 1]), ticks]
        if any(end - first < lattice.shortest for first, end in list(pairwise(edges))[1:-1]):
            continue
        prices = np.broadcast_to(lattice.price, count)
        score, states = -sum(float(prices[labels[tick]]) for tick in edges[1:-1]), []
        if lattice.moves is not None:
            score += sum(float(lattice.moves[tick, labels[tick - 1], labels[tick]]) for tick in edges[1:-1])
        for first, end in pairwise(edges):
            state = int(lattice.entry[first, labels[first]])
            for tick in range(first, end):
                if tick > first and lattice.following is not None:
                    state = int(lattice.following[tick, state])
                states.append(state)
                score += float(lattice.fit[tick, state])
        found[labels] = score, states
    return found


@given(st.integers(0, 2**32), st.booleans(), st.booleans())
def test_labels_are_the_likeliest_of_all(seed: int, states: bool, moves: bool) -> None:
    lattice = make_lattice(seed, states=states, moves=moves)
    assert find_states(lattice).tolist() == max(list_labelings(lattice).values())[1]


@given(st.integers(0, 2**32), st.booleans(), st.booleans())
def test_certainties_are_those_of_all_labelings(seed: int, states: bool, moves: bool) -> None:
    lattice = make_lattice(seed, states=states, moves=moves)
    every = list_labelings(lattice)
    total = np.logaddexp.reduce([score for score, _ in every.values()])
    expected = np.zeros(lattice.entry.shape)
    for labels, (score, _) in every.items():
        expected[np.arange(len(labels)), labels] += np.exp(score - total)
    np.testing.assert_allclose(compute_posteriors(lattice), expected, atol=1e-9)


GLITCH = [0] * 6 + [1] * 2 + [0] * 6


@pytest.mark.parametrize(("shortest", "expected"), [(1, GLITCH), (2, GLITCH), (3, [0] * 14)])
def test_a_stay_is_never_too_short(shortest: int, expected: list[int]) -> None:
    fit = np.where(np.arange(2) == np.array(GLITCH)[:, None], 0.0, -3.0)
    assert find_states(make_plain_lattice(fit, price=1.8, shortest=shortest)).tolist() == expected
