"""From the trees of a document back to transition functions that are sure to come to an end."""

from __future__ import annotations

from collections.abc import Mapping

from understudy.errors import join_names
from understudy.model.automaton import Automaton
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.storage.encode import EVERY_STATE
from understudy.storage.json_text import JsonSteps, Source
from understudy.storage.schema import (
    AbsentDoc,
    ArcDoc,
    BelowDoc,
    BuiltDoc,
    ChildDoc,
    GoDoc,
    LabelDoc,
    NodeDoc,
    StayDoc,
)


def decode_trees(doc: BuiltDoc, automaton: Automaton, source: Source) -> Mapping[str, Tree]:
    """The tree of each state."""
    here: JsonSteps = ("built", "trees")
    movable = [state.name for state in automaton.states if state.flag is None]
    if automaton.stateless and EVERY_STATE in doc.trees and EVERY_STATE not in automaton.state_names:
        if list(doc.trees) != [EVERY_STATE]:
            problem = f"there are trees beside {EVERY_STATE!r}, which stands for every state"
            raise source.wrong(here, problem, "keep one or the other")
        shared = _tree(doc.trees[EVERY_STATE], automaton, source, (*here, EVERY_STATE))
        return dict.fromkeys(movable, shared)
    for name in doc.trees:
        if name not in movable:
            problem = f"there is a tree for {name!r}, which is no state of {automaton.name!r} to be left"
            raise source.wrong((*here, name), problem, f"give trees to {join_names(movable)} only")
    return {name: _tree(nodes, automaton, source, (*here, name)) for name, nodes in doc.trees.items()}


def _tree(nodes: list[NodeDoc], automaton: Automaton, source: Source, here: JsonSteps) -> Tree:
    if not nodes:
        raise source.wrong(here, "this tree has no nodes", "leave the tree out where a state keeps itself")
    reader = _Nodes(automaton, len(nodes), source)
    return Tree(tuple(reader.node(node, index, (*here, index)) for index, node in enumerate(nodes)))


class _Nodes:
    """Reads the nodes of one tree."""

    def __init__(self, automaton: Automaton, length: int, source: Source) -> None:
        self.automaton, self.length, self.source = automaton, length, source
        self.names = [str(bound) for bound in automaton.features]

    def node(self, doc: NodeDoc, index: int, here: JsonSteps) -> Node:
        if isinstance(doc, StayDoc):
            return make_leaf(STAY)
        if isinstance(doc, GoDoc):
            if doc.to not in self.automaton.state_names:
                problem = f"it goes to {doc.to!r}, which is no state of automaton {self.automaton.name!r}"
                remedy = f"name one of its states: {join_names(self.automaton.state_names)}"
                raise self.source.wrong((*here, "to"), problem, remedy)
            return make_leaf(self.automaton.index(doc.to))
        feature = self.feature(doc.feature, here)
        if isinstance(doc, LabelDoc):
            return self.label(doc, feature, index, here)
        yes, no = self.child(doc.yes, index, (*here, "yes")), self.child(doc.no, index, (*here, "no"))
        if isinstance(doc, AbsentDoc):
            return Node(TestKind.ABSENT, feature, yes=yes, no=no)
        kind = self.automaton.features[feature].kind
        absent = self.child(doc.absent, index, (*here, "absent"))
        if isinstance(kind, Categorical):
            raise self.source.wrong(
                here, f"feature {doc.feature} has labels, not numbers", "test it by label"
            )
        if isinstance(doc, BelowDoc):
            return Node(TestKind.BELOW, feature, high=doc.cut, yes=yes, no=no, absent=absent)
        return self.arc(doc, kind, Node(TestKind.ARC, feature, doc.low, doc.high, yes, no, absent), here)

    def arc(self, doc: ArcDoc, kind: object, node: Node, here: JsonSteps) -> Node:
        if not isinstance(kind, Toroidal):
            raise self.source.wrong(
                here, f"feature {doc.feature} is not toroidal: it has no arcs", "test it by a cut"
            )
        return node

    def label(self, doc: LabelDoc, feature: int, index: int, here: JsonSteps) -> Node:
        kind = self.automaton.features[feature].kind
        labels = kind.labels if isinstance(kind, Categorical) else ()
        if set(doc.branches) != set(labels):
            right = f"give one each for {join_names(labels)}" if labels else "test it by a cut"
            problem = f"feature {doc.feature} is {kind}, but the branches are for {join_names(doc.branches)}"
            raise self.source.wrong((*here, "branches"), problem, right)
        branches = tuple(
            self.child(doc.branches[label], index, (*here, "branches", label)) for label in labels
        )
        absent = self.child(doc.absent, index, (*here, "absent"))
        return Node(TestKind.LABEL, feature, absent=absent, branches=branches)

    def feature(self, name: str, here: JsonSteps) -> int:
        if name not in self.names:
            problem = f"it tests {name!r}, which is no feature of automaton {self.automaton.name!r}"
            raise self.source.wrong(
                (*here, "feature"), problem, f"name one of its features: {join_names(self.names)}"
            )
        return self.names.index(name)

    def child(self, child: ChildDoc, parent: int, here: JsonSteps) -> int:
        if child == "stay":
            return STAY
        if child >= self.length:
            problem = f"it leads to node {child}, but the tree has nodes 0 to {self.length - 1}"
            raise self.source.wrong(here, problem, "lead to a node below, or to 'stay'")
        if child <= parent:
            problem = f"node {parent} leads back to node {child}"
            raise self.source.wrong(here, problem, "lead to a node further down, so that every path ends")
        return child
