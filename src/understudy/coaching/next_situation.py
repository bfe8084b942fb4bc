"""The situation in which a press teaches most, found in fresh worlds that the automaton runs in at the engine's speed.

found = find_next_situation(session, seeds=range(100, 140))
go_to_situation(session, found)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from understudy.coaching.fast_forward import stop_watching
from understudy.coaching.lesson_analysis import MetDecision
from understudy.coaching.questions import Question, UncertaintyQueries
from understudy.coaching.reasons_to_ask import UncertaintyModel
from understudy.coaching.repetition import (
    PARTS,
    choose_moment,
    describe_repetition,
    find_repetition,
    make_lesson_distances,
)
from understudy.errors import SessionError
from understudy.learning.fit import learn, learn_automaton
from understudy.model.automaton import Automaton, Transition, query_next_state
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.runtime.body import SeededBody
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.training.session import Session
from understudy.training.trainee import Mode

DURATION_S = 30.0
"""How long the automaton runs in each fresh world, s."""
EVERY_S = 0.5
"""The time between two situations of a world that are looked at, s."""
MOST_DOUBTS, MOST_TRIED = 400, 12
"""How many situations are asked for their doubt, and for how many of them answers are tried."""
MOST_ANSWERS = 3
MOST_DECISIONS = 2000
"""How many decisions are compared before and after an answer."""


@dataclass(frozen=True, slots=True)
class NextSituation:
    """A situation in which a press teaches much.

    Parameters
    ----------
    seed
        Seed of its world.
    question
        The decision that is uncertain there, with the time since the world began.
    change
        The expected share of decisions in fresh worlds that the answer changes, 0 to 1.
    """

    seed: int
    question: Question
    change: float

    @property
    def sentence(self) -> str:
        """Why this situation, for a person."""
        where = f"World {self.seed} after {self.question.time_s:.1f} s: an answer here matters most."
        return f"{where} {self.question.sentence}"


def find_next_situation(
    session: Session,
    *,
    seeds: Sequence[int],
    duration_s: float = DURATION_S,
    queries: UncertaintyQueries | None = None,
) -> NextSituation | None:
    """Find the situation in fresh worlds in which an answer would change most decisions.

    The automaton, as learned so far, runs in one world for each seed. Of the most uncertain situations on its way, the
    one is chosen whose possible answers, each as likely as the doubt says, change most of all decisions met.

    Parameters
    ----------
    session
        A session in live teaching or testing, in a simulated world. It does not change.
    seeds
        Seeds of worlds that the demonstrator has not seen.
    duration_s
        How long the automaton runs in each world, s.
    queries
        What was asked before, and is not asked again before the lesson changes. None: nothing.

    Returns
    -------
    NextSituation or None
        The situation. None if no decision was met, as where the lesson is empty, or all were asked about.

    Raises
    ------
    SessionError
        If the session is in training, or its robot is not one of a simulated world.
    """
    if session.mode is Mode.TRAINING:
        raise SessionError(
            "in training nothing happens without you: switch to live teaching or testing first"
        )
    lesson = session.lesson
    met = run_in_worlds(session, lesson, seeds, duration_s).met
    transitions = learn(lesson)
    doubts = UncertaintyModel(lesson, transitions)
    repeated = _find_repetition(lesson, met, queries)
    if repeated is not None:
        return repeated
    doubtful = _list_doubtful(_thin(met, MOST_DOUBTS), doubts, queries)
    judge = _AnswerJudge(lesson, transitions, _thin(met, MOST_DECISIONS))
    best: tuple[float, MetDecision] | None = None
    for doubt, each in doubtful[:MOST_TRIED]:
        answers = doubts.rank_answers(each.state, each.values)[1 : 1 + MOST_ANSWERS]
        change = doubt * sum(judge.measure_change(each, answer) for answer in answers) / max(1, len(answers))
        if best is None or change > best[0]:
            best = change, each
    if best is None:
        return None
    change, each = best
    answers = doubts.rank_answers(each.state, each.values)[: 1 + MOST_ANSWERS]
    question = Question(
        each.time_s, each.state, each.values, answers[0], doubts.estimate(each.state, each.values), answers
    )
    return NextSituation(each.seed, question, change)


def _find_repetition(
    lesson: Lesson, met: Sequence[MetDecision], queries: UncertaintyQueries | None
) -> NextSituation | None:
    """Find where a robot comes back to the same situation again and again, in one state until its time is over."""
    distances = make_lesson_distances(lesson)
    end_s = max((each.time_s for each in met), default=0.0)
    for last in (each for each in met if each.time_s == end_s):  # others have raised a flag
        count = 0 if queries is None else queries.count_asked_about_repetition(last.state)
        if count >= PARTS:
            continue
        on_its_way = [each for each in met if each.seed == last.seed]
        others = [place for place, each in enumerate(on_its_way, 1) if each.state != last.state]
        stays = on_its_way[others[-1] if others else 0 :]
        rows = np.array([each.values for each in stays])
        moments = find_repetition(rows, distances)
        if moments is None:
            continue
        round_rows = rows[moments.start : moments.stop]
        here = stays[moments[choose_moment(lesson, last.state, round_rows, count)]]
        doubt = describe_repetition(here.state, end_s - stays[0].time_s)
        answers = tuple(dict.fromkeys((here.state, *lesson.automaton.state_names[1:])))
        question = Question(here.time_s, here.state, here.values, here.state, doubt, answers)
        return NextSituation(here.seed, question, len(stays) / len(met))
    return None


def go_to_situation(session: Session, situation: NextSituation) -> None:
    """Begin the world of a situation, and run to it; nothing is learned on the way.

    Parameters
    ----------
    session
        The session in which the situation was found, with the same lesson.
    situation
        The situation.
    """
    with stop_watching(session):
        session.reset(situation.seed)
        session.run_for(max(0.0, situation.question.time_s - session.body.time_s))


def _list_doubtful(
    met: Sequence[MetDecision], doubts: UncertaintyModel, queries: UncertaintyQueries | None
) -> list[tuple[float, MetDecision]]:
    """List the most doubtful decision for each state and reason that was not asked about, most doubtful first."""
    doubtful: dict[tuple[str, str], tuple[float, MetDecision]] = {}
    for each in met:
        doubt = doubts.estimate(each.state, each.values)
        key = each.state, doubt.reason
        if (queries is None or not queries.was_asked(each.state, doubt)) and (
            key not in doubtful or doubt.amount > doubtful[key][0]
        ):
            doubtful[key] = doubt.amount, each
    return sorted(doubtful.values(), key=lambda pair: -pair[0])


class FreshRun(NamedTuple):
    """A run of the automaton in fresh worlds: the decisions that it met, in the order of time, and the last of each."""

    met: list[MetDecision]
    last: list[MetDecision]


def run_in_worlds(session: Session, lesson: Lesson, seeds: Sequence[int], duration_s: float) -> FreshRun:
    """Run the automaton in fresh worlds; see `find_next_situation`."""
    if not isinstance(session.body, SeededBody):
        raise SessionError("only a robot of a simulated world can be placed where a press teaches most")
    world = session.body.with_seeds(seeds)
    automaton = learn_automaton(lesson)
    library = session.library.with_automaton(TrainedAutomaton(automaton))
    taught = link(library, automaton.name, session.view().targets)
    call = session.other_agents.behavior_call
    other = IDLE_PROGRAM if call.behavior is None else link(session.library, call.behavior, call.targets)
    robots = [taught if agent % world.robots == session.agent else other for agent in range(world.agents)]
    engine = Engine(world, robots)
    mine = range(session.agent, world.agents, world.robots)
    met = list(_list_decisions(engine, automaton, seeds, mine, round(duration_s / world.tick_s)))
    return FreshRun(met, _meet_decisions(engine, seeds, mine))


def _meet_decisions(engine: Engine, seeds: Sequence[int], mine: Sequence[int]) -> list[MetDecision]:
    """Read what the agents of all worlds decide on now."""
    now = float(engine.body.time_s)
    decisions = zip(seeds, engine.read_decisions(mine), strict=True)
    return [MetDecision(seed, now, place.state, values) for seed, (place, values) in decisions]


def _list_decisions(
    engine: Engine, automaton: Automaton, seeds: Sequence[int], mine: Sequence[int], ticks: int
) -> Iterator[MetDecision]:
    """Run ticks, and yield the decisions of the agents of all worlds, from time to time, by state."""
    every = max(1, round(EVERY_S / engine.body.tick_s))
    for tick in range(0, ticks, every):
        decisions = _meet_decisions(engine, seeds, mine)
        for name in automaton.transitions:
            yield from (each for each in decisions if each.state == name)
        engine.run(min(every, ticks - tick))


def _thin(met: Sequence[MetDecision], most: int) -> Sequence[MetDecision]:
    """Return at most `most` decisions, spread evenly over all."""
    return met[:: max(1, -(-len(met) // most))]


class _AnswerJudge:
    """A judge of how many decisions an answer would change."""

    def __init__(
        self, lesson: Lesson, transitions: Mapping[str, Transition], met: Sequence[MetDecision]
    ) -> None:
        self._lesson, self._met = lesson, met
        self._decided = self._decide_all(transitions)

    def _decide_all(self, transitions: Mapping[str, Transition]) -> list[str]:
        automaton = replace(self._lesson.automaton, transitions=transitions)
        return [query_next_state(automaton, each.state, each.values) for each in self._met]

    def measure_change(self, each: MetDecision, answer: str) -> float:
        """Return the share of the decisions met that would be others after an answer."""
        number = 1 + max((example.number for example in self._lesson.examples), default=0)
        kind = ExampleKind.CONFIRMATION if answer == each.state else ExampleKind.DIRECTIVE
        example = Example(number, each.state, each.values, answer, kind)
        after = learn(replace(self._lesson, examples=(*self._lesson.examples, example)))
        pairs = zip(self._decide_all(after), self._decided, strict=True)
        return sum(now != before for now, before in pairs) / max(1, len(self._met))
