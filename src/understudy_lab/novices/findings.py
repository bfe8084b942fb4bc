"""The findings on novices: how many succeed, how fast their robots are, why others fail, effects of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy.analysis.intervals import interval_of_share
from understudy_lab.figures import COLORS, panels
from understudy_lab.novices import failure_causes, sensitivity
from understudy_lab.novices.failure_causes import FINDS, RESTS, SWINGS, WALKS_ON, classify_blind_behavior
from understudy_lab.novices.success import (
    TRIALS,
    format_share,
    has_succeeded,
    reaches,
    select_live,
    select_unchanged,
    share,
    succeeds_everywhere,
    succeeds_nearly_always,
    summarize_both_readings,
    times,
)
from understudy_lab.novices.traits import MISTAKES, SITUATIONS, SUCCESS, UNDERSTOOD
from understudy_lab.statistics import format_median, spread
from understudy_lab.study import ResultTable, Row, StudyFindings, StudyGoal
from understudy_lab.tasks.soccer import POSITIONS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WANTED = 0.7
WANTED_LIVE, FEWER_LIVE = 0.95, 0.5
HIDDEN = "ball not visible"


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize success, times, causes of failure and the effects of the parameters."""
    novices = select_unchanged(rows)
    half, each = share(novices), share(novices, succeeds_everywhere)
    live = select_live(rows)
    medians = _medians([row for row in novices if has_succeeded(row)])
    return StudyFindings(
        headline=f"{half['succeed']} of {half['of']} simulated novices (95 % interval {100 * half['low']:.0f} to "
        f"{100 * half['high']:.0f} %) succeed: within five minutes, and without a test or a correction, they teach a "
        "robot that reaches the ball in at least half of its trials (in the paper: 4 of 5 people). The median time of "
        f"these robots is {np.median(medians):.0f} s. But only {each['succeed']} of {each['of']} novices succeed from "
        "each of the three positions. The other robots do not find a ball that is not visible at the start."
        f"{_headline_live(novices, live)}",
        tables=(
            ResultTable(
                f"Results by start position, {len(novices)} novices",
                (
                    "",
                    "#novices who succeed from there",
                    "#trials that reach the ball",
                    "#time to the ball, s (median of each robot)",
                ),
                [_position(novices, position) for position in POSITIONS],
            ),
            ResultTable(
                "Novices who succeed, by group",
                ("", "#in half of all trials", "#from each position"),
                [
                    (who, *(format_share(found) for found in summarize_both_readings(of).values()))
                    for who, of in _groups(novices)
                ],
            ),
            ResultTable(
                "Behavior of the robots while they see no ball (pressed back both ways: while no ball was visible, the "
                "novice changed a left turn into a right turn at least once, and a right turn into a left turn)",
                (
                    "",
                    "#novices",
                    "#showed a lost ball",
                    "#pressed back both ways",
                    f"#succeed: {HIDDEN}",
                ),
                [_unseeing(novices, what) for what in (FINDS, SWINGS, RESTS, WALKS_ON)],
            ),
            ResultTable(
                "The same novices by method, five minutes each",
                (
                    "",
                    "#reach the ball in 90 % of all trials",
                    "#in half of all trials",
                    "#in half from each position",
                    "#presses",
                ),
                [_method("the paper's training", novices), _method("live teaching", live)],
            ),
            failure_causes.table(novices),
            sensitivity.table(rows),
        ),
        goals=(
            StudyGoal(
                "novices who succeed, from the automaton alone",
                f"{WANTED:.0%}",
                format_share(half),
                half["succeed"] >= WANTED * half["of"],
            ),
            *_live_goals(novices, live),
        ),
        notes=(*_notes(novices), sensitivity.note(rows)),
        numbers={
            "half": half,
            "everywhere": each,
            "live": {
                "nearly always": share(live, succeeds_nearly_always),
                **summarize_both_readings(live),
                "presses": spread([row["presses"] for row in live]),
            },
            "sensitivity": sensitivity.numbers(rows),
            "first": summarize_both_readings(novices[: sensitivity.SENSITIVITY]),
        },
    )


def _headline_live(novices: Sequence[Row], live: Sequence[Row]) -> str:
    if not live:
        return ""
    always = share(live, succeeds_nearly_always)
    before = share(novices, succeeds_nearly_always)["succeed"]
    presses, former = (float(np.median([row["presses"] for row in each])) for each in (live, novices))
    return (
        f" Taught live, robots of {always['succeed']} of {always['of']} novices reach the ball in at least 90 % of all "
        f"trials, instead of {before}, after {presses:.0f} instead of {former:.0f} presses (medians)."
    )


def _method(name: str, rows: Sequence[Row]) -> tuple[str, ...]:
    readings = (succeeds_nearly_always, has_succeeded, succeeds_everywhere)
    counts = (format_share(share(rows, reading)) for reading in readings)
    return (name, *counts, format_median([row["presses"] for row in rows]))


def _live_goals(novices: Sequence[Row], live: Sequence[Row]) -> tuple[StudyGoal, StudyGoal]:
    found = share(live, succeeds_nearly_always)
    presses, before = (float(np.median([row["presses"] for row in each])) for each in (live, novices))
    return (
        StudyGoal(
            "taught live: robots that reach the ball in 90 % of all trials",
            f"{WANTED_LIVE:.0%}",
            format_share(found),
            found["succeed"] >= WANTED_LIVE * found["of"],
        ),
        StudyGoal(
            "taught live: presses of a median novice / those in the paper's training",
            f"at most {FEWER_LIVE}",
            f"{presses / before:.2f} ({presses:.0f} / {before:.0f})",
            presses <= FEWER_LIVE * before,
        ),
    )


def _position(rows: Sequence[Row], position: str) -> tuple[str, str, str, str]:
    good = [row for row in rows if reaches(row, position)]
    low, high = interval_of_share(len(good), len(rows))
    succeed = f"{len(good)} of {len(rows)} ({100 * low:.0f}–{100 * high:.0f} %)"
    reached = f"{sum(len(times(row, position)) for row in rows)} of {TRIALS * len(rows)}"
    return (position, succeed, reached, format_median(_medians(good, [position]), 1))


def _medians(rows: Sequence[Row], positions: Sequence[str] = tuple(POSITIONS)) -> list[float]:
    """Return the median time in s of each robot over its successful trials."""
    found = [[each for position in positions for each in times(row, position)] for row in rows]
    return [float(np.median(each)) for each in found if each]


def _groups(rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """Return the novices by misunderstanding, by situations they never showed, and by when they turn."""
    mistakes = {
        UNDERSTOOD: "understood forwardL and forwardR",
        **{each: f"misunderstood: {each}" for each in MISTAKES},
    }
    traits = [(row, row["traits"]) for row in rows]
    return [
        ("all", list(rows)),
        *(
            (who, [row for row, of in traits if of["mistake"] == mistake])
            for mistake, who in mistakes.items()
        ),
        ("showed all situations", [row for row, of in traits if len(of["situations"]) == len(SITUATIONS)]),
        *(
            (f"never showed: {each}", [row for row, of in traits if each not in of["situations"]])
            for each in SITUATIONS
        ),
        ("turn only once the ball is lost", [row for row, of in traits if not of["edge_px"]]),
        ("turn at the edge of the frame too", [row for row, of in traits if of["edge_px"]]),
    ]


def _doing(rows: Sequence[Row], what: str) -> list[Row]:
    return [row for row in rows if classify_blind_behavior(row["unseeing"]) == what]


def _showed_lost(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if "ball lost" in row["traits"]["situations"]]


def _unseeing(rows: Sequence[Row], what: str) -> tuple[str, ...]:
    of = _doing(rows, what)
    back = sum(map(failure_causes.has_turned_back_both_ways, of))
    return (what, *map(str, (len(of), len(_showed_lost(of)), back, sum(reaches(row, HIDDEN) for row in of))))


def _notes(novices: Sequence[Row]) -> tuple[str, ...]:
    never = sum(row["reached"] == 0 for row in novices)
    always = sum(row["reached"] == TRIALS * len(POSITIONS) for row in novices)
    hidden = [row for row in novices if not reaches(row, HIDDEN)]
    swinging, resting = _doing(hidden, SWINGS), _doing(hidden, RESTS)
    back = [row for row in novices if failure_causes.has_turned_back_both_ways(row)]
    alike = all(len(times(row, HIDDEN)) in (0, TRIALS) for row in novices)
    return (
        "The success criterion was fixed before any novice was run: the robot reaches the ball in "
        f"{SUCCESS:.0%} of thirty trials, within 120 s each. {always} of {len(novices)} robots reach it in every trial,"
        f" and {never} in none, as the fifth robot of the paper did.",
        f"Why {len(hidden)} robots do not find a ball that is not visible at the start: while nothing is visible, all "
        "examples have the same readings, and a single press outweighs everything that was recorded automatically. "
        "When a robot had turned past the ball, its novice pressed the opposite turn. If that happened once in each "
        "direction, the robot swings left and right as long as it sees nothing. "
        f"{len(swinging)} of the {len(hidden)} robots do so; the novices of {len(_showed_lost(swinging))} of these had "
        f"shown a lost ball. {len(resting)} robots stand still; the novices of {len(_showed_lost(resting)) or 'none'} "
        f"of these had shown one. Of {len(back)} robots that were turned back both ways, "
        f"{sum(reaches(row, HIDDEN) for row in back) or 'none'} can find the ball."
        + (
            " Each robot finds it in all ten trials or in none, so a single test would have revealed this."
            if alike
            else ""
        ),
        failure_causes.note(novices),
        "The model has limits: it includes neither people who do not understand the task at all, nor people who ask. "
        "Its parameters were fixed, with their sources, before the first run, and have not been changed since.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw successful trials by novice, times from the three positions, and success with each parameter changed."""
    figure, (reached, seconds, changes) = panels(3, wide=3.7, tall=4.4)
    novices = select_unchanged(rows)
    reached.hist([row["reached"] for row in novices], np.arange(-0.5, 31.0, 1.0).tolist(), color=COLORS[0])
    reached.axvline(SUCCESS * 30 - 0.5, color="#6b7280", linewidth=1, linestyle=":")
    reached.set_xlabel("trials of 30 that reach the ball")
    reached.set_ylabel("novices")
    reached.set_title("success of each novice")
    good = [row for row in novices if has_succeeded(row)]
    bins = np.arange(5.0, 61.0, 2.5).tolist()
    for position, color in zip(POSITIONS, COLORS, strict=False):
        found = np.clip([each for row in good for each in times(row, position)], 5.0, 59.9)
        seconds.hist(found, bins, histtype="step", linewidth=1.6, color=color, label=position)
    seconds.set_xlabel("time to within 15 cm, s (60: or more)")
    seconds.set_ylabel("trials")
    seconds.set_title("time to the ball")
    seconds.legend(fontsize=7.5)
    sensitivity.draw(changes, rows)
    return figure
