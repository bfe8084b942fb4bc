"""Small automata made by hand, to check: a robot that approaches something, and what uses it."""

from __future__ import annotations

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.finding import Finding, FindingKind
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior
from understudy.model.features import BoundFeature, Feature, FlagFeature, TimeInState
from understudy.model.library import Kit, Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Toroidal

DISTANCE = BoundFeature(Feature("distance", Continuous(), "distance", unit="m"))
ANGLE = BoundFeature(Feature("angle", Toroidal(360.0), "angle"))
LIGHT = BoundFeature(Feature("light", Categorical(("red", "amber", "green")), "light"))
FULL = BoundFeature(Feature("full", BOOLEAN, "full"))
DONE = BoundFeature(FlagFeature("done"))
TIME = BoundFeature(TimeInState())
FEATURES = (DISTANCE, ANGLE, LIGHT, FULL, DONE, TIME)
AHEAD, BACK = State("ahead", "forward"), State("back", "backward")
KIT = Kit.from_parts(
    *(bound.feature for bound in FEATURES), Behavior("forward"), Behavior("backward"), Behavior("wait")
)


def always(outcome: int) -> Tree:
    """A tree that answers one state."""
    return Tree((make_leaf(outcome),))


def below(bound: float, then: int, otherwise: int, *, feature: int = 0, absent: int = STAY) -> Tree:
    """A tree that answers one state below a bound and another from it on; `absent` is the node for absence."""
    test = Node(TestKind.BELOW, feature, high=bound, yes=1, no=2, absent=absent)
    return Tree((test, make_leaf(then), make_leaf(otherwise)))


def arc(low: float, high: float, then: int, otherwise: int, *, feature: int = 1) -> Tree:
    """A tree that answers one state on an arc and another elsewhere; wherever it is absent, too."""
    test = Node(TestKind.ARC, feature, low, high, yes=1, no=2, absent=2)
    return Tree((test, make_leaf(then), make_leaf(otherwise)))


def labels(feature: int, *outcomes: int) -> Tree:
    """A tree that answers a state for each label; STAY: no example had this label."""
    shown = [outcome for outcome in outcomes if outcome != STAY]
    branches = tuple(STAY if outcome == STAY else 1 + shown.index(outcome) for outcome in outcomes)
    return Tree((Node(TestKind.LABEL, feature, branches=branches), *map(make_leaf, shown)))


def make_automaton(name: str, states: tuple[State, ...], **trees: Tree) -> Automaton:
    """An automaton with all `FEATURES`, a start state, the given states, and trees by state."""
    return Automaton(name, (START, *states), FEATURES, transitions=trees)


def find(*automata: Automaton, kind: FindingKind) -> list[Finding]:
    """The findings of one kind on the last of some automata, without a scenario."""
    library = Library.from_automata(KIT, *automata)
    report = check_library(library, [automata[-1].name], kit_known=True)
    return [each for each in report.findings if each.kind is kind]


def list_unused(finding: Finding) -> list[str]:
    """The features that a finding says decide nothing."""
    names, decides, _ = finding.sentence.partition(" decide")
    return names.replace(" and ", ", ").split(", ") if decides else []
