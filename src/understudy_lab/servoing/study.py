"""The experiment: three ways to teach servoing and one hand-written robot, all on the same trials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.declaration import ColumnPerGroup, Conclusion, Goal, Units
from understudy_lab.figures import COLORS, Dots, Panels
from understudy_lab.lesson_stats import describe_lesson
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.servoing.trials import CASES, HAND, PUSHED, judge, opposite, search_side, teach
from understudy_lab.statistics import compute_paired_p, interval_of_median
from understudy_lab.study import Row, Study, StudyGoal, Task
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.tasks.soccer import LIMIT_S, POSITIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
POSITIONS_AND_PUSHES = (*POSITIONS, EITHER)
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


Comparisons = Mapping[str, Mapping[str, Mapping[str, float]]]
"""The comparisons of each other method with the four states, by condition."""


def _compare_all(rows: Rows) -> Comparisons:
    return {
        other: {what: compare_methods(rows, what, with_=other) for what in SUMMED} for other in METHODS[1:]
    }


def _format_failures(rows: Rows) -> str:
    count, of = count_failures(rows, rows[0]["task"]["method"])
    failing = Count(lambda row: count_failures([row], row["task"]["method"])[0] > 0, interval=True)
    return f"{count} of {of}, by {failing(rows).replace(' (', ' automata (')}"


def _format(comparison: Mapping[str, float]) -> str:
    return f"×{comparison['ratio']:.2f} ({comparison['low']:.2f}–{comparison['high']:.2f}), {_p(comparison['p'])}"


def _p(p: float) -> str:
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"


def _headline(rows: Rows) -> str:
    lost, edges = (_compare_all(rows)[other] for other in (LOST, EDGES))
    seconds = [np.median(medians(rows, method, FACED)) for method in (LOST, FOUR)]
    count, of = count_failures(rows, FOUR)
    return (
        "A robot with four states remembers on which side it lost the ball. A stateless policy takes "
        f"×{lost[FACED]['ratio']:.2f} as long to reach the ball ({seconds[0]:.0f} s instead of {seconds[1]:.0f} s) if "
        "the ball leaves the frame on the side to which the policy does not turn, and "
        f"×{lost[AWAY]['ratio']:.2f} as long after a push that way. Memory makes no difference if the robot starts "
        f"without seeing the ball (×{lost['ball not visible']['ratio']:.2f}), or compared with a policy that turns "
        f"before the ball is lost (×{edges[FACED]['ratio']:.2f}), unless that robot is pushed "
        f"(×{edges[AWAY]['ratio']:.2f}). {count} of {of} trials with four states fail."
    )


def _notes(rows: Rows) -> tuple[str, ...]:
    lost, edges = (_compare_all(rows)[other] for other in (LOST, EDGES))
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


def _faster(what: str) -> Callable[[Rows], StudyGoal]:
    """Return the goal for how much longer the stateless policy takes in a condition."""

    def judge(rows: Rows) -> StudyGoal:
        comparison = compare_methods(rows, what)
        return StudyGoal(
            f"time of the stateless policy (turns when lost) / four states, {what}",
            f"×{FASTER}, p < {SURE}",
            f"×{comparison['ratio']:.2f}, {_p(comparison['p'])}",
            comparison["ratio"] >= FASTER and comparison["p"] < SURE,
        )

    return judge


def _near(rows: Rows, position: str) -> float:
    return compare_methods(rows, position, with_=FOUR, to=HAND)["ratio"]


def _fail(rows: Rows) -> tuple[int, int]:
    return count_failures(rows, FOUR, list(POSITIONS))


def _draw_medians(axes: Axes, rows: Rows, what: str) -> None:
    by_method = {SHORT[method]: medians(rows, method, what) for method in METHODS}
    Dots(what, "median time, s", lambda rows: by_method, limits=(0, 26))(axes, rows)
    axes.tick_params(axis="x", labelsize=7)


def _histogram(axes: Axes, rows: Rows, what: str, *, first: bool) -> None:
    """Draw the times of the taught robots as bars and those of the hand-written robot as a line."""
    bins = np.arange(8.0, 32.1, 1.0).tolist()
    for method, style in HISTOGRAMS.items():
        all_ = [each for row in rows.where(method=method) for each in times(row, what)]
        axes.hist(np.clip(all_, 8.0, 31.9), bins, label=SHORT[method], **style)
    axes.set_xlabel("time to within 15 cm, s")
    axes.set_title(what)
    if first:
        axes.set_ylabel("trials")
        axes.legend(fontsize=7.5)


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
    conclude=Conclusion(
        headline=_headline,
        tables=(
            ColumnPerGroup(
                "Seconds to within 15 cm of the ball, {teachings} automata taught per method (seeds {seeds})",
                group_by("method", METHODS),
                {
                    **{
                        what: Median(lambda row, what=what: np.median(times(row, what)), 1) for what in SUMMED
                    },
                    "failed trials": _format_failures,
                    **{
                        what: Median(lambda row, key=key: row.get(key))
                        for what, key in (
                            ("examples from presses", "examples"),
                            ("presses", "presses"),
                            ("teaching time, s", "seconds"),
                            ("tree nodes", "nodes"),
                        )
                    },
                },
            ),
            ColumnPerGroup(
                "Time relative to the four states on the same trials: median over seeds, with its 95 % interval",
                _compare_all,
                {what: lambda comparison, what=what: _format(comparison[what]) for what in SUMMED},
            ),
        ),
        goals=(
            *map(_faster, (FACED, AWAY, EITHER)),
            *(
                Goal(
                    f"time / by hand, {each}",
                    partial(_near, position=each),
                    "×{:.2f}",
                    most=NEAR,
                    wanted=f"at most ×{NEAR}",
                )
                for each in POSITIONS
            ),
            Goal(
                "failures of the four states, three positions",
                lambda rows: _fail(rows)[0] / _fail(rows)[1],
                most=FAILING,
                measured=lambda rows: f"{_fail(rows)[0]} of {_fail(rows)[1]}",
            ),
        ),
        notes=_notes,
        numbers=lambda rows: {
            "median_s": {
                method: {what: round(float(np.median(medians(rows, method, what))), 2) for what in SUMMED}
                for method in METHODS
            },
            **{
                f"{name}_relative_to_four_states": of
                for name, of in zip(("stateless", "edges", "hand"), _compare_all(rows).values(), strict=True)
            },
            "failures": {method: count_failures(rows, method)[0] for method in METHODS},
        },
    ),
    draw=Panels(  # paper Figure 3, and medians where states matter
        (
            *(
                partial(_histogram, what=what, first=what == POSITIONS_AND_PUSHES[0])
                for what in POSITIONS_AND_PUSHES
            ),
            *(partial(_draw_medians, what=what) for what in (FACED, AWAY, TOWARD, EITHER)),
        ),
        rows=2,
        wide=3.3,
        tall=2.6,
    ),
    worlds=("soccer",),
)
