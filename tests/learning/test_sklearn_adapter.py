"""The allow-listed classifiers of scikit-learn: they learn, repeat, and refuse what is not allowed."""

from __future__ import annotations

import sys
from dataclasses import replace
from math import nan, tau
from typing import Any

import numpy as np
import pytest
from tests.make.lessons import make_lesson

from understudy.errors import DefinitionError, UnderstudyError
from understudy.learning.explain import explain
from understudy.learning.fit import learn
from understudy.learning.report import learn_and_report
from understudy.learning.sklearn_adapter import ALLOWED, ClassifierTransition, encode_features
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.lesson import Lesson
from understudy.model.tree import STAY
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

KINDS: list[Kind] = [Continuous(), Toroidal(), Categorical(("a", "b"))]
SHOWN: list[tuple[Any, ...]] = [
    *(("start", [near, angle, 0], "go", "directive") for near in (0, 1, 2) for angle in (0.1, 6.2)),
    *(("start", [far, angle, 1], "start", "confirmation") for far in (7, 8, nan) for angle in (3.0, 3.3)),
    ("go", [1, 1, 0], "go", "default"),
]


def make_classifier_lesson(classifier: str, **parameters: float | int | str | bool | None) -> Lesson:
    return replace(
        make_lesson(SHOWN, KINDS), options=LearnerOptions(learner=SklearnOptions(classifier, parameters))
    )


def test_encoding() -> None:
    assert encode_features((2.0, 0.0, 1.0), KINDS) == [0, 2, 0, 0, 1, 0, 0, 1]
    assert encode_features((nan, nan, nan), KINDS) == [1, 0, 1, 0, 0, 1, 0, 0]
    assert encode_features((0.0, tau / 4, 0.0), KINDS)[3:5] == pytest.approx([1, 0])


@pytest.mark.parametrize("classifier", sorted(ALLOWED))
def test_every_allowed_classifier_learns_and_repeats(classifier: str) -> None:
    parameters: dict[str, int] = {"n_neighbors": 3} if classifier == "KNeighborsClassifier" else {}
    parameters |= {"n_estimators": 5} if classifier == "RandomForestClassifier" else {}
    shown = make_classifier_lesson(classifier, **parameters)
    turned = replace(shown, examples=tuple(reversed(shown.examples)))
    functions, again = learn(shown), learn(turned)
    vectors = [example.values for example in shown.examples if example.state == "start"]
    decided = [functions["start"].decide(values) for values in vectors]
    assert decided == [again["start"].decide(values) for values in vectors]
    assert decided == [1] * 6 + [0] * 6
    assert functions["go"].decide((0.0, 0.0, 0.0)) == 1  # all agree: a leaf
    assert functions["start"].path(vectors[0]) == ((), STAY)


@pytest.mark.parametrize("classifier", sorted(ALLOWED))
def test_deciding_together_is_deciding_alone(classifier: str) -> None:
    function = learn(make_classifier_lesson(classifier))["start"]
    assert isinstance(function, ClassifierTransition)
    rows = np.array(
        [[near, angle, label] for near in (0, 3, 4.5, nan) for angle in (0, 2) for label in (0, 1)]
    )
    assert function.decide_all(rows).tolist() == [function.decide(row) for row in rows.tolist()]
    assert function.decide_at_once(rows).tolist() == [function.decide(row) for row in rows.tolist()]
    assert function.decide_at_once(rows[:0]).tolist() == []


def test_report_and_explanation() -> None:
    shown = make_classifier_lesson("GaussianNB")
    start = learn_and_report(shown).states["start"]
    assert (start.nodes, start.depth, start.disagreements) == (0, 0, 0)
    assert start.conditions == ("decided by GaussianNB of scikit-learn",)
    assert str(explain(shown, "start", (1.0, 0.1, 0.0), learn(shown)["start"])) == "goes to go"


def test_what_is_not_allowed_is_refused() -> None:
    with pytest.raises(
        DefinitionError, match=r"'os\.system' is not allowed; choose one of DecisionTreeClassifier"
    ):
        learn(make_classifier_lesson("os.system"))
    with pytest.raises(DefinitionError, match="parameter 'random_state' is not allowed"):
        learn(make_classifier_lesson("SVC", random_state=3))
    with pytest.raises(DefinitionError, match="scikit-learn cannot fit it"):
        learn(make_classifier_lesson("SVC", C=-1.0))


def test_without_scikit_learn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sklearn.svm", None)
    with pytest.raises(UnderstudyError, match=r"understudy-robots\[sklearn\]"):
        learn(make_classifier_lesson("SVC"))


def test_stateless_and_without_features() -> None:
    bare = replace(
        make_lesson([("start", [], "a", "directive"), ("a", [], "b", "directive")], stateless=True)
    )
    bare = replace(
        bare,
        automaton=replace(bare.automaton, features=()),
        options=LearnerOptions(learner=SklearnOptions("GaussianNB")),
    )
    assert learn(bare)["start"].decide(()) == 1


def test_a_classifier_that_draws_lots_does_not_depend_on_the_order_of_examples() -> None:
    noisy: list[tuple[Any, ...]] = [
        ("start", [index], "go" if index * 7 % 5 < 2 else "start", "directive") for index in range(30)
    ]
    options = LearnerOptions(learner=SklearnOptions("RandomForestClassifier", {"n_estimators": 3}))
    shown = replace(make_lesson(noisy), options=options)
    turned = replace(shown, examples=tuple(reversed(shown.examples)))
    function, again = learn(shown)["start"], learn(turned)["start"]
    grid = [(index / 2,) for index in range(60)]
    assert [function.decide(values) for values in grid] == [again.decide(values) for values in grid]
