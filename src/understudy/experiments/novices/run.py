"""The experiment: a hundred simulated novices, five minutes each; and the same with each of their traits changed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.experiments.experiment import Experiment, Findings, Goal, Plan, Row, Table, Task
from understudy.experiments.figures import COLORS, panels
from understudy.experiments.lessons import described
from understudy.experiments.novices.novice import Novice
from understudy.experiments.novices.traits import (
    MINUTES_S,
    MISTAKES,
    RANGES,
    SITUATIONS,
    SUCCESS,
    UNDERSTOOD,
    drawn,
)
from understudy.experiments.statistics import differ, interval_of_share, told
from understudy.model.library import Library, Taught
from understudy.runtime.program import link
from understudy.worlds.soccer import POSITIONS, Soccer, approach_by, kit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEDS = range(53_000, 53_100)
SENSITIVITY = 50
"""How many of the novices, the first ones, are run again with each trait changed."""
FACTORS = (0.5, 1.5)
TRIALS = 10
WANTED = 0.7


def tasks(plan: Plan) -> list[Task]:
    """Each novice as they are; and some with each trait halved and half as much again, unless it is quick."""
    made: list[Task] = [{"seed": seed} for seed in plan.seeds]
    if not plan.quick:
        changes = [(trait, factor) for trait in RANGES for factor in FACTORS]
        made += [
            {"seed": seed, "trait": trait, "factor": factor}
            for trait, factor in changes
            for seed in plan.seeds[:SENSITIVITY]
        ]
    return made


def work(task: Task) -> Row:
    """One novice's five minutes, and what the automaton then does by itself."""
    seed = task["seed"]
    scaled = {task["trait"]: task["factor"]} if "trait" in task else {}
    traits = drawn(seed, scaled=scaled)
    novice = Novice(traits, seed)
    taught = novice.teach()
    times = judge(taught, seed)
    lesson = described(taught, MINUTES_S)
    row = {
        "times": times,
        "reached": sum(each == each for seconds in times.values() for each in seconds),
        "presses": novice.presses,
        "slipped": novice.slipped,
        "examples": lesson["examples"],
        "nodes": sum(lesson["nodes"]),
        "traits": {name: _rounded(value) for name, value in asdict(traits).items()},
    }
    return row if scaled else {**row, "lessons": [lesson]}


def _rounded(value: Any) -> Any:
    return round(value, 4) if isinstance(value, float) else value


def judge(taught: Taught, seed: int) -> dict[str, list[float]]:
    """Seconds to the ball, ten trials from each of the paper's positions; NaN where the limit came first."""
    starts = [start for start in POSITIONS.values() for _ in range(TRIALS)]
    body = Soccer(range(100 * seed, 100 * seed + len(starts)), starts)
    program = link(Library(kit).with_taught(taught), taught.automaton.name, {})
    seconds = np.round(approach_by(program, body), 1).reshape(len(POSITIONS), TRIALS)
    return dict(zip(POSITIONS, seconds.tolist(), strict=True))


def succeeded(row: Row) -> bool:
    """Whether the robot gets to the ball in half of its trials at least."""
    return bool(row["reached"] >= SUCCESS * TRIALS * len(POSITIONS))


def everywhere(row: Row) -> bool:
    """Whether it does so in half of the trials from each position: a stricter reading, told beside."""
    return all(
        sum(each is not None and each == each for each in row["times"][p]) >= SUCCESS * TRIALS
        for p in POSITIONS
    )


def base(rows: Sequence[Row]) -> list[Row]:
    """Those of the novices as they are."""
    return [row for row in rows if "trait" not in row["task"]]


def changed(rows: Sequence[Row], trait: str, factor: float) -> list[Row]:
    """Those of the novices with a trait changed."""
    return [row for row in rows if row["task"].get("trait") == trait and row["task"]["factor"] == factor]


def share(rows: Sequence[Row], well: Callable[[Row], bool] = succeeded) -> dict[str, Any]:
    """How many of them succeed, with the 95 % interval of the share."""
    count, of = sum(map(well, rows)), len(rows)
    low, high = interval_of_share(count, of)
    return {"succeed": count, "of": of, "low": round(low, 4), "high": round(high, 4)}


def _said(found: Mapping[str, Any]) -> str:
    if not found["of"]:
        return "none"
    return f"{found['succeed']} of {found['of']} ({100 * found['low']:.0f}–{100 * found['high']:.0f} %)"


def conclude(rows: Sequence[Row]) -> Findings:
    """How many succeed, how fast their robots are, what separates those who fail, and what it hangs on."""
    novices = base(rows)
    half, each_ = share(novices), share(novices, everywhere)
    sensitivity = {
        trait: {str(factor): both(changed(rows, trait, factor)) for factor in FACTORS} for trait in RANGES
    }
    same = both(novices[:SENSITIVITY])
    times = [median for row in novices if succeeded(row) for median in _medians([row])]
    return Findings(
        headline=f"{half['succeed']} of {half['of']} simulated novices (95 % interval {100 * half['low']:.0f} to "
        f"{100 * half['high']:.0f} %) teach a robot in five minutes to reach the ball in half of its trials at least, "
        f"by themselves and without a test or a correction (the paper: 4 of 5 people); their median robot takes "
        f"{np.median(times):.0f} s. But only {each_['succeed']} of {each_['of']} manage it from each of the three "
        "positions: the others' robots do not find a ball that they do not see at first.",
        tables=(
            Table(
                f"From each position, {len(novices)} novices",
                (
                    "",
                    "#novices who succeed from there",
                    "#trials that reach the ball",
                    "#seconds, median of each robot",
                ),
                [_position(novices, position) for position in POSITIONS],
            ),
            Table(
                "Who succeeds",
                ("", "#in half of all trials", "#from each position"),
                [(who, *(_said(found) for found in both(of).values())) for who, of in _groups(novices)],
            ),
            Table(
                "What separates those who succeed from each position",
                ("", "#succeed", "#fail", "#p"),
                [_separated(novices, trait, read) for trait, read in READ.items()],
            ),
            Table(
                f"The first {same['half']['of']} novices with one trait changed (as they are: "
                f"{same['half']['succeed']} succeed, {same['everywhere']['succeed']} from each position)",
                ("", *(f"#{what}, ×{factor}" for what in ("half", "each") for factor in FACTORS)),
                [
                    (trait, *(_said(found[str(factor)][what]) for what in same for factor in FACTORS))
                    for trait, found in sensitivity.items()
                ],
            ),
        ),
        goals=(
            Goal(
                "novices who succeed, from the automaton alone",
                f"{WANTED:.0%}",
                _said(half),
                half["succeed"] >= WANTED * half["of"],
            ),
        ),
        notes=_notes(novices),
        numbers={"half": half, "everywhere": each_, "sensitivity": sensitivity, "first": same},
    )


READ: Mapping[str, tuple[Callable[[Row], float], int]] = {
    "mean reaction, s": (lambda row: row["traits"]["reaction_s"], 2),
    "chance of a slip": (lambda row: row["traits"]["slips"], 3),
    "share of time not looking": (lambda row: row["traits"]["lapses"], 2),
    "misjudged, either way": (lambda row: abs(row["traits"]["misjudged"]), 2),
    "off the middle, either way, px": (lambda row: abs(row["traits"]["off_middle_px"]), 0),
    "situations shown, of 3": (lambda row: len(row["traits"]["situations"]), 0),
    "presses that slipped": (lambda row: row["slipped"], 0),
    "presses": (lambda row: row["presses"], 0),
}


def both(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """`share` by either reading of success."""
    return {"half": share(rows), "everywhere": share(rows, everywhere)}


def _separated(
    rows: Sequence[Row], what: str, read: tuple[Callable[[Row], float], int]
) -> tuple[str, str, str, str]:
    value, digits = read
    good, bad = ([value(row) for row in rows if everywhere(row) is well] for well in (True, False))
    p = f"{differ(good, bad):.2g}" if good and bad else ""
    return (what, told(good, digits), told(bad, digits), p)


def _groups(rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """Novices by what they understood, thought of and do."""
    mistakes = {
        UNDERSTOOD: "understood forwardL and forwardR",
        **{each: f"misunderstood: {each}" for each in MISTAKES},
    }
    traits = [(row, row["traits"]) for row in rows]
    return [
        ("all", list(rows)),
        *(
            (said, [row for row, of in traits if of["mistake"] == mistake])
            for mistake, said in mistakes.items()
        ),
        ("showed all situations", [row for row, of in traits if len(of["situations"]) == len(SITUATIONS)]),
        *(
            (f"never showed: {each}", [row for row, of in traits if each not in of["situations"]])
            for each in SITUATIONS
        ),
        ("turn only once the ball is lost", [row for row, of in traits if not of["edge_px"]]),
        ("turn at the edge of the frame too", [row for row, of in traits if of["edge_px"]]),
    ]


def _times(rows: Sequence[Row], position: str) -> list[float]:
    return [each for row in rows for each in row["times"][position] if each is not None and each == each]


def _medians(rows: Sequence[Row], positions: Sequence[str] = tuple(POSITIONS)) -> list[float]:
    """The median time of each robot over the trials in which it gets there."""
    found = [[each for position in positions for each in _times([row], position)] for row in rows]
    return [float(np.median(each)) for each in found if each]


def _position(rows: Sequence[Row], position: str) -> tuple[str, str, str, str]:
    good = [row for row in rows if len(_times([row], position)) >= SUCCESS * TRIALS]
    low, high = interval_of_share(len(good), len(rows))
    said = f"{len(good)} of {len(rows)} ({100 * low:.0f}–{100 * high:.0f} %)"
    reached = f"{len(_times(rows, position))} of {TRIALS * len(rows)}"
    return (position, said, reached, told(_medians(good, [position]), 1))


def _notes(novices: Sequence[Row]) -> tuple[str, ...]:
    early, late = (
        share([row for row in novices if bool(row["traits"]["edge_px"]) is at], everywhere)
        for at in (True, False)
    )
    never = sum(row["reached"] == 0 for row in novices)
    missing = [row for row in novices if row["reached"] < TRIALS * len(POSITIONS)]
    shown_lost = sum("ball lost" in row["traits"]["situations"] for row in missing)
    always = sum(row["reached"] == TRIALS * len(POSITIONS) for row in novices)
    return (
        f"Success was defined before any novice was run: the ball is reached in {SUCCESS:.0%} of thirty trials, within "
        f"120 s each. {always} of {len(novices)} robots get there in every trial, and {never} in none, as the paper's "
        "fifth.",
        "Why robots do not find a ball that they do not see at first, from twenty novices on other seeds: of nine of "
        "them six were never put where it could not be seen, and walk straight on; three had, each way once, been "
        "turned back after they had turned past the ball, so that while nothing is seen left says right and right says "
        f"left. (Of the published novices, {shown_lost} of the {len(novices) - always} whose robots do not always get "
        "there had shown a lost ball: that it was shown is not enough.) What is pressed outvotes what is recorded by "
        "itself, and one test would have shown it. It seems to "
        "happen most to those who turn the robot while the ball is still at the edge of the frame: from each position "
        f"{early['succeed']} of {early['of']} of them succeed, and {late['succeed']} of {late['of']} of those who wait "
        "until it is lost, as the paper describes.",
        "The model is no person: it lacks people who do not understand at all what they are to do, and those who ask. "
        "Its traits were fixed, with their sources, before the first run and not touched since.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Trials that reach the ball, by novice; times from the three positions; success with each trait changed."""
    figure, (reached, times, changes) = panels(3, wide=3.5, tall=3.0)
    novices = base(rows)
    reached.hist([row["reached"] for row in novices], np.arange(-0.5, 31.0, 1.0).tolist(), color=COLORS[0])
    reached.axvline(SUCCESS * 30 - 0.5, color="#6b7280", linewidth=1, linestyle=":")
    reached.set_xlabel("trials of 30 that reach the ball")
    reached.set_ylabel("novices")
    reached.set_title("how well they taught")
    good = [row for row in novices if succeeded(row)]
    bins = np.arange(5.0, 61.0, 2.5).tolist()
    for position, color in zip(POSITIONS, COLORS, strict=False):
        found = np.clip(_times(good, position), 5.0, 59.9)
        times.hist(found, bins, histtype="step", linewidth=1.6, color=color, label=position)
    times.set_xlabel("time to within 15 cm, s (60: or more)")
    times.set_ylabel("trials")
    times.set_title("how fast their robots are")
    times.legend(fontsize=7.5)
    _draw_changes(changes, rows)
    return figure


def _draw_changes(axes: Axes, rows: Sequence[Row]) -> None:
    """Success with each trait changed: filled, in half of all trials; hollow, from each position."""
    same = both(base(rows)[:SENSITIVITY])
    for now in same.values():
        axes.axvline(100 * now["succeed"] / now["of"], color="#6b7280", linewidth=1, linestyle=":")
    for factor, color, up in zip(FACTORS, COLORS, (0.14, -0.14), strict=False):
        for what, fill in (("half", color), ("everywhere", "white")):
            found = [both(changed(rows, trait, factor))[what] for trait in RANGES]
            at = [(k + up, each) for k, each in enumerate(found) if each["of"]]
            low, high = ([100 * each[end] for _, each in at] for end in ("low", "high"))
            middle = [100 * each["succeed"] / each["of"] for _, each in at]
            heights = [height for height, _ in at]
            axes.hlines(heights, low, high, color=color, linewidth=1)
            label = f"×{factor}" if fill == color else None
            axes.plot(middle, heights, "o", color=color, markerfacecolor=fill, markersize=4.5, label=label)
    axes.set_yticks(range(len(RANGES)), list(RANGES))
    axes.set_xlim(0, 103)
    axes.set_xlabel("novices who succeed, %\n(hollow: from each position)")
    axes.set_title("with one trait changed")
    axes.legend(fontsize=7.5, loc="upper left")


EXPERIMENT = Experiment(
    name="novices",
    seeds=SEEDS,
    quick=5,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("soccer",),
)
