"""The experiment: a hundred simulated novices, five minutes each, the same live, and with each parameter changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.link import link
from understudy.training.session import Session
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup
from understudy_lab.figures import COLORS, Panels
from understudy_lab.lesson_stats import describe_lesson
from understudy_lab.novices import failure_causes, sensitivity
from understudy_lab.novices.failure_causes import (
    FINDS,
    RESTS,
    SWINGS,
    TRIALS,
    WALKS_ON,
    classify_blind_behavior,
    count_turn_backs,
    format_succeeding,
    has_succeeded,
    list_blind_states,
    reaches,
    select_live,
    select_unchanged,
    share,
    succeeds_everywhere,
    succeeds_nearly_always,
    summarize_both_readings,
    times,
)
from understudy_lab.novices.novice import (
    MINUTES_S,
    MISTAKES,
    PARAMETERS,
    SITUATIONS,
    SUCCESS,
    UNDERSTOOD,
    Novice,
    draw_traits,
    make_shared_traits,
)
from understudy_lab.novices.sensitivity import FACTORS, SENSITIVITY
from understudy_lab.novices.teach_live import BY_THE_BALL, draw_seed, teach_live
from understudy_lab.rows import Count, Median, Rows
from understudy_lab.statistics import spread
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import POSITIONS, Soccer, approach_by, kit
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(53_000, 53_100)


def tasks(plan: StudyPlan) -> list[Task]:
    """Return two tasks per novice, one of them live, and unless quick, others with each parameter changed."""
    teachings: list[Task] = [{"seed": seed} for seed in plan.seeds]
    teachings += [{"seed": seed, "method": LIVE} for seed in plan.seeds]
    if not plan.quick:
        changes = [(name, factor) for name in PARAMETERS for factor in FACTORS]
        teachings += [
            {"seed": seed, "trait": name, "factor": factor}
            for name, factor in changes
            for seed in plan.seeds[:SENSITIVITY]
        ]
    return teachings


def work(task: Task) -> Row:
    """Let one novice teach for five minutes, test the automaton, and return the results."""
    seed = task["seed"]
    scaled = {task["trait"]: task["factor"]} if "trait" in task else {}
    traits = draw_traits(seed, scaled=scaled)
    novice = Novice(traits, seed, make_shared_traits(scaled))
    taught = _teach_live(novice) if task.get("method") == LIVE else novice.teach()
    times = judge(taught, seed)
    lesson = describe_lesson(taught, MINUTES_S)
    row = {
        "times": times,
        "reached": sum(each == each for seconds in times.values() for each in seconds),
        "presses": novice.presses,
        "slipped": novice.slipped,
        "examples": lesson["examples"],
        "nodes": sum(lesson["nodes"]),
        "traits": {name: _rounded(value) for name, value in asdict(traits).items()},
    }
    if scaled:
        return row
    return {
        **row,
        "lessons": [lesson],
        "shown": dict(novice.shown),
        "turned_back": count_turn_backs(taught),
        "unseeing": list_blind_states(taught),
    }


def _teach_live(novice: Novice) -> TrainedAutomaton:
    session = Session(Soccer([draw_seed(novice)]), Library(kit), four_states(Library(kit)))
    teach_live(novice, session, BY_THE_BALL)
    return session.make_trained_automaton()


def _rounded(value: Any) -> Any:
    return round(value, 4) if isinstance(value, float) else value


def judge(taught: TrainedAutomaton, seed: int) -> dict[str, list[float]]:
    """Return the seconds to the ball in ten trials from each of the paper's positions; NaN at the time limit."""
    starts = [start for start in POSITIONS.values() for _ in range(TRIALS)]
    body = Soccer(range(100 * seed, 100 * seed + len(starts)), starts)
    program = link(Library(kit).with_automaton(taught), taught.automaton.name, {})
    seconds = np.round(approach_by(program, body), 1).reshape(len(POSITIONS), TRIALS)
    return dict(zip(POSITIONS, seconds.tolist(), strict=True))


HIDDEN = "ball not visible"
WANTED = 0.7
WANTED_LIVE, FEWER_LIVE = 0.95, 0.5
SHOWED_LOST = Count(lambda row: "ball lost" in row["traits"]["situations"])


def _times(row: Row, *positions: str) -> float | None:
    """Return the median time in s of a robot over its successful trials; None without any."""
    seconds = [each for position in positions for each in times(row, position)]
    return float(np.median(seconds)) if seconds else None


def _methods(rows: Rows) -> dict[str, Rows]:
    return {"the paper's training": select_unchanged(rows), "live teaching": select_live(rows)}


def _by_position(rows: Rows) -> dict[str, Rows]:
    return {each: Rows({**row, "position": each} for row in select_unchanged(rows)) for each in POSITIONS}


def _groups(rows: Rows) -> dict[str, Rows]:
    """Group the novices by misunderstanding, by situations they never showed, and by when they turn."""
    novices = select_unchanged(rows)
    conditions: dict[str, Callable[..., bool]] = {
        "all": lambda traits: True,
        "understood forwardL and forwardR": lambda traits: traits["mistake"] == UNDERSTOOD,
        **{
            f"misunderstood: {each}": lambda traits, each=each: traits["mistake"] == each for each in MISTAKES
        },
        "showed all situations": lambda traits: len(traits["situations"]) == len(SITUATIONS),
        **{
            f"never showed: {each}": lambda traits, each=each: each not in traits["situations"]
            for each in SITUATIONS
        },
        "turn only once the ball is lost": lambda traits: not traits["edge_px"],
        "turn at the edge of the frame too": lambda traits: bool(traits["edge_px"]),
    }
    return {
        name: novices.filter(lambda row, holds=holds: holds(row["traits"]))
        for name, holds in conditions.items()
    }


def _doing(rows: Rows, what: str) -> Rows:
    return rows.filter(lambda row: classify_blind_behavior(row["unseeing"]) == what)


def _by_blind_behavior(rows: Rows) -> dict[str, Rows]:
    return {what: _doing(select_unchanged(rows), what) for what in (FINDS, SWINGS, RESTS, WALKS_ON)}


def _count(condition: Callable[[Row], bool]) -> Callable[[Rows], str]:
    return lambda rows: str(Count(condition).number(rows))


def _headline(rows: Rows) -> str:
    novices, live = select_unchanged(rows), select_live(rows)
    half, each = share(novices), share(novices, succeeds_everywhere)
    median = novices.filter(has_succeeded).median(lambda row: _times(row, *POSITIONS))
    by_live_teaching = (
        f" Taught live, robots of {Count(succeeds_nearly_always)(live)} novices reach the ball in at least 90 % of all "
        f"trials, instead of {Count(succeeds_nearly_always).number(novices)}, after {live.median('presses'):.0f} "
        f"instead of {novices.median('presses'):.0f} presses (medians)."
        if live
        else ""
    )
    return (
        f"{half['succeed']} of {half['of']} simulated novices (95 % interval {100 * half['low']:.0f} to "
        f"{100 * half['high']:.0f} %) succeed: within five minutes, and without a test or a correction, they teach a "
        "robot that reaches the ball in at least half of its trials (in the paper: 4 of 5 people). The median time of "
        f"these robots is {median:.0f} s. But only {each['succeed']} of {each['of']} novices succeed from each of the "
        f"three positions. The other robots do not find a ball that is not visible at the start.{by_live_teaching}"
    )


def _notes(rows: Rows) -> tuple[str, ...]:
    novices = select_unchanged(rows)
    never = sum(row["reached"] == 0 for row in novices)
    always = sum(row["reached"] == TRIALS * len(POSITIONS) for row in novices)
    hidden = novices.filter(lambda row: not reaches(row, HIDDEN))
    swinging, resting = _doing(hidden, SWINGS), _doing(hidden, RESTS)
    back = novices.filter(failure_causes.has_turned_back_both_ways)
    alike = all(len(times(row, HIDDEN)) in (0, TRIALS) for row in novices)
    return (
        "The success criterion was fixed before any novice was run: the robot reaches the ball in "
        f"{SUCCESS:.0%} of thirty trials, within 120 s each. {always} of {len(novices)} robots reach it in every trial,"
        f" and {never} in none, as the fifth robot of the paper did.",
        f"Why {len(hidden)} robots do not find a ball that is not visible at the start: while nothing is visible, all "
        "examples have the same readings, and a single press outweighs everything that was recorded automatically. "
        "When a robot had turned past the ball, its novice pressed the opposite turn. If that happened once in each "
        "direction, the robot swings left and right as long as it sees nothing. "
        f"{len(swinging)} of the {len(hidden)} robots do so; the novices of {SHOWED_LOST.number(swinging)} of these "
        f"had shown a lost ball. {len(resting)} robots stand still; the novices of "
        f"{SHOWED_LOST.number(resting) or 'none'} of these had shown one. Of {len(back)} robots that were turned back "
        f"both ways, {sum(reaches(row, HIDDEN) for row in back) or 'none'} can find the ball."
        + (
            " Each robot finds it in all ten trials or in none, so a single test would have revealed this."
            if alike
            else ""
        ),
        failure_causes.note(novices),
        "The model has limits: it includes neither people who do not understand the task at all, nor people who ask. "
        "Its parameters were fixed, with their sources, before the first run, and have not been changed since.",
        sensitivity.note(rows),
    )


def _compare_presses(rows: Rows) -> str:
    live, before = (each.median("presses") for each in (select_live(rows), select_unchanged(rows)))
    return f"{live / before:.2f} ({live:.0f} / {before:.0f})"


GOALS = (
    Goal(
        "novices who succeed, from the automaton alone",
        lambda rows: Count(has_succeeded).share(select_unchanged(rows)),
        least=WANTED,
        measured=lambda rows: format_succeeding(select_unchanged(rows)),
    ),
    Goal(
        "taught live: robots that reach the ball in 90 % of all trials",
        lambda rows: Count(succeeds_nearly_always).share(select_live(rows)),
        least=WANTED_LIVE,
        measured=lambda rows: format_succeeding(select_live(rows), succeeds_nearly_always),
    ),
    Goal(
        "taught live: presses of a median novice / those in the paper's training",
        lambda rows: select_live(rows).median("presses") / select_unchanged(rows).median("presses"),
        "{}",
        most=FEWER_LIVE,
        measured=_compare_presses,
    ),
)


def _draw_success(axes: Axes, rows: Rows) -> None:
    """Draw the successful trials of each novice."""
    axes.hist(select_unchanged(rows).values("reached"), np.arange(-0.5, 31.0, 1.0).tolist(), color=COLORS[0])
    axes.axvline(SUCCESS * 30 - 0.5, color="#6b7280", linewidth=1, linestyle=":")
    axes.set_xlabel("trials of 30 that reach the ball")
    axes.set_ylabel("novices")
    axes.set_title("success of each novice")


def _draw_times(axes: Axes, rows: Rows) -> None:
    """Draw the times from the three positions."""
    good, bins = select_unchanged(rows).filter(has_succeeded), np.arange(5.0, 61.0, 2.5).tolist()
    for position, color in zip(POSITIONS, COLORS, strict=False):
        seconds = np.clip([each for row in good for each in times(row, position)], 5.0, 59.9)
        axes.hist(seconds, bins, histtype="step", linewidth=1.6, color=color, label=position)
    axes.set_xlabel("time to within 15 cm, s (60: or more)")
    axes.set_ylabel("trials")
    axes.set_title("time to the ball")
    axes.legend(fontsize=7.5)


EXPERIMENT = Study(
    name="novices",
    seeds=SEEDS,
    quick=5,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            LinePerGroup(
                "Results by start position, {teachings} novices",
                [""],
                _by_position,
                {
                    "novices who succeed from there": Count(
                        lambda row: reaches(row, row["position"]), interval=True
                    ),
                    "trials that reach the ball": lambda rows: (
                        f"{sum(len(times(row, row['position'])) for row in rows)} of {TRIALS * len(rows)}"
                    ),
                    "time to the ball, s (median of each robot)": Median(
                        lambda row: _times(row, row["position"]) if reaches(row, row["position"]) else None, 1
                    ),
                },
            ),
            LinePerGroup(
                "Novices who succeed, by group",
                [""],
                _groups,
                {
                    "in half of all trials": format_succeeding,
                    "from each position": partial(format_succeeding, well=succeeds_everywhere),
                },
            ),
            LinePerGroup(
                "Behavior of the robots while they see no ball (pressed back both ways: while no ball was visible, the "
                "novice changed a left turn into a right turn at least once, and a right turn into a left turn)",
                [""],
                _by_blind_behavior,
                {
                    "novices": lambda rows: str(len(rows)),
                    "showed a lost ball": _count(SHOWED_LOST.condition),
                    "pressed back both ways": _count(failure_causes.has_turned_back_both_ways),
                    f"succeed: {HIDDEN}": _count(lambda row: reaches(row, HIDDEN)),
                },
            ),
            LinePerGroup(
                "The same novices by method, five minutes each",
                [""],
                _methods,
                {
                    "reach the ball in 90 % of all trials": partial(
                        format_succeeding, well=succeeds_nearly_always
                    ),
                    "in half of all trials": format_succeeding,
                    "in half from each position": partial(format_succeeding, well=succeeds_everywhere),
                    "presses": Median("presses"),
                },
            ),
            lambda rows: failure_causes.table(select_unchanged(rows)),
            sensitivity.table,
        ),
        goals=GOALS,
        notes=_notes,
        numbers=lambda rows: {
            "half": share(select_unchanged(rows)),
            "everywhere": share(select_unchanged(rows), succeeds_everywhere),
            "live": {
                "nearly always": share(select_live(rows), succeeds_nearly_always),
                **summarize_both_readings(select_live(rows)),
                "presses": spread(select_live(rows).values("presses")),
            },
            "sensitivity": sensitivity.numbers(rows),
            "first": summarize_both_readings(select_unchanged(rows)[: sensitivity.SENSITIVITY]),
        },
    ),
    draw=Panels((_draw_success, _draw_times, sensitivity.draw), wide=3.7, tall=4.4),
    worlds=("soccer",),
)
