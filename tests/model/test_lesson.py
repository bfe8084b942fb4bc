"""What a lesson refuses."""

from __future__ import annotations

from typing import Any

import pytest

from understudy.errors import DefinitionError
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import Automaton
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Lesson


@pytest.mark.parametrize("order", ["foo", "", None])
def test_an_unknown_order(order: Any) -> None:
    with pytest.raises(DefinitionError, match="'gain first' or 'flags first'"):
        TreeOptions(order=order)


@pytest.mark.parametrize("boundary", ["foo", "", None])
def test_an_unknown_boundary(boundary: Any) -> None:
    with pytest.raises(DefinitionError, match="give 'default keeps the gap' or 'midpoint'"):
        TreeOptions(boundary)


@pytest.mark.parametrize("reaction_s", [-0.1, 1.1, float("nan")])
def test_a_reaction_time_that_the_record_does_not_reach(reaction_s: float) -> None:
    with pytest.raises(DefinitionError, match="between 0 and"):
        LearnerOptions(reaction_s=reaction_s)


def test_a_lesson_for_what_is_already_learned() -> None:
    taught = Automaton("goto")
    assert learn_automaton(Lesson(taught)) == taught
