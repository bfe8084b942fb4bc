"""The decisions at which a behavior went wrong in new worlds: its state and its feature vector there.

Where it raised its flag elsewhere than shown, this is the decision that raised it. Where it came no nearer, these are
its decisions in the time after that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from understudy.analysis.behavior_run import ProgramRun
from understudy.coaching.advice import WrongDecisions
from understudy.coaching.lesson_analysis import MetDecision
from understudy.falsification.finding_trials import read_own_column
from understudy.falsification.lesson_score import LessonScore
from understudy.falsification.new_worlds import Mistake
from understudy.falsification.session_setup import SessionSetup
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.runtime.feature_columns import FeatureColumns
from understudy.sim.world import World

AFTER_S, EVERY_S = 20.0, 2.0
"""For how long the decisions of a robot that comes no nearer are looked at, and how often, s."""


def find_wrong_decisions(library: Library, setup: SessionSetup, score: LessonScore) -> WrongDecisions:
    """Run a behavior again in the worlds in which it went wrong, and find what it decided there.

    Parameters
    ----------
    library
        The library with the behavior.
    setup
        What runs in the worlds; a robot is trained there.
    score
        The score of the behavior in these worlds.

    Returns
    -------
    WrongDecisions
        The decisions in each failing world.
    """
    by_binding: dict[tuple[tuple[str, str], ...], list[Mistake]] = {}
    for mistake in score.mistakes:
        by_binding.setdefault(tuple(mistake.binding.items()), []).append(mistake)
    why, met = dict[int, str](), list[MetDecision]()
    for binding, mistakes in by_binding.items():
        for mistake, decision in _list_decisions(library, score.behavior, setup, dict(binding), mistakes):
            why.setdefault(mistake.seed, mistake.why)
            met.append(decision)
    return WrongDecisions(score.worlds, why, met)


def _list_decisions(
    library: Library,
    behavior: str,
    setup: SessionSetup,
    binding: Mapping[str, str],
    mistakes: Sequence[Mistake],
) -> Iterator[tuple[Mistake, MetDecision]]:
    """Yield the decisions from each mistake on, with the mistake, until the robot raises a flag."""
    run = setup.start([each.seed for each in mistakes], library, behavior, binding)
    if not isinstance(run, ProgramRun) or not isinstance(run.body, World):
        return
    world = run.body
    engine, features = run.engine, library.taught[behavior].automaton.features
    sensing = FeatureColumns(engine.compiled.features, world)
    looks = _list_looks(mistakes, world.tick_s)
    passed = 0
    for tick in sorted(looks):
        run.advance(tick - passed)
        passed = tick
        columns, now = sensing.columns(world.sense(engine.keys)), float(world.time_s)
        known = dict(zip(engine.compiled.features, columns, strict=True))
        for row in looks[tick]:
            agent = row * world.robots + setup.agent
            number = engine.stacks.state[agent, 0]
            place = engine.compiled.places[number]
            if engine.compiled.tables.states["flag"][number] < 0:
                values = [
                    known[BoundFeature(bound.feature, bound.binding.substitute(place.binding))][agent]
                    if isinstance(bound.feature, Feature)
                    else read_own_column(engine, bound.feature, place, level=0, now=now)[agent]
                    for bound in features
                ]
                met = MetDecision(mistakes[row].seed, now, place.state, tuple(map(float, values)))
                yield mistakes[row], met


def _list_looks(mistakes: Sequence[Mistake], tick_s: float) -> dict[int, list[int]]:
    """List the ticks before which decisions are looked at, with the places of the mistakes that these concern."""
    every, looks = max(1, round(EVERY_S / tick_s)), dict[int, list[int]]()
    for row, mistake in enumerate(mistakes):
        first = max(0, round(mistake.wrong_s / tick_s) - 1)  # it raised its flag by the end of a tick
        later = range(first - first % every + every, first + round(AFTER_S / tick_s), every)
        for tick in (first, *later):
            looks.setdefault(tick, []).append(row)
    return looks
