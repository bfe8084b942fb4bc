"""Coordinators: orders that no member can follow, statistics that an order keeps down, orders given again and again."""

from __future__ import annotations

from collections.abc import Sequence

from tests.verification.automata import AHEAD, KIT, always, below, labels, make_automaton

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.coordinators import SquadMembers
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.model.squad import Assignment, Order, Role, Squad, Statistic
from understudy.model.tree import Tree
from understudy.model.value_kinds import BOOLEAN
from understudy.runtime.body import Reading
from understudy.runtime.team.squad_kit import make_squad_kit

SEEN = Reading("seen", BOOLEAN)
GO = make_automaton("go", (AHEAD, State("done", flag="done")), start=always(1), ahead=below(1.0, 2, 1))
AT_ONCE = make_automaton("at_once", (State("done", flag="done"),), start=below(1.0, 1, 0))
STATISTICS = (
    Statistic("all_done", "all", flag="done"),
    Statistic("someone_sees", "any", reading="seen"),
)
SQUAD = Squad("team", (Role("robots", "robot"),), STATISTICS, {"lost": Order((Assignment("vanish"),))})
ROBOTS = Library.from_automata(KIT, GO, AT_ONCE)


def check(states: Sequence[State], **trees: Tree) -> list[Finding]:
    """The findings on a coordinator with the features all_done and someone_sees."""
    kit = make_squad_kit(SQUAD, (SEEN,), {"robot": ROBOTS, "robots": ROBOTS})
    features = tuple(BoundFeature(kit.features[name]) for name in ("all_done", "someone_sees"))
    assert isinstance(features[0].feature, Feature)
    assert features[0].feature.fresh == 0.0
    automaton = Automaton("lead", (START, *states), features, transitions=trees)
    members = SquadMembers(SQUAD, {"robots": ROBOTS})
    report = check_library(Library.from_automata(kit, automaton), kit_known=True, members=members)
    return [each for each in report.findings if each.kind is not FindingKind.UNUSED_FEATURE]


def kinds(found: Sequence[Finding]) -> set[FindingKind]:
    return {each.kind for each in found if each.severity is not Severity.NOTE}


DONE, SEES = 0, 1  # positions among the features
ONE, TWO = State("one", "go"), State("two", "wait")


def test_orders_that_no_member_has_a_behavior_for() -> None:
    for behavior, missing in (("lost", "vanish"), ("nowhere", "nowhere")):
        found = check([State("one", behavior)], start=always(1), one=labels(SEES, 0, 1))
        (lost,) = [each for each in found if each.kind is FindingKind.MISSING_BEHAVIOR]
        assert lost.states == ("one",)
        assert f"orders {missing}" in lost.sentence
    assert FindingKind.MISSING_BEHAVIOR not in kinds(check([ONE], start=always(1), one=labels(SEES, 0, 1)))


def test_waiting_for_a_flag_that_the_ordered_behavior_cannot_raise() -> None:
    waits = labels(DONE, 1, 2)
    assert not kinds(check([ONE, TWO], start=always(1), one=waits, two=labels(SEES, 0, 2)))
    basic = [State("one", "wait"), TWO]
    found = check(basic, start=always(1), one=waits, two=labels(SEES, 0, 2))
    (flag,) = [each for each in found if each.kind is FindingKind.FLAG_NEVER_RAISED]
    assert flag.states == ("one",)
    assert flag.is_certain


def test_orders_in_turn_at_every_tick() -> None:
    """With someone in sight both orders are replaced at once; without, the coordinator stays."""
    found = check([ONE, TWO], start=always(1), one=labels(SEES, 1, 2), two=labels(SEES, 2, 1))
    (turn,) = [each for each in found if each.kind is FindingKind.REPEATED_ORDER]
    assert turn.states == ("one", "two")
    repaired = check([ONE, TWO], start=always(1), one=labels(SEES, 1, 2), two=labels(SEES, 1, 2))
    assert not kinds(repaired)


def test_the_same_order_again_whenever_the_members_are_done() -> None:
    again = State("again", "go")
    found = check([ONE, again], start=always(1), one=labels(DONE, 1, 2), again=labels(DONE, 2, 1))
    (repeated,) = [each for each in found if each.kind is FindingKind.REPEATED_ORDER]
    assert "orders go again and again" in repeated.sentence
    assert repeated.assumptions
    patrols = check([ONE, TWO], start=always(1), one=labels(DONE, 1, 2), two=labels(SEES, 1, 2))
    assert FindingKind.REPEATED_ORDER not in kinds(patrols)


def test_a_member_that_may_be_done_at_once_is_an_assumption() -> None:
    """Orders are replaced at every tick unless members are done in the very tick of the order."""
    quick = [State("one", "at_once"), State("two", "at_once")]
    trees = {"one": labels(DONE, 2, 1), "two": labels(DONE, 1, 2)}
    (found,) = [
        each
        for each in check(quick, start=always(1), **trees)
        if each.kind is FindingKind.REPEATED_ORDER and "without end" in each.sentence
    ]
    assert any("in which it is restarted" in each for each in found.assumptions)
    slow = [ONE, State("two", "go")]
    (sure,) = [
        each
        for each in check(slow, start=always(1), **trees)
        if each.kind is FindingKind.REPEATED_ORDER and "without end" in each.sentence
    ]
    assert not any("in which it is restarted" in each for each in sure.assumptions)


def test_behaviors_of_a_squad_kit_are_orders() -> None:
    kit = make_squad_kit(SQUAD, (SEEN,), {"robot": ROBOTS, "robots": ROBOTS})
    assert isinstance(kit.behaviors["go"], Behavior)
    assert kit.behaviors["lost"].order == Order((Assignment("vanish"),))
