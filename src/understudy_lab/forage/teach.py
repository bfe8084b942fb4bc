"""Teaching and testing of one foraging robot, run once by `understudy demo` and many times by the experiment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from understudy.addons.checks.falsification.holding_test import HoldingResult, HoldingTest
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation import Evaluation
from understudy.judging.rollout import Progress
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.forage import FORAGE_KIT, NAME, Forage, make_corner_cases, make_practice_worlds
from understudy.sim.view import RunFrame
from understudy_lab.tasks.forage_teacher import FORAGE, GOTO, PLAIN, TOPICS, WATCHED
from understudy_lab.teachers.live_teacher import LIVE, LiveTeacher, choose_teacher
from understudy_lab.teachers.teacher import Progress as TeachingProgress
from understudy_lab.teachers.teacher import TeachingResult, ignore_progress

GOTO_BINDINGS = ({"A": "nearest_food"}, {"A": "station"})
"""The targets that GoTo is taught with."""
FIRST_TESTED = 2**42
"""Worlds in which it is tested whether a behavior holds have seeds from here on: no robot is taught or judged there."""
WORLDS = 100
CORNER_WORLDS = 20

METHODS: Mapping[str, Mapping[str, LearnerOptions]] = {LIVE: WATCHED, "watched": WATCHED, "plain": PLAIN}
"""The options of each method: live teaching and the paper's training, both with watched examples and a reaction time
for GoTo, and the paper's training without them."""


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def make_practice(name: str, seed: int) -> Forage:
    """Return a practice world by its name."""
    return Forage([seed], make_practice_worlds()[name])


def teach(
    seed: int,
    *,
    method: str = "watched",
    options: Mapping[str, LearnerOptions] | None = None,
    progress: TeachingProgress = ignore_progress,
) -> TeachingResult:
    """Teach GoTo, Harvest, Deposit and Forage with one of `METHODS`; the same seed gives the same library.

    `options` replace those of the method, by lesson.
    """
    teacher = choose_teacher(method)
    options = METHODS[method] if options is None else options
    return teacher(Library(FORAGE_KIT), make_practice, seed, options=options, progress=progress).teach(
        *TOPICS
    )


@dataclass(frozen=True)
class Continued:
    """What going on with a behavior where it went wrong gave: the last test, and the number of presses that it took."""

    result: HoldingResult
    presses: int


def teach_until_it_holds(
    seed: int, *, progress: TeachingProgress = ignore_progress
) -> tuple[TeachingResult, Mapping[str, Continued]]:
    """Teach live, then go on with GoTo and with Forage where they go wrong in new worlds, until they hold."""
    teacher = LiveTeacher(Library(FORAGE_KIT), make_practice, seed, options=METHODS[LIVE], progress=progress)
    teacher.teach(*TOPICS)
    scenario, continued = Forage([0]).scenario, dict[str, Continued]()
    for number, (topic, bindings) in enumerate(((GOTO, GOTO_BINDINGS), (FORAGE, [{}]))):
        before = teacher.presses
        first = FIRST_TESTED + number * FIRST_TESTED
        tested = HoldingTest(partial(NewWorlds, SessionSetup(scenario)), first)
        result = teacher.go_on(topic, tested, bindings, watch=partial(teacher.watch_mistake, scenario))
        continued[topic.name] = Continued(result, teacher.presses - before)
    return TeachingResult(teacher.library, teacher.accounts), continued


def judge(library: Library, seed: int, *, progress: Progress | None = None) -> Evaluation:
    """Evaluate the foraging of a library on the unseen worlds of a teaching seed."""
    return evaluate(library, "forage", NAME, worlds_of(seed), progress=progress)


def judge_corners(library: Library, seed: int) -> dict[str, float]:
    """Return the success in each of the paper's corner cases."""
    seeds = worlds_of(seed)[:CORNER_WORLDS]
    return {
        name: evaluate(library, "forage", settings.scenario(), seeds).success
        for name, settings in make_corner_cases().items()
    }


def frames_of(library: Library, seed: int, *, limit_s: float = 600.0) -> list[RunFrame]:
    """Run a library's Forage in one world until all food is home, and return a frame for each tick."""
    body = Forage([seed])
    engine = Engine.from_program(body, link(library, "forage"))
    frames = []
    while True:
        frames.append(RunFrame(body.view(), (*engine.path(0)[:1], "")[:1]))
        if body.success()[0] or body.time_s >= limit_s:
            return frames
        engine.tick()


def teach_and_judge(seed: int, *, method: str = "watched") -> dict[str, Any]:
    """Teach one robot and evaluate it; return the result as plain data."""
    teaching = teach(seed, method=method)
    accounts, evaluation = teaching.accounts, judge(teaching.library, seed)
    return {
        "seed": seed,
        "examples": {name: account.examples for name, account in accounts.items()}
        | {"total": teaching.examples},
        "presses": sum(account.presses for account in accounts.values()),
        "lessons": sum(account.lessons for account in accounts.values()),
        "teaching_seconds": round(teaching.seconds, 1),
        "worlds": len(evaluation.seeds),
        "success": evaluation.success,
        "relative_to_expert": round(evaluation.relative_to_expert, 4),
        "corner_cases": judge_corners(teaching.library, seed),
    }
