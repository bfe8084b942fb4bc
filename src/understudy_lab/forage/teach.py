"""One robot taught to forage, and judged: what `understudy demo` runs once and the experiment many times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from understudy.analysis.evaluation import Evaluation, Progress, evaluate
from understudy.model.lesson import LearnerOptions
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.sim.forage import FORAGE_KIT, NAME, Forage, make_corner_cases, make_practice_worlds
from understudy.sim.view import RunFrame
from understudy_lab.tasks.forage_teacher import PLAIN, TOPICS, WATCHED
from understudy_lab.teachers.teacher import Progress as TeachingProgress
from understudy_lab.teachers.teacher import ScriptedTeacher, TeachingResult

WORLDS = 100
CORNER_WORLDS = 20

METHODS: Mapping[str, Mapping[str, LearnerOptions]] = {"watched": WATCHED, "plain": PLAIN}
"""With watched examples and a reaction time for GoTo, as the demo teaches; and the paper's plain method."""


@dataclass(frozen=True)
class JudgedTeaching:
    """One teaching with how well the robot then foraged."""

    seed: int
    teaching: TeachingResult
    evaluation: Evaluation
    corners: Mapping[str, float]  # success by corner case


def worlds_of(seed: int) -> range:
    """The unseen worlds that the teaching of this seed is judged on; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def make_practice(name: str, seed: int) -> Forage:
    """A world to practice in, by name."""
    return Forage([seed], make_practice_worlds()[name])


def teach(seed: int, *, method: str = "watched", progress: TeachingProgress | None = None) -> TeachingResult:
    """Teach GoTo, Harvest, Deposit and Forage. Same seed, same library."""
    options = METHODS[method]
    if progress is None:
        return ScriptedTeacher(Library(FORAGE_KIT), make_practice, seed, options=options).teach(*TOPICS)
    return ScriptedTeacher(
        Library(FORAGE_KIT), make_practice, seed, options=options, progress=progress
    ).teach(*TOPICS)


def judge(library: Library, seed: int, *, progress: Progress | None = None) -> Evaluation:
    """How well a library forages on the unseen worlds of a teaching seed."""
    return evaluate(library, "forage", NAME, worlds_of(seed), progress=progress)


def judge_corners(library: Library, seed: int) -> dict[str, float]:
    """Success in each of the paper's corner cases."""
    seeds = worlds_of(seed)[:CORNER_WORLDS]
    return {
        name: evaluate(library, "forage", settings.scenario(), seeds).success
        for name, settings in make_corner_cases().items()
    }


def teach_and_judge(seed: int, *, method: str = "watched") -> JudgedTeaching:
    """One teaching, judged."""
    teaching = teach(seed, method=method)
    return JudgedTeaching(
        seed, teaching, judge(teaching.library, seed), judge_corners(teaching.library, seed)
    )


def frames_of(library: Library, seed: int, *, limit_s: float = 600.0) -> list[RunFrame]:
    """One run of a library's Forage in one world, moment by moment, until all food is home."""
    body = Forage([seed])
    engine = Engine.from_program(body, link(library, "forage"))
    frames = []
    while True:
        frames.append(RunFrame(body.view(), (*engine.path(0)[:1], "")[:1]))
        if body.success()[0] or body.time_s >= limit_s:
            return frames
        engine.tick()


def summary(judged: JudgedTeaching) -> dict[str, Any]:
    """One teaching as plain data."""
    accounts, evaluation = judged.teaching.accounts, judged.evaluation
    return {
        "seed": judged.seed,
        "examples": {name: account.examples for name, account in accounts.items()}
        | {"total": judged.teaching.examples},
        "presses": sum(account.presses for account in accounts.values()),
        "lessons": sum(account.lessons for account in accounts.values()),
        "teaching_seconds": round(judged.teaching.seconds, 1),
        "worlds": len(evaluation.seeds),
        "success": evaluation.success,
        "relative_to_expert": round(evaluation.relative_to_expert, 4),
        "corner_cases": dict(judged.corners),
    }
