"""Fresh worlds in which the automaton in training raises a flag elsewhere than shown: a mistake to correct first.

A raised flag ends what the robot does, so no later decision is in doubt, and no question would lead there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.coaching.next_situation import NextSituation, run_in_worlds
from understudy.coaching.questions import Question, UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason, Uncertainty
from understudy.learning.shown_ranges import find_shown_range
from understudy.training.session import Session

DURATION_S = 60.0
"""The longest run of the automaton in each fresh world, s."""


def find_raised_elsewhere(
    session: Session, *, seeds: Sequence[int], queries: UncertaintyQueries | None = None
) -> NextSituation | None:
    """Find the last moment before a flag is raised elsewhere than shown, in the first fresh world where it is.

    Parameters
    ----------
    session
        A session in live teaching or testing, in a simulated world. It does not change.
    seeds
        Seeds of worlds that the demonstrator has not seen.
    queries
        What was asked before, and is not asked again before the lesson changes. None: nothing.

    Returns
    -------
    NextSituation or None
        The situation. None if each flag is raised where it was shown, or that is not known, or was asked about.

    Raises
    ------
    SessionError
        If the robot is not one of a simulated world.
    """
    lesson = session.lesson
    flags = [state for state in lesson.automaton.states if state.flag is not None]
    range_of = {state.name: find_shown_range(lesson, state.flag) for state in flags if state.flag is not None}
    ranges = {name: each for name, each in range_of.items() if each is not None}
    if not ranges:
        return None
    run = run_in_worlds(session, lesson, seeds, DURATION_S)
    for row, seed in enumerate(seeds):
        state = run.last[row].state
        each = ranges.get(state)
        if each is None:
            continue
        value = run.last[row].values[lesson.automaton.features.index(each.feature)]
        if each.contains(np.array([value]))[0]:
            continue
        before = [met for met in run.met if met.seed == seed]
        reason = f"{state} was shown only where {each.feature} is {each.describe()}"
        doubt = Uncertainty(1.0, DoubtReason.ELSEWHERE, reason)
        if not before or (queries is not None and queries.was_asked(before[-1].state, doubt)):
            continue
        last = before[-1]
        answers = tuple(dict.fromkeys((state, last.state, *lesson.automaton.state_names[1:])))
        question = Question(last.time_s, last.state, last.values, state, doubt, answers)
        return NextSituation(seed, question, 1 / len(seeds))
    return None
