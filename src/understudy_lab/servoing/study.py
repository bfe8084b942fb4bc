"""The experiment: three ways to teach servoing and one hand-written robot, all on the same trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.declaration import Units
from understudy_lab.figures import COLORS, dots, panels
from understudy_lab.lesson_stats import describe_lesson
from understudy_lab.servoing.trials import CASES, HAND, PUSHED, judge, opposite, search_side, teach
from understudy_lab.statistics import compute_paired_p, format_median, format_share, interval_of_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, Task
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.tasks.soccer import LIMIT_S, POSITIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEDS = range(52_000, 52_030)
TAUGHT = tuple(topics("left"))
FOUR, LOST, EDGES = TAUGHT
METHODS = (*TAUGHT, HAND)
SHORT = {FOUR: "four states", LOST: "stateless", EDGES: "stateless,\nedges too", HAND: "by hand"}

FACED, AWAY, TOWARD, EITHER = (
    "ball opposite to the search turn",
    "pushed, ball lost opposite to it",
    "pushed, ball lost where it turns",
    "pushed to either side",
)
SUMMED = (*POSITIONS, FACED, AWAY, TOWARD, EITHER)
"""The conditions that are summarized by a median per automaton, over ten trials each; EITHER has twenty."""
FASTER, SURE, NEAR, FAILING = 1.5, 0.01, 1.2, 0.02


def work(task: Task) -> Row:
    """Teach one automaton and run its trials, or run the same trials with the hand-written robot."""
    method, seed = task["method"], task["seed"]
    if method == HAND:
        return {"search": search_side(seed), "times": judge(seed, None)}
    teaching = teach(seed, method)
    account = teaching.accounts["approach"]
    lesson = describe_lesson(teaching.library.taught["approach"], account.seconds)
    return {
        "search": search_side(seed),
        "times": judge(seed, teaching.library),
        "examples": account.examples,
        "presses": account.presses,
        "seconds": round(account.seconds, 1),
        "nodes": sum(lesson["nodes"]),
        "lessons": [lesson],
    }


def times(row: Row, what: str) -> list[float]:
    """Return the times in s of one automaton's trials in a condition; a failed trial counts as the time limit."""
    place, push = opposite(row["search"])
    (other,) = set(PUSHED) - {push}
    cases = {FACED: [place], AWAY: [push], TOWARD: [other], EITHER: list(PUSHED)}.get(what, [what])
    return [
        LIMIT_S if each is None or each != each else each for case in cases for each in row["times"][case]
    ]


def medians(rows: Sequence[Row], method: str, what: str) -> list[float]:
    """Return the median time in s of each automaton."""
    return [float(np.median(times(row, what))) for row in rows if row["task"]["method"] == method]


def count_failures(rows: Sequence[Row], method: str, cases: Sequence[str] = CASES) -> tuple[int, int]:
    """Return the number of trials that reached the time limit, and the number of all trials."""
    all_ = [
        each
        for row in rows
        if row["task"]["method"] == method
        for case in cases
        for each in row["times"][case]
    ]
    return sum(each is None or each != each for each in all_), len(all_)


def compare_methods(rows: Sequence[Row], what: str, *, with_: str = LOST, to: str = FOUR) -> dict[str, float]:
    """Compare the times of method `with_` with those of method `to` on the same trials.

    The result holds the median ratio over seeds, its 95 % interval, and the p-value of no difference.
    """
    ours, theirs = medians(rows, to, what), medians(rows, with_, what)
    ratios = np.array(theirs) / np.array(ours)
    low, high = interval_of_median(ratios)
    return {
        "ratio": round(float(np.median(ratios)), 3),
        "low": round(low, 3),
        "high": round(high, 3),
        "p": float(f"{compute_paired_p(ours, theirs):.2g}"),
    }


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize the effect of states in each condition, and the gap to the hand-written robot."""
    lost, edges = (
        {what: compare_methods(rows, what, with_=each) for what in SUMMED} for each in (LOST, EDGES)
    )
    hand = {what: compare_methods(rows, what, with_=HAND) for what in SUMMED}
    medians_by_way = {
        method: {what: round(float(np.median(medians(rows, method, what))), 2) for what in SUMMED}
        for method in METHODS
    }
    seeds = [row["task"]["seed"] for row in rows if row["task"]["method"] == FOUR]
    return StudyFindings(
        headline=_headline(medians_by_way, lost, edges, rows),
        tables=(
            ResultTable(
                f"Seconds to within 15 cm of the ball, {len(seeds)} automata taught per method (seeds {seeds[0]} to "
                f"{seeds[-1]})",
                ("", *(f"#{method}" for method in METHODS)),
                [
                    *(
                        (what, *(format_median(medians(rows, method, what), 1) for method in METHODS))
                        for what in SUMMED
                    ),
                    ("failed trials", *(_failures(rows, method) for method in METHODS)),
                    *(
                        (what, *(_told(rows, method, key) for method in METHODS))
                        for what, key in COSTS.items()
                    ),
                ],
            ),
            ResultTable(
                "Time relative to the four states on the same trials: median over seeds, with its 95 % interval",
                ("", *(f"#{method}" for method in METHODS[1:])),
                [(what, *(_compared(each[what]) for each in (lost, edges, hand))) for what in SUMMED],
            ),
        ),
        goals=goals(rows),
        notes=_notes(rows, lost, edges),
        numbers={
            "median_s": medians_by_way,
            "stateless_relative_to_four_states": lost,
            "edges_relative_to_four_states": edges,
            "hand_relative_to_four_states": hand,
            "failures": {method: count_failures(rows, method)[0] for method in METHODS},
        },
    )


COSTS = {
    "examples from presses": "examples",
    "presses": "presses",
    "teaching time, s": "seconds",
    "tree nodes": "nodes",
}


def _told(rows: Sequence[Row], method: str, key: str) -> str:
    return format_median([row[key] for row in rows if row["task"]["method"] == method and key in row])


def _failures(rows: Sequence[Row], method: str) -> str:
    count, of = count_failures(rows, method)
    mine = [row for row in rows if row["task"]["method"] == method]
    failing = format_share(sum(count_failures([row], method)[0] > 0 for row in mine), len(mine))
    return f"{count} of {of}, by {failing.replace(' (', ' automata (')}"


def _compared(comparison: dict[str, float]) -> str:
    return f"×{comparison['ratio']:.2f} ({comparison['low']:.2f}–{comparison['high']:.2f}), {_p(comparison['p'])}"


def _p(p: float) -> str:
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def _headline(medians_by_way: Any, lost: Any, edges: Any, rows: Sequence[Row]) -> str:
    count, of = count_failures(rows, FOUR)
    return (
        "A robot with four states remembers on which side it lost the ball. A stateless policy takes "
        f"×{lost[FACED]['ratio']:.2f} as long to reach the ball ({medians_by_way[LOST][FACED]:.0f} s instead of "
        f"{medians_by_way[FOUR][FACED]:.0f} s) if the ball leaves the frame on the side to which the "
        f"policy does not turn, and ×{lost[AWAY]['ratio']:.2f} as long after a push that way. "
        "Memory makes no difference if the robot starts "
        f"without seeing the ball (×{lost['ball not visible']['ratio']:.2f}), or compared with a policy that turns "
        f"before the ball is lost (×{edges[FACED]['ratio']:.2f}), unless that robot is pushed "
        f"(×{edges[AWAY]['ratio']:.2f}). {count} of {of} trials with four states fail."
    )


def _notes(rows: Sequence[Row], lost: Any, edges: Any) -> tuple[str, ...]:
    either, away = (compare_methods(rows, what, to=HAND)["ratio"] for what in (EITHER, AWAY))
    return (
        "In the trials *pushed to either side*, half of the pushes go where the policy turns anyway "
        f"(×{lost[TOWARD]['ratio']:.2f}), and the median over both sides lies between two clusters of times. Even the "
        f"hand-written robot is only ×{either:.2f} as fast as the policy there, and ×{away:.2f} as fast if the push "
        f"goes the other way. So no robot can reach ×{FASTER} in the first case, and ×{FASTER} is nearly the best "
        "possible in the second. Larger and smaller pushes, earlier and later ones, watched examples and a reaction "
        "time were tried on other seeds. The ratio was then ×1.1 to ×1.3 for pushes to either side, and ×1.2 to ×1.6 "
        "for pushes the other way.",
        "States help if the robot saw on which side the ball left the frame, and a policy would turn the other way. "
        "They do not help if the robot starts without having seen the ball. Nor do they help, while nothing pushes the "
        "robot, against a policy whose teacher keeps the ball in the frame. That policy is even slightly faster "
        f"(×{edges['ball left']['ratio']:.2f} and ×{edges['ball right']['ratio']:.2f} of the time of the four states).",
        "An earlier lesson plan never showed a switch between forwardL and forwardR. Robots taught with it turned the "
        "wrong way after a push to one side. The purpose of a state has to be demonstrated.",
    )


def goals(rows: Sequence[Row]) -> tuple[StudyGoal, ...]:
    """Return each goal of the experiment with the measured value."""
    judged = []
    for what in (FACED, AWAY, EITHER):
        comparison = compare_methods(rows, what)
        judged.append(
            StudyGoal(
                f"time of the stateless policy (turns when lost) / four states, {what}",
                f"×{FASTER}, p < {SURE}",
                f"×{comparison['ratio']:.2f}, {_p(comparison['p'])}",
                comparison["ratio"] >= FASTER and comparison["p"] < SURE,
            )
        )
    for position in POSITIONS:
        ratio = compare_methods(rows, position, with_=FOUR, to=HAND)["ratio"]
        judged.append(
            StudyGoal(f"time / by hand, {position}", f"at most ×{NEAR}", f"×{ratio:.2f}", ratio <= NEAR)
        )
    count, of = count_failures(rows, FOUR, list(POSITIONS))
    judged.append(
        StudyGoal(
            "failures of the four states, three positions",
            f"at most {FAILING:.0%}",
            f"{count} of {of}",
            count / of <= FAILING,
        )
    )
    return tuple(judged)


def draw(rows: Sequence[Row]) -> Figure:
    """Draw histograms of all trials from the three positions (paper Figure 3), and medians where states matter."""
    figure, axes = panels(8, rows=2, wide=3.3, tall=2.6)
    for panel, what in zip(axes[:4], (*POSITIONS, EITHER), strict=True):
        _histogram(panel, rows, what)
        panel.set_title(what)
    axes[0].set_ylabel("trials")
    axes[0].legend(fontsize=7.5)
    for panel, what in zip(axes[4:], (FACED, AWAY, TOWARD, EITHER), strict=True):
        dots(panel, {SHORT[method]: medians(rows, method, what) for method in METHODS}, "median time, s")
        panel.tick_params(axis="x", labelsize=7)
        panel.set_ylim(0, 26)
        panel.set_title(what)
    return figure


def _histogram(axes: Axes, rows: Sequence[Row], what: str) -> None:
    """Draw the times of the taught robots as bars and those of the hand-written robot as a line."""
    bins = np.arange(8.0, 32.1, 1.0).tolist()
    for method, style in HISTOGRAMS.items():
        all_ = [each for row in rows if row["task"]["method"] == method for each in times(row, what)]
        axes.hist(np.clip(all_, 8.0, 31.9), bins, label=SHORT[method], **style)
    axes.set_xlabel("time to within 15 cm, s")


HISTOGRAMS: Mapping[str, Mapping[str, Any]] = {
    FOUR: {"color": COLORS[0], "alpha": 0.55},
    LOST: {"color": COLORS[1], "alpha": 0.55},
    HAND: {"color": "#111827", "histtype": "step", "linewidth": 1.2},
}

EXPERIMENT = Study(
    name="servoing",
    seeds=SEEDS,
    quick=2,
    tasks=Units({"method": METHODS}),
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("soccer",),
)
