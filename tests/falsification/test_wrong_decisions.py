"""Decisions at which a robot goes wrong, 3 m from a ball that it is to reach: where it stands can be worked out."""

from __future__ import annotations

from dataclasses import replace

import pytest
from msgspec import structs
from tests.falsification.test_finding_trials import AHEAD, KIT, LEFT, SCENARIO, always, distance

from understudy.addons.checks.falsification.lesson_score import find_wrong_decisions, score_behavior
from understudy.addons.checks.falsification.new_worlds import NewWorlds
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.coaching.advice import WrongDecisions
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf

DONE = State("done", flag="done")
LONGER = structs.replace(SCENARIO, limit_s=10.0)
SECONDS = BoundFeature(TimeInState())


def below(feature: int, high: float, yes: int, no: int) -> Tree:
    return Tree((Node(TestKind.BELOW, feature, high=high, yes=1, no=2), make_leaf(yes), make_leaf(no)))


def find_wrong(does: State, leaves: Tree) -> WrongDecisions:
    """Let a robot do something at once, and be done by a tree; done was shown within 0.3 m."""
    features, states = (distance("ball"), SECONDS), (START, does, DONE)
    automaton = Automaton("reach", states, features, transitions={"start": always(1), does.name: leaves})
    presses = [(0.1, "done", ExampleKind.DIRECTIVE), (0.3, "done", ExampleKind.DIRECTIVE)]
    presses += [(meters, does.name, ExampleKind.CONFIRMATION) for meters in (0.5, 3.0)]
    examples = [
        Example(number, does.name, (meters, 0.0), following, kind)
        for number, (meters, following, kind) in enumerate(presses)
    ]
    taught = TrainedAutomaton(automaton, Lesson(replace(automaton, transitions={}), tuple(examples)))
    library = Library(KIT).with_automaton(taught)
    score = score_behavior(library, "reach", NewWorlds(SessionSetup(LONGER), [1, 2]), [{}])
    return find_wrong_decisions(library, SessionSetup(LONGER), score)


def test_a_flag_far_off_is_the_decision_that_raised_it() -> None:
    wrong = find_wrong(AHEAD, below(0, 2.0, yes=2, no=STAY))
    assert (wrong.worlds, [*wrong.why], [each.seed for each in wrong.met]) == (2, [1, 2], [1, 2])
    for each in wrong.met:
        assert each.state == "ahead"
        assert 1.8 < each.values[0] < 2.0
        assert wrong.why[each.seed].startswith("done where distance_to(ball) is ")


def test_own_features_are_those_of_the_decision() -> None:
    wrong = find_wrong(AHEAD, below(1, 1.0, yes=STAY, no=2))
    assert [(each.seed, each.state) for each in wrong.met] == [(1, "ahead"), (2, "ahead")]
    assert wrong.met[0].values[1] == pytest.approx(1.0)


def test_a_robot_that_comes_no_nearer_is_looked_at_for_a_while() -> None:
    wrong = find_wrong(LEFT, below(0, 0.3, yes=2, no=STAY))
    met = [each for each in wrong.met if each.seed == 1]
    assert len(met) > 5
    assert {(each.state, round(each.values[0], 6)) for each in met} == {("left", 3.0)}


def test_where_it_works_nothing_is_wrong() -> None:
    assert find_wrong(AHEAD, below(0, 0.3, yes=2, no=STAY)) == WrongDecisions(2, {}, [])
