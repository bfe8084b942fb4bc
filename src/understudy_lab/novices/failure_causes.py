"""The criteria of a novice's success, and the traits and actions in which those who fail differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isnan, nan
from typing import Any

from understudy.judging.intervals import interval_of_share
from understudy.model.automaton import START
from understudy.model.lesson import ExampleKind
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import STAY
from understudy_lab.novices.novice import SUCCESS, UNDERSTOOD
from understudy_lab.rows import Count, Rows
from understudy_lab.statistics import (
    apply_holm_correction,
    compute_unpaired_p,
    format_median,
    shares_differ,
)
from understudy_lab.study import ResultTable, Row
from understudy_lab.tasks.soccer import POSITIONS
from understudy_lab.teachers.live_teacher import LIVE

TRIALS = 10
"""The number of trials from each of the paper's three positions."""


def has_succeeded(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least half of all its trials."""
    return bool(row["reached"] >= SUCCESS * TRIALS * len(POSITIONS))


def succeeds_everywhere(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least half of the trials from each position."""
    return all(reaches(row, position) for position in POSITIONS)


def reaches(row: Row, position: str) -> bool:
    """Return whether the robot reaches the ball in at least half of the trials from one position."""
    return len(times(row, position)) >= SUCCESS * TRIALS


def times(row: Row, position: str) -> list[float]:
    """Return the seconds of the successful trials from one position."""
    return [each for each in row["times"][position] if each is not None and each == each]


def succeeds_nearly_always(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least 90 % of all its trials."""
    return bool(row["reached"] >= 0.9 * TRIALS * len(POSITIONS))


def select_unchanged(rows: Sequence[Row]) -> Rows:
    """Return the rows of the paper's training without a changed parameter."""
    return Rows(rows).where(trait=None, method=None)


def select_live(rows: Sequence[Row]) -> Rows:
    """Return the rows of live teaching."""
    return Rows(rows).where(method=LIVE)


def share(rows: Sequence[Row], well: Callable[[Row], bool] = has_succeeded) -> dict[str, Any]:
    """Return how many novices succeed, with the 95 % interval of the share."""
    count, of = sum(map(well, rows)), len(rows)
    low, high = interval_of_share(count, of)
    return {"succeed": count, "of": of, "low": round(low, 4), "high": round(high, 4)}


def summarize_both_readings(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return `share` by both criteria of success."""
    return {"half": share(rows), "everywhere": share(rows, succeeds_everywhere)}


def format_succeeding(rows: Rows, well: Callable[[Row], bool] = has_succeeded) -> str:
    """Format how many novices succeed, with the 95 % interval of the share."""
    return Count(well, interval=True)(rows) if rows else "none"


TURNS = ("left", "right")
FINDS, SWINGS, WALKS_ON, RESTS = "keeps turning to one side", "swings left and right", "walks on", "rests"


def list_blind_states(taught: TrainedAutomaton) -> list[str]:
    """Return the states that an automaton passes from the start while no ball is visible.

    The last one is the state in which it stays, or the first one that is repeated.
    """
    automaton = taught.automaton
    names, nothing = automaton.state_names, [nan] * len(automaton.features)
    passed = [START.name]
    while True:
        tree = automaton.transitions.get(passed[-1])
        outcome = STAY if tree is None else tree.decide(nothing)
        if outcome == STAY or names[outcome] == passed[-1]:
            return passed
        passed.append(names[outcome])
        if passed[-1] in passed[:-1]:
            return passed


def classify_blind_behavior(states: list[str]) -> str:
    """Return the lasting behavior of a robot that passes these states while no ball is visible."""
    last = states[-1]
    again = set(states[states.index(last) :])
    if again >= set(TURNS):
        return SWINGS
    if again & set(TURNS):
        return FINDS
    return RESTS if last == START.name else WALKS_ON


def count_turn_backs(taught: TrainedAutomaton) -> dict[str, int]:
    """Count for each side how often a turn was changed into the other turn while no ball was visible."""
    lesson = taught.lesson
    presses = [
        (example.state, example.next)
        for example in (() if lesson is None else lesson.examples)
        if example.kind is ExampleKind.DIRECTIVE and all(map(isnan, example.values))
    ]
    left, right = TURNS
    return {left: presses.count((left, right)), right: presses.count((right, left))}


NUMBERS: Mapping[str, tuple[Callable[[Row], float], int]] = {
    "mean reaction, s": (lambda row: row["traits"]["reaction_s"], 2),
    "chance of a slip": (lambda row: row["traits"]["slips"], 3),
    "share of time not looking": (lambda row: row["traits"]["lapses"], 2),
    "error in judging the distance, either way": (lambda row: abs(row["traits"]["misjudged"]), 2),
    "error in judging the middle, either way, px": (lambda row: abs(row["traits"]["off_middle_px"]), 0),
    "time to move the robot elsewhere, s": (lambda row: row["traits"]["carry_s"], 0),
    "patience, s": (lambda row: row["traits"]["patience_s"], 0),
    "situations that occur to them, of 3": (lambda row: len(row["traits"]["situations"]), 0),
    "presses": (lambda row: row["presses"], 0),
    "wrong presses (slips)": (lambda row: row["slipped"], 0),
    "times they placed the robot": (lambda row: sum(row["shown"].values()), 0),
    "times they placed it where no ball is visible": (lambda row: row["shown"].get("ball lost", 0), 0),
    "turns pressed back while no ball is visible": (lambda row: sum(row["turned_back"].values()), 0),
}
"""The quantities that are compared by medians, each with its number of digits."""


def has_turned_back_both_ways(row: Row) -> bool:
    """Return whether each of the two turns was changed into the other one while no ball was visible."""
    return all(row["turned_back"][side] for side in TURNS)


SHARES: Mapping[str, Callable[[Row], bool]] = {
    "misunderstood forwardL and forwardR": lambda row: row["traits"]["mistake"] != UNDERSTOOD,
    "turn at the edge of the frame too": lambda row: bool(row["traits"]["edge_px"]),
    "showed a lost ball": lambda row: "ball lost" in row["traits"]["situations"],
    "pressed back both ways while no ball is visible": has_turned_back_both_ways,
}
"""The properties that are compared by the number of novices who have them."""

READINGS = {"half": has_succeeded, "each": succeeds_everywhere}
Compared = tuple[str, str, float]


def _number(rows: Sequence[Row], what: str, well: Callable[[Row], bool]) -> Compared:
    value, digits = NUMBERS[what]
    good, bad = ([value(row) for row in rows if well(row) is each] for each in (True, False))
    return (
        format_median(good, digits),
        format_median(bad, digits),
        compute_unpaired_p(good, bad) if good and bad else 1.0,
    )


def _share(rows: Sequence[Row], what: str, well: Callable[[Row], bool]) -> Compared:
    good, bad = ([SHARES[what](row) for row in rows if well(row) is each] for each in (True, False))
    return f"{sum(good)} of {len(good)}", f"{sum(bad)} of {len(bad)}", shares_differ(good, bad)


def _compared(novices: Sequence[Row]) -> dict[tuple[str, str], tuple[str, str, float, bool]]:
    """Return each comparison: value of those who succeed, of those who fail, p, and whether it is significant."""
    comparisons = {
        (what, reading): (_number if what in NUMBERS else _share)(novices, what, well)
        for what in (*NUMBERS, *SHARES)
        for reading, well in READINGS.items()
    }
    remain = apply_holm_correction([p for _, _, p in comparisons.values()])
    return {key: (*cells, stays) for (key, cells), stays in zip(comparisons.items(), remain, strict=True)}


def table(novices: Sequence[Row]) -> ResultTable:
    """Return the table of all comparisons by both criteria of success; a star marks those significant after Holm."""
    comparisons = _compared(novices)

    def cells(what: str) -> list[str]:
        of = [comparisons[what, reading] for reading in READINGS]
        return [cell for good, bad, p, stays in of for cell in (good, bad, f"{p:.2g}{' *' if stays else ''}")]

    return ResultTable(
        "Differences between novices who succeed and who fail (half: in half of all trials; each: in half of the trials"
        f" from each position; *: significant at 5 % after Holm's correction for all {len(comparisons)} comparisons)",
        ("", *(f"#{what}" for reading in ("half", "each") for what in (f"{reading}: succeed", "fail", "p"))),
        [(what, *cells(what)) for what in (*NUMBERS, *SHARES)],
    )


def note(novices: Sequence[Row]) -> str:
    """Return a note on the significant differences by both criteria of success."""
    comparisons = _compared(novices)
    remain = {
        reading: ", ".join(
            f"`{what}`" for what, by in comparisons if by == reading and comparisons[what, by][3]
        )
        for reading in READINGS
    }
    failing = [row for row in novices if not has_succeeded(row)]
    back = sum(map(has_turned_back_both_ways, failing))
    return (
        "Significant differences between novices who succeed from each position and the others: "
        f"{remain['each'] or 'none'}. Significant differences between the {len(failing)} who fail in half of all "
        f"trials and the others: {remain['half'] or 'none, because there are too few of them'}; {back} of them pressed "
        "back both ways."
    )
