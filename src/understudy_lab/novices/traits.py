"""The parameters of the novice model, with their sources; fixed before the first run and not changed since.

Ranges are those that the literature gives for people in general, or a choice of ours, marked as chosen, where it has
none for such a task. Each novice's traits are drawn uniformly from them by its seed. `SharedTraits` are the same for
all.
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
"""The range and source of each trait: least, most, source."""

CARRY_S = (5.0, 15.0)
"""The time to put the robot elsewhere, s (chosen)."""
PATIENCE_S = (20.0, 40.0)
"""The time without success after which they put the robot elsewhere, s (chosen)."""
AT_EDGE = 0.3
"""The share of novices who turn the robot while the ball is near the edge, not only once it is lost (chosen)."""
EDGE_PX = (20.0, 40.0)
"""The distance that those novices consider near the edge, px (chosen)."""
MINUTES_S = 300.0
"""The teaching time of each novice, s (paper section 4.2)."""

SITUATIONS = ("ball left", "ball right", "ball lost")
MISTAKES = ("one only", "other side", "either")
UNDERSTOOD = "none"

SUCCESS = 0.5
"""A novice succeeds if the robot gets to the ball in this share of its trials at least, from the automaton alone."""


@dataclass(frozen=True, slots=True)
class SharedTraits:
    """The traits that all novices share (chosen, where no source is named)."""

    spread: float = 0.3
    """The standard deviation of reactions, as a share of their mean (spreads in Luce 1986)."""
    least_s: float = 0.15
    """The shortest reaction time, s."""
    stop_s: float = 0.2
    """A press due within this time cannot be cancelled, s (stop-signal reaction time, Logan and Cowan 1984)."""
    lapse_s: float = 4.0
    """The mean duration of a lapse, s; single ones last 0.5 to 1.5 times as long."""
    emerged_px: float = EMERGED_PX
    """The distance from the edge at which they see the ball as inside the frame while the robot turns, px."""
    other_px: float = OTHER_PX
    """The distance beyond the middle at which they see the ball in the other half of the frame, px."""
    distance_m: float = 2.5
    """The largest distance from the ball at which they put the robot, m; the smallest is 0.4 of it."""
    given_s: float = MINUTES_S


PARAMETERS = (
    *RANGES,
    "at_edge",
    "edge_px",
    "carry_s",
    "patience_s",
    *(each.name for each in fields(SharedTraits)),
)
"""The names of all parameters: those from which traits are drawn, and the shared ones."""


ALIKE = SharedTraits()


def make_shared_traits(scaled: Mapping[str, float]) -> SharedTraits:
    """Return the shared traits, with some of them multiplied by factors."""
    return SharedTraits(**{name: value * scaled.get(name, 1.0) for name, value in asdict(ALIKE).items()})


@dataclass(frozen=True, slots=True)
class Traits:
    """The traits of one novice."""

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
    """Draw the traits of the novice of a seed; `scaled` multiplies some without changing the other draws."""

    def within(name: str, bounds: tuple[float, float], share: float) -> float:
        return (bounds[0] + (bounds[1] - bounds[0]) * share) * scaled.get(name, 1.0)

    draws = np.random.default_rng([seed, 2])
    traits = {
        name: within(name, (least, most), float(draws.random())) for name, (least, most, _) in RANGES.items()
    }
    omitted = draws.random(len(SITUATIONS))
    situations_left = [
        each for each, share in zip(SITUATIONS, omitted.tolist(), strict=True) if share >= traits["left_out"]
    ]
    situations = situations_left or [SITUATIONS[int(np.argmax(omitted))]]
    mistaken, which, left, at_edge, edge, carry, patience = draws.random(7).tolist()
    return Traits(
        reaction_s=traits["reaction_s"],
        slips=min(1.0, traits["slips"]),
        lapses=min(0.9, traits["lapses"]),
        misjudged=traits["misjudged"],
        off_middle_px=traits["off_middle_px"],
        situations=tuple(situations),
        mistake=MISTAKES[int(3 * which)] if mistaken < traits["misunderstood"] else UNDERSTOOD,
        search="left" if left < 0.5 else "right",
        edge_px=within("edge_px", EDGE_PX, edge) if at_edge < AT_EDGE * scaled.get("at_edge", 1.0) else 0.0,
        carry_s=within("carry_s", CARRY_S, carry),
        patience_s=within("patience_s", PATIENCE_S, patience),
    )
