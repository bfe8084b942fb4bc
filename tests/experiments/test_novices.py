"""Some novices beside what was published; what they are like, and what they press, by hand."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import Any

import pytest
from tests.experiments.test_servoing import seen

from understudy.experiments.novices import run
from understudy.experiments.novices.novice import Novice
from understudy.experiments.novices.traits import MINUTES_S, MISTAKES, RANGES, SITUATIONS, UNDERSTOOD, drawn
from understudy.experiments.published import differences, published
from understudy.experiments.running import row_of
from understudy.worlds.soccer import POSITIONS

TASKS = [{"seed": run.SEEDS[0]}, {"seed": run.SEEDS[1], "trait": "lapses", "factor": 1.5}]


@pytest.mark.parametrize("task", TASKS)
def test_some_are_as_published(task: dict[str, Any]) -> None:
    known = published("novices")
    assert known is not None
    row = row_of(run.EXPERIMENT, task)
    assert differences([row], known, run.EXPERIMENT) == []
    assert known.rows[0]["task"] == TASKS[0]


def test_traits_are_within_their_ranges() -> None:
    all_ = [drawn(seed) for seed in range(300)]
    for name in ("reaction_s", "slips", "lapses", "misjudged", "off_middle_px"):
        least, most, _ = RANGES[name]
        found = [getattr(traits, name) for traits in all_]
        assert least <= min(found) < max(found) <= most
    assert all(traits.situations and set(traits.situations) <= set(SITUATIONS) for traits in all_)
    mistaken = [traits.mistake for traits in all_ if traits.mistake != UNDERSTOOD]
    assert set(mistaken) == set(MISTAKES)
    assert 0.12 < len(mistaken) / len(all_) < 0.28


def test_a_changed_trait_changes_nothing_else() -> None:
    for seed in range(20):
        before, after = drawn(seed), drawn(seed, scaled={"slips": 1.5})
        assert after.slips == pytest.approx(1.5 * before.slips)
        assert replace(after, slips=before.slips) == before


PLAIN = replace(drawn(0), mistake=UNDERSTOOD, edge_px=0.0, off_middle_px=0.0, search="right", misjudged=0.0)
PRESSED = [  # what they misunderstood, the screens they see, what they would have last
    (UNDERSTOOD, [("start", nan)], "right"),
    (UNDERSTOOD, [("start", 20.0)], "forwardL"),
    (UNDERSTOOD, [("start", 20.0), ("forwardL", nan)], "left"),
    (UNDERSTOOD, [("right", 30.0), ("right", nan)], "left"),  # turned past it
    ("other side", [("start", 20.0)], "forwardR"),
    ("one only", [("start", 150.0)], "forwardL"),
]


@pytest.mark.parametrize(("mistake", "screens", "wished"), PRESSED)
def test_what_a_novice_wants(mistake: str, screens: list[tuple[str, float]], wished: str) -> None:
    novice = Novice(replace(PLAIN, mistake=mistake), 0)
    assert [novice.wish(seen(*screen)) for screen in screens][-1] == wished


def test_who_misjudges_thinks_it_is_there_too_early() -> None:
    good, bad = Novice(PLAIN, 0), Novice(replace(PLAIN, misjudged=0.5), 0)
    screen = seen("forwardL", 80.0, 2500.0)
    assert (good.there(screen), bad.there(screen)) == (False, True)


def test_five_minutes_and_no_more() -> None:
    novice = Novice(drawn(1000), 1000)
    assert novice.teach().lesson is not None
    assert novice.seconds == pytest.approx(MINUTES_S, abs=0.2)
    assert novice.presses > 10


def made(left: int, hidden: int, right: int) -> dict[str, Any]:
    """A row in which so many of ten trials from each position reach the ball."""
    times = {
        name: [12.0] * n + [None] * (10 - n) for name, n in zip(POSITIONS, (left, hidden, right), strict=True)
    }
    return {"task": {"seed": 0}, "times": times, "reached": left + hidden + right}


SUCCESSES = [
    ((10, 10, 10), True, True),
    ((10, 0, 5), True, False),
    ((5, 5, 4), False, False),
    ((5, 5, 5), True, True),
]


@pytest.mark.parametrize(("reached", "half", "each"), SUCCESSES)
def test_success(reached: tuple[int, int, int], half: bool, each: bool) -> None:
    assert (run.succeeded(made(*reached)), run.everywhere(made(*reached))) == (half, each)
