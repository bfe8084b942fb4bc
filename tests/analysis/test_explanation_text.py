"""Sentences of explanations: what a decision, a switch and a level at rest are described as."""

from __future__ import annotations

import pytest

from understudy.judging.explain_run import LevelExplanation
from understudy.judging.explanation_text import (
    describe_decision,
    describe_intention,
    describe_present,
    describe_rest,
    describe_switch,
    list_examples,
)
from understudy.learning.explain import Explanation
from understudy.model.lesson import Example, ExampleKind

NEAR, AROUND = "distance_to(A) is below 0.35 m", "angle_to(A) is between −10° and 10°"
PRESSED = tuple(Example(number, "forward", (), "done", ExampleKind.DIRECTIVE) for number in range(8))
WATCHED = Example(8, "forward", (), "done", ExampleKind.WATCHED)
LEFT = Explanation("forward", "done", (NEAR,), PRESSED[3:5], shown=True)

DECISIONS = [  # next state, conditions, whether it was shown, the sentence
    ("done", (NEAR,), True, f"goes from forward to done because {NEAR}"),
    ("forward", (NEAR,), True, f"stays in forward because {NEAR}"),
    ("done", (), True, "goes from forward to done, always"),
    ("forward", (NEAR,), False, f"stays in forward: there are no examples where {NEAR}"),
    ("forward", (), False, "stays in forward: there are no examples there"),
    (
        "done",
        (NEAR, AROUND),
        True,
        f"goes from forward to done because {NEAR} and angle_to(A) is between −10° and 10°",
    ),
]


@pytest.mark.parametrize(("following", "conditions", "shown", "sentence"), DECISIONS)
def test_a_decision(following: str, conditions: tuple[str, ...], shown: bool, sentence: str) -> None:
    assert describe_decision(Explanation("forward", following, conditions, shown=shown)) == sentence


def test_a_switch_is_explained_by_what_is_known_now() -> None:
    assert describe_switch("forward", "done", LEFT) == f"went from forward to done because {NEAR}"
    otherwise = describe_switch("forward", "left", LEFT, " (shown by 3)")
    assert otherwise == (
        f"went from forward to left; by now it goes from forward to done because {NEAR} (shown by 3)"
    )


EXAMPLES = [  # examples behind a decision, how they are named
    (PRESSED[3:5], " (shown by 3, 4)"),
    (PRESSED, " (shown by 0, 1, 2, 3, 4, 5…)"),
    ((*PRESSED[:1], WATCHED), " (shown by 0)"),
    ((WATCHED,), ""),
]


@pytest.mark.parametrize(("examples", "named"), EXAMPLES)
def test_examples(examples: tuple[Example, ...], named: str) -> None:
    assert list_examples(Explanation("forward", "done", (), examples, shown=True)) == named
    assert list_examples(Explanation("forward", "forward", (), examples)) == ""


def test_a_raised_flag() -> None:
    assert describe_present(None, "done") == "It raised done; a flag state is never left."
    assert describe_intention(None) == "A raised flag is never left."
    assert describe_present(LEFT, None) == f"It goes from forward to done because {NEAR} (shown by 3, 4)."
    assert describe_rest(LevelExplanation("goto", "done", 0.0, None, None, "done")) == (
        "done is raised; a flag state is never left"
    )
    assert (
        describe_rest(LevelExplanation("goto", "forward", 0.0, None, None, None))
        == "there are no examples there"
    )
