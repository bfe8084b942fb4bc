"""States never entered or left, flags never raised, behaviors that are missing: each beside its repaired twin."""

from __future__ import annotations

import pytest
from tests.verification.automata import AHEAD, BACK, always, below, find, labels, make_automaton

from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.model.automaton import START, Automaton, State

ARRIVED = State("done", flag="done")
FULL, DONE = 3, 4  # positions among the features


def test_a_state_that_no_leaf_leads_to_is_never_entered() -> None:
    stays = make_automaton("go", (AHEAD, BACK), start=always(1), ahead=below(1.0, 1, 1))
    leads = make_automaton("go", (AHEAD, BACK), start=always(1), ahead=below(1.0, 2, 1))
    (found,) = find(stays, kind=FindingKind.NEVER_ENTERED)
    assert found.states == ("back",)
    assert found.severity is Severity.ERROR
    assert found.is_certain
    assert not find(leads, kind=FindingKind.NEVER_ENTERED)


def test_states_that_lead_only_to_each_other_are_never_entered() -> None:
    apart = make_automaton("go", (AHEAD, BACK, ARRIVED), start=always(0), ahead=always(2), back=always(1))
    assert [each.states for each in find(apart, kind=FindingKind.NEVER_ENTERED)] == [
        ("ahead",),
        ("back",),
        ("done",),
    ]


@pytest.mark.parametrize(
    ("tree", "left"),
    [
        (below(1.0, 1, 1), False),
        (below(1.0, 2, 1), True),
        (labels(2, 1, 1, 1), False),
        (labels(2, 1, 1, 2), True),
    ],
)
def test_a_state_without_a_leaf_that_leads_elsewhere_is_never_left(tree: object, left: bool) -> None:
    automaton = make_automaton("go", (AHEAD, BACK), start=always(1), ahead=tree, back=always(1))  # type: ignore[arg-type]
    assert [each.states for each in find(automaton, kind=FindingKind.NEVER_LEFT)] == (
        [] if left else [("ahead",)]
    )


def test_a_state_without_a_tree_is_never_left_and_a_flag_state_may_rest() -> None:
    untaught = make_automaton("go", (AHEAD, ARRIVED), start=always(1))
    ends = make_automaton("go", (AHEAD, ARRIVED), start=always(1), ahead=below(1.0, 2, 1))
    assert [each.states for each in find(untaught, kind=FindingKind.NEVER_LEFT)] == [("ahead",)]
    assert not find(ends, kind=FindingKind.NEVER_LEFT)


def test_a_start_state_that_is_never_left_is_an_error() -> None:
    (found,) = find(make_automaton("go", (AHEAD,)), kind=FindingKind.NEVER_LEFT)
    assert found.severity is Severity.ERROR


GO = make_automaton("go", (AHEAD, ARRIVED), start=always(1), ahead=below(1.0, 2, 1))
NEVER_DONE = make_automaton("go", (AHEAD, ARRIVED), start=always(1), ahead=always(1))
WITHOUT = make_automaton("go", (AHEAD,), start=always(1), ahead=always(1))
GOES = (State("go", "go"), State("wait", "wait"))


def user(child_waits: bool = True) -> Automaton:
    """An automaton that runs go, and waits for done in go or, in vain, in wait."""
    done, stay = labels(DONE, 1, 2), labels(DONE, 2, 1)
    return make_automaton(
        "fetch", GOES, start=always(1), go=done, wait=labels(FULL, 2, 1) if child_waits else stay
    )


def waits(*automata: Automaton) -> list[Finding]:
    return find(*automata, kind=FindingKind.FLAG_NEVER_RAISED)


def test_waiting_for_a_flag_that_its_automaton_cannot_raise() -> None:
    assert not waits(GO, user())
    for child in (NEVER_DONE, WITHOUT):
        (found,) = waits(child, user())
        assert found.states == ("go",)
        assert found.severity is Severity.ERROR  # go is left only by the flag
        assert found.is_certain


def test_waiting_for_a_flag_of_a_basic_behavior() -> None:
    (found,) = waits(GO, user(child_waits=False))
    assert found.states == ("wait",)
    assert "wait is a basic behavior" in found.sentence


def test_a_flag_is_raised_only_if_its_state_can_be_entered() -> None:
    """Nested twice: the middle never raises its flag because what it runs never does."""
    middle = make_automaton("middle", (State("go", "go"), ARRIVED), start=always(1), go=labels(DONE, 1, 2))
    top = make_automaton(
        "top", (State("m", "middle"), State("wait", "wait")), start=always(1), m=labels(DONE, 1, 2)
    )
    assert not waits(GO, middle, top)
    assert [each.states for each in waits(NEVER_DONE, middle, top)] == [("m",)]


def test_a_behavior_that_is_nowhere() -> None:
    lost = make_automaton("go", (State("fly", "fly"),), start=always(1), fly=below(1.0, 0, 1))
    assert [each.states for each in find(lost, kind=FindingKind.MISSING_BEHAVIOR)] == [("fly",)]
    assert not find(GO, kind=FindingKind.MISSING_BEHAVIOR)


def test_states_of_an_automaton_without_features_are_entered_and_left() -> None:
    ahead = Automaton("go", (START, AHEAD), (), transitions={"start": always(1), "ahead": always(0)})
    assert not find(ahead, kind=FindingKind.NEVER_ENTERED)
    assert not find(ahead, kind=FindingKind.NEVER_LEFT)
    (found,) = find(ahead, kind=FindingKind.CHATTER)
    assert found.is_certain
