"""What makes novices differ, and where it comes from. Committed before the first was run; no value was touched since.

Ranges are what the literature says of people in general, or, where it says nothing of such a task, a plain choice that
is called so. Each novice's traits are drawn evenly from them, by its seed. What all have alike is among `SharedTraits`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from types import MappingProxyType

import numpy as np

from understudy_lab.tasks.servo_teacher import EMERGED_PX, OTHER_PX

RANGES: Mapping[str, tuple[float, float, str]] = MappingProxyType(
    {
        "reaction_s": (
            0.3,
            0.7,
            "Mean time from seeing that something is to be done to the press. A simple reaction takes 0.24 s (0.1 to "
            "0.47; Card, Moran and Newell 1983), and each doubling of the alternatives adds about 0.15 s (Hick 1952): "
            "0.5 s for four or five buttons.",
        ),
        "slips": (
            0.01,
            0.06,
            "Chance that a press hits another button: a few percent of choices in reaction experiments are wrong "
            "(Luce 1986); people new to it slip no less (slips as in Reason 1990).",
        ),
        "lapses": (
            0.05,
            0.3,
            "Share of the time in which they do not look. Thoughts wander in 15 to 50 % of samples while reading "
            "(Smallwood and Schooler 2006) and in 47 % in daily life (Killingsworth and Gilbert 2010); in a short task "
            "with something to do, less.",
        ),
        "misjudged": (
            -0.3,
            0.6,
            "By which share they misjudge how near the robot must be to be there (chosen: told `very near`).",
        ),
        "left_out": (
            0.0,
            0.4,
            "Chance of each of the situations `ball left`, `ball right` and `ball lost` not to occur to them as one to "
            "put the robot into (chosen; one at least does).",
        ),
        "off_middle_px": (
            -20.0,
            20.0,
            "Where they see the middle of a frame of 160 px, off from where it is (chosen).",
        ),
        "misunderstood": (
            0.2,
            0.2,
            "Chance of a mistake (Reason 1990) about forwardL and forwardR, which they were given `some suggestions` "
            "on: using one of them only, or each for the other side, or either, whichever comes to mind (chosen; "
            "a third each).",
        ),
    }
)
"""By trait: least, most, source."""

CARRY_S = (5.0, 15.0)
"""How long it takes to put the robot elsewhere, s (chosen)."""
PATIENCE_S = (20.0, 40.0)
"""After so long without getting there they put the robot elsewhere, s (chosen)."""
AT_EDGE = 0.3
"""How many turn the robot while the ball is near the edge already, not only once it is lost (chosen)."""
EDGE_PX = (20.0, 40.0)
"""What is near the edge to these, px (chosen)."""
MINUTES_S = 300.0
"""What each was given (paper section 4.2)."""

SITUATIONS = ("ball left", "ball right", "ball lost")
MISTAKES = ("one only", "other side", "either")
UNDERSTOOD = "none"

SUCCESS = 0.5
"""A novice succeeds if the robot gets to the ball in this share of its trials at least, from the automaton alone."""


@dataclass(frozen=True, slots=True)
class SharedTraits:
    """What all novices have alike (chosen, where no source is said)."""

    spread: float = 0.3
    """The standard deviation of reactions, as a share of their mean (spreads in Luce 1986)."""
    least_s: float = 0.15
    """No reaction is faster."""
    stop_s: float = 0.2
    """A press due within so long cannot be held back any more (stop-signal reaction time, Logan and Cowan 1984)."""
    lapse_s: float = 4.0
    """How long a lapse lasts on average: from half of that to half as much again."""
    emerged_px: float = EMERGED_PX
    """So far from the edge the ball has come into the frame, to them, while the robot turns."""
    other_px: float = OTHER_PX
    """So far beyond the middle it is plainly in the other part of the frame."""
    distance_m: float = 2.5
    """They put the robot so far from the ball at most, and 0.4 of it at least."""
    given_s: float = MINUTES_S


PARAMETERS = (
    *RANGES,
    "at_edge",
    "edge_px",
    "carry_s",
    "patience_s",
    *(each.name for each in fields(SharedTraits)),
)
"""All parameters of the model: those that each novice's traits are drawn with, and what all have alike."""


ALIKE = SharedTraits()


def make_shared_traits(scaled: Mapping[str, float]) -> SharedTraits:
    """What all novices have alike, some of it multiplied."""
    return SharedTraits(**{name: value * scaled.get(name, 1.0) for name, value in asdict(ALIKE).items()})


@dataclass(frozen=True, slots=True)
class Traits:
    """One novice."""

    reaction_s: float
    slips: float
    lapses: float
    misjudged: float
    off_middle_px: float
    situations: tuple[str, ...]
    mistake: str
    search: str
    edge_px: float  # 0: they turn only once the ball is lost
    carry_s: float
    patience_s: float


def draw_traits(seed: int, *, scaled: Mapping[str, float] = MappingProxyType({})) -> Traits:
    """The traits of the novice of a seed; `scaled` multiplies some of them, and draws nothing else anew."""

    def within(name: str, bounds: tuple[float, float], share: float) -> float:
        return (bounds[0] + (bounds[1] - bounds[0]) * share) * scaled.get(name, 1.0)

    draws = np.random.default_rng([seed, 2])
    found = {
        name: within(name, (least, most), float(draws.random())) for name, (least, most, _) in RANGES.items()
    }
    omitted = draws.random(len(SITUATIONS))
    kept = [
        each for each, share in zip(SITUATIONS, omitted.tolist(), strict=True) if share >= found["left_out"]
    ]
    situations = kept or [SITUATIONS[int(np.argmax(omitted))]]
    mistaken, which, left, at_edge, edge, carry, patience = draws.random(7).tolist()
    return Traits(
        reaction_s=found["reaction_s"],
        slips=min(1.0, found["slips"]),
        lapses=min(0.9, found["lapses"]),
        misjudged=found["misjudged"],
        off_middle_px=found["off_middle_px"],
        situations=tuple(situations),
        mistake=MISTAKES[int(3 * which)] if mistaken < found["misunderstood"] else UNDERSTOOD,
        search="left" if left < 0.5 else "right",
        edge_px=within("edge_px", EDGE_PX, edge) if at_edge < AT_EDGE * scaled.get("at_edge", 1.0) else 0.0,
        carry_s=within("carry_s", CARRY_S, carry),
        patience_s=within("patience_s", PATIENCE_S, patience),
    )
