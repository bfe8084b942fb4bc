"""What separates novices who fail from those who succeed: what they are like, and what they did."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from understudy.experiments.experiment import Row, Table
from understudy.experiments.novices.chances import remaining, shares_differ
from understudy.experiments.novices.success import everywhere, succeeded
from understudy.experiments.novices.traits import UNDERSTOOD
from understudy.experiments.novices.unseen import TURNS
from understudy.experiments.statistics import differ, told

NUMBERS: Mapping[str, tuple[Callable[[Row], float], int]] = {
    "mean reaction, s": (lambda row: row["traits"]["reaction_s"], 2),
    "chance of a slip": (lambda row: row["traits"]["slips"], 3),
    "share of time not looking": (lambda row: row["traits"]["lapses"], 2),
    "misjudged, either way": (lambda row: abs(row["traits"]["misjudged"]), 2),
    "off the middle, either way, px": (lambda row: abs(row["traits"]["off_middle_px"]), 0),
    "putting the robot elsewhere, s": (lambda row: row["traits"]["carry_s"], 0),
    "patience, s": (lambda row: row["traits"]["patience_s"], 0),
    "situations that occur to them, of 3": (lambda row: len(row["traits"]["situations"]), 0),
    "presses": (lambda row: row["presses"], 0),
    "presses that slipped": (lambda row: row["slipped"], 0),
    "times they put the robot somewhere": (lambda row: sum(row["shown"].values()), 0),
    "times that was where the ball is lost": (lambda row: row["shown"].get("ball lost", 0), 0),
    "turns pressed back, nothing seen, times": (lambda row: sum(row["turned_back"].values()), 0),
}
"""What is compared by medians, with so many digits."""


def turned_back_both_ways(row: Row) -> bool:
    """Whether each of the two turns was pressed into the other one while nothing was seen."""
    return all(row["turned_back"][side] for side in TURNS)


SHARES: Mapping[str, Callable[[Row], bool]] = {
    "misunderstood forwardL and forwardR": lambda row: row["traits"]["mistake"] != UNDERSTOOD,
    "turn at the edge of the frame too": lambda row: bool(row["traits"]["edge_px"]),
    "showed a lost ball": lambda row: "ball lost" in row["traits"]["situations"],
    "pressed back both ways, nothing seen": turned_back_both_ways,
}
"""What is compared by how many it is true of."""

Compared = tuple[str, str, float]


def _number(rows: Sequence[Row], what: str, well: Callable[[Row], bool]) -> Compared:
    value, digits = NUMBERS[what]
    good, bad = ([value(row) for row in rows if well(row) is each] for each in (True, False))
    return told(good, digits), told(bad, digits), differ(good, bad) if good and bad else 1.0


def _share(rows: Sequence[Row], what: str, well: Callable[[Row], bool]) -> Compared:
    good, bad = ([SHARES[what](row) for row in rows if well(row) is each] for each in (True, False))
    return f"{sum(good)} of {len(good)}", f"{sum(bad)} of {len(bad)}", shares_differ(good, bad)


def table(novices: Sequence[Row]) -> Table:
    """All comparisons, by either reading of success; those that remain after Holm's correction with a star."""
    every = (*NUMBERS, *SHARES)
    compared = [
        (_number if what in NUMBERS else _share)(novices, what, well)
        for what in every
        for well in (succeeded, everywhere)
    ]
    remain = remaining([p for _, _, p in compared])
    cells = [
        (good, bad, f"{p:.2g}{' *' if stays else ''}")
        for (good, bad, p), stays in zip(compared, remain, strict=True)
    ]
    return Table(
        f"What separates those who fail (* remains after Holm's correction for all {len(cells)} comparisons at 5 %)",
        ("", *(f"#{what}" for reading in ("half", "each") for what in (f"{reading}: succeed", "fail", "p"))),
        [(what, *cells[2 * k], *cells[2 * k + 1]) for k, what in enumerate(every)],
    )
