"""DAgger (Ross, Gordon and Bagnell 2011): the robot does what was learned so far, and the teacher says what is right.

The first decisions are demonstrated; then rounds in which the policy of all ticks so far is aboard. What is counted as
a decision is a label that changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from understudy_lab.baselines.demonstrations import Demonstrator
from understudy_lab.baselines.recording_body import OnboardPolicy, RecordedTicks
from understudy_lab.baselines.tasks import BaselineTask

Learn: TypeAlias = Callable[[RecordedTicks], OnboardPolicy]

MOST_WORLDS = 25
"""So many worlds there are in a round, at most."""


def aggregate_rounds(
    exercise: BaselineTask, seed: int, learn: Learn, *, rounds: Sequence[int]
) -> RecordedTicks:
    """All ticks of rounds that each end with so many decisions; the first round is demonstrated.

    In the others the teacher demonstrates in every other world: a policy that gets nowhere shows nothing of the rest.
    """
    demonstrator = Demonstrator(exercise, seed)
    for decisions in rounds:
        policy = learn(demonstrator.ticks) if demonstrator.presses else None
        for world in range(MOST_WORLDS):
            demonstrator.show(aboard=policy if world % 2 == 0 else None, most=decisions)
            if demonstrator.presses >= decisions:
                break
    return demonstrator.ticks
