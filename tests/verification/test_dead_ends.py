"""States that stay once what they run has raised its flag: in which cell, and whether anything leads out."""

from __future__ import annotations

import pytest
from tests.verification.automata import AHEAD, DONE, KIT, always, below, labels, make_automaton

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.scenario_facts import ScenarioFacts
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Continuous

FULL, FLAG, TIME = 3, 4, 5  # positions among the features
GO = make_automaton("go", (AHEAD, State("done", flag="done")), start=always(1), ahead=below(1.0, 2, 1))
"""Raises done where the distance is below 1."""
STATES = (State("go", "go"), State("wait", "wait"))


def dead_ends(*automata: Automaton, still: str = "") -> list[Finding]:
    library = Library.from_automata(KIT, *automata)
    facts = ScenarioFacts(still_readings=frozenset(still.split()))
    found = check_library(library, [automata[-1].name], facts=facts).findings
    return [each for each in found if each.kind is FindingKind.DEAD_END]


def fetch(tree: Tree) -> Automaton:
    return make_automaton("fetch", STATES, start=always(1), go=tree, wait=labels(FULL, 2, 1))


def flag(no: int, yes: Tree) -> Tree:
    """A tree that answers one state before the flag is raised, and asks another tree afterwards."""

    def move(child: int) -> int:
        return child if child == STAY else child + 2

    moved = [
        node
        if node.test == TestKind.LEAF
        else node._replace(
            yes=move(node.yes), no=move(node.no), branches=tuple(move(each) for each in node.branches)
        )
        for node in yes.nodes
    ]
    return Tree((Node(TestKind.LABEL, FLAG, branches=(1, 2)), make_leaf(no), *moved))


STUCK = Tree(
    (
        Node(TestKind.LABEL, FLAG, branches=(1, 2)),
        Node(TestKind.LABEL, FULL, branches=(2, 3)),
        make_leaf(1),
        make_leaf(2),
    )
)
"""While go is not done, it leads on when full; once go is done, it stays."""

ROWS = [  # the tree of go in fetch, readings that stand still, severity, where
    (labels(FLAG, 1, 2), "", None, ""),  # done leads on
    (labels(FLAG, 2, 1), "", None, ""),  # it leads on before
    (STUCK, "", "error", "where full is no or absent"),
    (labels(FLAG, 1, 1), "", None, ""),  # nothing leads on at all: that is another finding
    (labels(FULL, 1, 2), "", "warning", "where full is no or absent"),  # it does not ask about done
    (labels(FULL, 1, 2), "full", "error", "where full is no or absent"),
    (flag(2, labels(FULL, 1, 2)), "", None, ""),  # it leaves before go is done
    (flag(1, labels(FULL, 1, 2)), "", "warning", "where full is no or absent"),
    (below(1.0, 1, 2), "", "warning", "for ever: go idles"),  # unless the distance grows by itself
    (below(1.0, 1, 2), "distance", "error", "whatever it reads"),
    (below(1.0, 2, 1), "", None, ""),  # done is raised only below 1, and from there it leads on
    (below(0.5, 2, 1), "", "warning", "where distance is between 0.5 m and 1 m"),
    (below(0.5, 2, 1), "distance", "error", "where distance is between 0.5 m and 1 m"),
    (below(0.5, 2, 1), "full", "warning", "where distance is between 0.5 m and 1 m"),
    (flag(1, below(3.0, 1, 2, feature=TIME)), "distance full", None, ""),  # after 3 s it leads on
]


@pytest.mark.parametrize(("tree", "still", "severity", "where"), ROWS)
def test_where_a_state_waits_for_ever(tree: Tree, still: str, severity: str | None, where: str) -> None:
    found = dead_ends(GO, fetch(tree), still=still)
    assert [each.severity for each in found] == ([] if severity is None else [severity])
    for each in found:
        assert each.states == ("go",)
        assert where in each.sentence


def test_what_may_still_change_is_assumed_not_to() -> None:
    (found,) = dead_ends(GO, fetch(labels(FULL, 1, 2)))
    assert "nothing else changes full while go idles" in found.assumptions
    (certain,) = dead_ends(GO, fetch(below(1.0, 1, 2)), still="distance")
    assert certain.is_certain


def test_what_a_flag_needs_two_levels_below() -> None:
    """The middle is done only once go is, so only below 1, and there the top leads on."""
    middle = make_automaton(
        "middle", (State("go", "go"), State("done", flag="done")), start=always(1), go=labels(FLAG, 1, 2)
    )
    run = (State("middle", "middle"), State("wait", "wait"))
    top = make_automaton("top", run, start=always(1), middle=below(1.0, 2, 1), wait=labels(FULL, 2, 1))
    late = make_automaton("top", run, start=always(1), middle=below(0.5, 2, 1), wait=labels(FULL, 2, 1))
    assert not dead_ends(GO, middle, top)
    assert len(dead_ends(GO, middle, late)) == 1


def test_an_automaton_that_stops_it_makes_it_a_warning() -> None:
    stuck = fetch(STUCK)
    patient = make_automaton("top", (State("fetch", "fetch"),), start=always(1), fetch=labels(FLAG, 1, 0))
    hasty = make_automaton(
        "top", (State("fetch", "fetch"),), start=always(1), fetch=below(5.0, 1, 0, feature=TIME)
    )
    for top, severity in ((patient, Severity.ERROR), (hasty, Severity.WARNING)):
        library = Library.from_automata(KIT, GO, stuck, top)
        (found,) = [
            each for each in check_library(library, ["fetch"]).findings if each.kind is FindingKind.DEAD_END
        ]
        assert found.severity is severity
        assert ("unless top stops fetch" in found.sentence) == (severity is Severity.WARNING)


def test_it_is_the_first_finding() -> None:
    stuck = fetch(STUCK)
    lost = make_automaton(
        "lost", (AHEAD, State("back", "backward")), start=always(1), ahead=labels(FULL, 1, 0)
    )
    found = check_library(Library.from_automata(KIT, lost, GO, stuck)).findings
    assert found[0].kind is FindingKind.DEAD_END
    assert "error" in {each.severity for each in found[1:]}  # back is never entered


def test_a_state_whose_readings_its_own_kind_lacks_is_left_alone() -> None:
    """A basic behavior raises no flag, and goes on: no dead end."""
    alone = Automaton(
        "alone",
        (START, AHEAD),
        (BoundFeature(Feature("distance", Continuous(), "distance")), DONE),
        transitions={"start": always(1), "ahead": below(1.0, 0, STAY)},
    )
    assert not dead_ends(alone)
