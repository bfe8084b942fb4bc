"""Replays of failing worlds: when exactly it went wrong, the decision then, and what the robot did from there on.

The picture shows the robots' paths, and the place where it went wrong.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import TICKS_AT_ONCE, TrialMeasure
from understudy.errors import join_names
from understudy.judging.explain_run import DecisionReason, find_latest_switch
from understudy.judging.explanation_text import describe_source, describe_switch, describe_values
from understudy.judging.rerun import WorldRerun
from understudy.sim.team.libraries import Libraries
from understudy.sim.view import RunFrame
from understudy.viz.palette import INK, PAPER
from understudy.viz.path_png import draw_run, list_path_entries
from understudy.viz.sheet import FigureSheet

AFTER_S = 30.0
"""The time that is shown after the last progress, s."""

MOST_STATES = 6
"""The largest number of states that a sentence names."""


@dataclass(frozen=True, slots=True)
class ExplainedRun:
    """A run until some time after it went wrong, and the decision that explains it.

    `wrong_s` is the time at which it went wrong, s, `robot` the explained robot, and `frames` the run tick by tick.
    `label` names that moment, `place` is where that robot stood then, m, and `states` are its states after the
    decision that explains it, outermost first. `sentences` put it in words.
    """

    wrong_s: float
    label: str
    robot: int
    frames: tuple[RunFrame, ...]
    place: tuple[float, float]
    states: tuple[str, ...]
    sentences: tuple[str, ...]


def compute_end_hash(measure: TrialMeasure, trial: Trial) -> str:
    """Compute a hash of the world at the end of a run, by which another replay is compared bit for bit."""
    run = measure.start([trial])
    world = run.get_world()
    run.advance(int(measure.get_limit(trial.scenario) / world.tick_s + 1e-9), to_goal=True)
    robots, objects = world.state.robots, world.state.objects
    digest = hashlib.sha256()
    for rows, names in (
        (robots, ("x", "y", "heading", "stored", "delivered")),
        (objects, ("x", "y", "present", "amount")),
    ):
        for name in names:
            digest.update(np.ascontiguousarray(rows[name]).tobytes())
    return digest.hexdigest()


def replay_failure(
    measure: TrialMeasure,
    trial: Trial,
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
    *,
    progress_s: float,
) -> ExplainedRun:
    """Run a failing world again, and explain the decision with which it went wrong.

    Parameters
    ----------
    measure
        Runs the behavior.
    trial
        The failing world.
    libraries
        The library of each sort of agents.
    roots
        What each sort of agents runs by itself.
    progress_s
        About when it went wrong, no earlier than that, s.

    Returns
    -------
    ExplainedRun
        The run and its explanation.
    """
    limit_s, tick_s = measure.get_limit(trial.scenario), trial.scenario.tick_s
    moment = measure.find_wrong_moment(trial, until_s=min(limit_s, progress_s + TICKS_AT_ONCE * tick_s))
    wrong = moment.tick
    robot = measure.choose_robot(trial, wrong)
    rerun = WorldRerun(trial.scenario, trial.seed, libraries, roots)
    rerun.trace(robot)
    frames, paths = list[RunFrame](), list[tuple[str, ...]]()

    def look() -> None:
        states = rerun.paths
        frames.append(RunFrame(rerun.world.view(), [path[0] if path else "" for path in states]))
        paths.append(states[robot])

    look()
    rerun.replay_to(wrong, look)
    reason, decided = find_latest_switch(rerun, robot), wrong
    last = round(min(limit_s, wrong * tick_s + AFTER_S) / tick_s)
    while rerun.tick_count < last:
        rerun.replay_to(rerun.tick_count + 1, look)
        if measure.is_cause_later and (decided == wrong or reason is None or reason.time_s < wrong * tick_s):
            reason, decided = find_latest_switch(rerun, robot), rerun.tick_count
    robots = frames[wrong].view.robots
    return ExplainedRun(
        wrong * tick_s,
        moment.label,
        robot,
        tuple(frames),
        (float(robots.x[robot]), float(robots.y[robot])),
        paths[decided],
        (
            moment.sentence,
            *describe_failing_decision(reason),
            *([_describe_states(paths[wrong + 1 :], tick_s)] if last > wrong else []),
        ),
    )


def describe_failing_decision(reason: DecisionReason | None) -> list[str]:
    """Describe the switch that explains a failure in sentences; None if the robot never switched."""
    sentences = list[str]()
    if reason is None:
        sentences.append("The robot never changed its state.")
    else:
        explanation = reason.explanation
        switch = describe_switch(explanation.state, explanation.next, explanation)
        sentences.append(f"At {reason.time_s:.1f} s {reason.automaton} {switch}.")
        if read := describe_values(reason):
            sentences.append(f"It read {read}.")
        if source := describe_source(reason):
            begin = "The decision was " if source.startswith("shown") else "The robot's automaton: "
            sentences.append(f"{begin}{source}.")
    return sentences


def _describe_states(paths: list[tuple[str, ...]], tick_s: float) -> str:
    switches = sum(one != other for one, other in pairwise(paths))
    seconds = len(paths) * tick_s
    counts: dict[str, int] = {}
    for path in paths:
        name = " > ".join(path) or "idle"
        counts[name] = counts.get(name, 0) + 1
    names = sorted(counts, key=lambda name: -counts[name])
    if switches == 0:
        return f"For {seconds:.0f} s it stayed in {names[0]}."
    listed = join_names(names[:MOST_STATES]) + (", and others" if len(names) > MOST_STATES else "")
    times = "once" if switches == 1 else f"{switches} times"
    return f"In the next {seconds:.0f} s it changed its state {times}: {listed}."


MARK = "#c0392b"


def draw_failure(replay: ExplainedRun, *, title: str) -> bytes:
    """Draw the run of a failing world as a PNG, with a mark at the robot's place when it went wrong."""
    from matplotlib.lines import Line2D

    frames = replay.frames
    last = frames[-1].view
    label = f"{replay.label}, {replay.wrong_s:.1f} s"
    entry = Line2D([], [], marker="X", ls="", mfc=MARK, mec=PAPER, ms=10.0, label=label)
    subtitle = f"until {last.time_s:.0f} s; {replay.sentences[0][0].lower()}{replay.sentences[0][1:-1]}"
    sheet = FigureSheet(last, title, subtitle, [entry, *list_path_entries(frames)])
    draw_run(sheet.axes, frames, inch=sheet.inch)
    x, y = replay.place
    sheet.axes.plot([x], [y], marker="o", ms=24.0, mfc="none", mec=MARK, mew=1.6, zorder=9)
    sheet.axes.plot([x], [y], marker="X", ms=11.0, mfc=MARK, mec=PAPER, mew=1.0, zorder=10)
    buffer = BytesIO()
    sheet.figure.savefig(buffer, format="png", edgecolor=INK)
    return buffer.getvalue()
