"""The experiment: a hundred simulated novices, five minutes each, the same live, and with each parameter changed."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.program import link
from understudy.training.session import Session
from understudy_lab.lesson_stats import describe_lesson
from understudy_lab.novices.failure_causes import count_turn_backs, list_blind_states
from understudy_lab.novices.findings import conclude, draw
from understudy_lab.novices.novice import Novice
from understudy_lab.novices.sensitivity import FACTORS, SENSITIVITY
from understudy_lab.novices.success import TRIALS
from understudy_lab.novices.teach_live import BY_THE_BALL, draw_seed, teach_live
from understudy_lab.novices.traits import MINUTES_S, PARAMETERS, draw_traits, make_shared_traits
from understudy_lab.study import Row, Study, StudyPlan, Task
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import POSITIONS, Soccer, approach_by, kit
from understudy_lab.teachers.live_teacher import LIVE

SEEDS = range(53_000, 53_100)


def tasks(plan: StudyPlan) -> list[Task]:
    """Return two tasks per novice, one of them live, and unless quick, others with each parameter changed."""
    made: list[Task] = [{"seed": seed} for seed in plan.seeds]
    made += [{"seed": seed, "method": LIVE} for seed in plan.seeds]
    if not plan.quick:
        changes = [(name, factor) for name in PARAMETERS for factor in FACTORS]
        made += [
            {"seed": seed, "trait": name, "factor": factor}
            for name, factor in changes
            for seed in plan.seeds[:SENSITIVITY]
        ]
    return made


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


EXPERIMENT = Study(
    name="novices",
    seeds=SEEDS,
    quick=5,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("soccer",),
)
