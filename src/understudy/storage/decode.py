"""Decoding of library documents into automata, trees and lessons; every error names its place in the document."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nan

from msgspec import UnsetType

from understudy.errors import OtherKit, join_names
from understudy.model.automaton import Automaton, State
from understudy.model.binding import Binding
from understudy.model.example_source import ExampleSource
from understudy.model.features import (
    AnyFeature,
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    OwnFeature,
    TimeInState,
    TimerFeature,
)
from understudy.model.learner_options import Learner, LearnerOptions, SklearnOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import Kit
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Categorical, Kind, Toroidal, parse_kind
from understudy.storage.decode_properties import decode_properties, make_goal
from understudy.storage.encode import EVERY_STATE, format_feature_label
from understudy.storage.json_text import JsonSteps, Source
from understudy.storage.kit_parts import decode_kit
from understudy.storage.library_schema import (
    AbsentDoc,
    ArcDoc,
    AutomatonDoc,
    BelowDoc,
    BuiltDoc,
    ChildDoc,
    DocValue,
    ExampleDoc,
    FeatureDoc,
    GoDoc,
    LabelDoc,
    LessonDoc,
    NodeDoc,
    OptionsDoc,
    RecordDoc,
    SourceDoc,
    StayDoc,
    TreesDoc,
    WatchedDoc,
    WatchedSourceDoc,
)
from understudy.storage.packing import unpack_column

OWN: dict[str, type[OwnFeature]] = {
    "flag": FlagFeature,
    "counter": CounterFeature,
    "timer": TimerFeature,
    "time in state": TimeInState,
}


def decode_automaton(doc: AutomatonDoc, kit: Kit | None, source: Source) -> Automaton:
    """Decode an automaton without its transition functions, with features of the kit.

    Without a kit, features are made from what the document says; such an automaton can be displayed, not run.
    """
    here: JsonSteps = ("automaton",)
    source.check_unique(doc.parameters, (*here, "parameters"), "parameter")
    source.check_unique([state.name for state in doc.states], (*here, "states"), "state")
    states = []
    for index, state in enumerate(doc.states):
        with source.convert_errors((*here, "states", index)):
            states.append(State(state.name, state.behavior, Binding(state.binding), state.flag))
    features = [
        _feature(each, kit, source, (*here, "features", index)) for index, each in enumerate(doc.features)
    ]
    source.check_unique([str(bound) for bound in features], (*here, "features"), "feature")
    with source.convert_errors((*here, "states")):
        return Automaton(doc.name, tuple(states), tuple(features), tuple(doc.parameters), doc.stateless)


def _feature(doc: FeatureDoc, kit: Kit | None, source: Source, here: JsonSteps) -> BoundFeature:
    with source.convert_errors(
        (*here, "kind"), remedy="restore an earlier version if you did not mean to edit it"
    ):
        kind = parse_kind(doc.kind, where=f"feature {doc.name!r}")
    feature = _declared(doc, kind) if kit is None else _known(doc, kind, kit, source, here)
    if set(doc.binding) != set(feature.parameters):
        bound = f"it binds {join_names(doc.binding)}" if doc.binding else "it binds nothing"
        what = (
            f"exactly its parameters ({join_names(feature.parameters)})" if feature.parameters else "nothing"
        )
        raise source.make_error((*here, "binding"), f"{bound}, for feature {doc.name!r}", f"bind {what}")
    return BoundFeature(feature, Binding(doc.binding))


def _declared(doc: FeatureDoc, kind: Kind) -> AnyFeature:
    if doc.sort == "body":
        return Feature(doc.name, kind, reading=doc.name, unit=doc.unit, parameters=tuple(doc.binding))
    return OWN[doc.sort](doc.name, kind, doc.unit)


def _known(doc: FeatureDoc, kind: Kind, kit: Kit, source: Source, here: JsonSteps) -> AnyFeature:
    of_kit = kit.features.get(doc.name)
    if doc.sort != "body" and (of_kit is None or _own_sort(of_kit) == doc.sort):
        return OWN[doc.sort](doc.name, kind, doc.unit)
    if of_kit is None:
        has = join_names(name for name, feature in kit.features.items() if isinstance(feature, Feature))
        problem = f"the kit has no feature {doc.name!r}; its features are {has}"
        raise source.make_error(
            (*here, "name"), problem, "open it with the kit it was taught with, or correct the name", OtherKit
        )
    if _own_sort(of_kit) != doc.sort:
        problem = f"feature {doc.name!r} is stored as one of sort {doc.sort!r}, but in the kit its sort is "
        remedy = "open it with the kit it was taught with, or rename the feature in the kit"
        raise source.make_error((*here, "sort"), f"{problem}{_own_sort(of_kit)!r}", remedy, OtherKit)
    for what, stored, now in (("kind", str(kind), str(of_kit.kind)), ("unit", doc.unit, of_kit.unit)):
        if stored and stored != now:  # a table of examples tells no unit: that of the kit
            problem = (
                f"feature {doc.name!r} was taught with {what} {stored!r}, but the kit has it with {now!r}"
            )
            remedy = "open it with the kit it was taught with, or teach it again with this one"
            raise source.make_error((*here, what), problem, remedy, OtherKit)
    return of_kit


def _own_sort(feature: AnyFeature) -> str:
    return next((sort for sort, own in OWN.items() if isinstance(feature, own)), "body")


def decode_lesson(doc: LessonDoc, automaton: Automaton, source: Source) -> Lesson:
    """Decode a lesson, with its examples in the order of their numbers."""
    here: JsonSteps = ("lesson",)
    record = _record(doc.record, source, (*here, "record"))
    reader = _Examples(automaton, len(record), source)
    examples = [
        reader.decode_pressed(each, (*here, "examples", index)) for index, each in enumerate(doc.examples)
    ]
    for index, group in enumerate(doc.watched):
        examples += reader.decode_watched(group, (*here, "watched", index))
    with source.convert_errors((*here, "goal")):
        goal = None if isinstance(doc.goal, UnsetType) else make_goal(doc.goal)
    with source.convert_errors((*here, "options")):
        return Lesson(
            automaton,
            tuple(sorted(examples, key=lambda example: example.number)),
            _options(doc.options),
            record,
            decode_properties(doc, source, (*here, "outcomes")),
            goal,
            None if isinstance(doc.kit, UnsetType) else decode_kit(doc.kit, source, (*here, "kit")),
        )


def _options(doc: OptionsDoc) -> LearnerOptions:
    learner: Learner
    if isinstance(doc.learner, TreesDoc):
        pruning = 0.0 if isinstance(doc.learner.pruning, UnsetType) else doc.learner.pruning
        learner = TreeOptions(
            doc.learner.boundary,
            defaults=doc.learner.defaults is not False,
            pruning=pruning,
            order="gain first" if isinstance(doc.learner.order, UnsetType) else doc.learner.order,
        )
    else:
        learner = SklearnOptions(doc.learner.classifier, doc.learner.parameters)
    return LearnerOptions(doc.reaction_s, doc.watched, learner, doc.unlearning is True, doc.live is True)


def _record(doc: RecordDoc, source: Source, here: JsonSteps) -> ReadingLog:
    columns = []
    for steps, text in (
        ((*here, "seconds"), doc.seconds),
        *(((*here, "readings", index, "values"), each.values) for index, each in enumerate(doc.readings)),
    ):
        try:
            columns.append(unpack_column(text, length=doc.moments))
        except ValueError as error:
            remedy = "restore an earlier version, or the line as it was"
            raise source.make_error(steps, f"the packed numbers cannot be read: {error}", remedy) from error
    seconds, *readings = columns
    source.check_unique(
        [f"{each.reading} of {each.of}" for each in doc.readings], (*here, "readings"), "reading"
    )
    return ReadingLog.from_columns(tuple((each.reading, each.of) for each in doc.readings), readings, seconds)


class _Examples:
    """A decoder of one automaton's examples, which checks them against states, features and record."""

    def __init__(self, automaton: Automaton, moments: int, source: Source) -> None:
        self.automaton, self.moments, self.source = automaton, moments, source
        self.numbers: set[int] = set()

    def decode_pressed(self, doc: ExampleDoc, here: JsonSteps) -> Example:
        """Decode a press-made example."""
        self.check_numbers([doc.number], lambda _: (*here, "number"))
        for key, state in (("state", doc.state), ("next", doc.next)):
            self.check_state(state, (*here, key))
        self.check_moment(doc.moment, doc.window, here)
        features = self.automaton.features
        if len(doc.values) != len(features):
            problem = f"example {doc.number} has {len(doc.values)} values for {len(features)} features"
            remedy = f"give one each for {join_names(str(bound) for bound in features)}"
            raise self.source.make_error((*here, "values"), problem, remedy)
        return Example(
            doc.number,
            doc.state,
            tuple(
                self.value(value, bound, (*here, "values", index))
                for index, (value, bound) in enumerate(zip(doc.values, features, strict=True))
            ),
            doc.next,
            ExampleKind(doc.kind),
            doc.correction,
            doc.edited,
            doc.moment,
            doc.window,
            {name: _float(value) for name, value in doc.own.items()},
            Binding(doc.binding),
            doc.quarantined,
            None if isinstance(doc.reaction_s, UnsetType) else doc.reaction_s,
            _source(doc.source),
        )

    def decode_watched(self, doc: WatchedDoc, here: JsonSteps) -> list[Example]:
        """Decode one group of watched examples, which is stored as columns."""
        length = len(doc.number)
        features = self.automaton.features
        if len(doc.values) != len(features):
            problem = f"there are {len(doc.values)} columns of values for {len(features)} features"
            remedy = f"give one each for {join_names(str(bound) for bound in features)}"
            raise self.source.make_error((*here, "values"), problem, remedy)
        columns: list[tuple[JsonSteps, Sequence[object]]] = [
            (("state",), doc.state),
            (("next",), doc.next),
            *((("values", index), column) for index, column in enumerate(doc.values)),
            *(((key,), getattr(doc, key)) for key in OPTIONAL if getattr(doc, key)),
            *((("own", name), column) for name, column in doc.own.items()),
            *_list_source_columns(doc.source),
        ]
        for steps, column in columns:
            if len(column) != length:
                problem = f"this column has {len(column)} entries, but 'number' has {length}"
                raise self.source.make_error(
                    (*here, *steps), problem, "give every column of a group one length"
                )
        self.check_numbers(doc.number, lambda index: (*here, "number", index))
        for key, states in (("state", doc.state), ("next", doc.next)):
            for index, state in enumerate(states):
                self.check_state(state, (*here, key, index))
        rows = [
            [
                self.value(value, bound, (*here, "values", column, row))
                for row, value in enumerate(doc.values[column])
            ]
            for column, bound in enumerate(features)
        ]
        values = list(zip(*rows, strict=True)) if rows else [()] * length
        moments, windows = doc.moment or [None] * length, doc.window or [0] * length
        for moment, window in zip(moments, windows, strict=True):
            self.check_moment(moment, window, here)
        corrections, edits = doc.correction or [False] * length, doc.edited or [False] * length
        quarantined = doc.quarantined or [""] * length
        sources = _watched_sources(doc.source, length)
        return [
            Example(
                doc.number[row],
                doc.state[row],
                tuple(values[row]),
                doc.next[row],
                ExampleKind.WATCHED,
                corrections[row],
                edits[row],
                moments[row],
                windows[row],
                {name: _float(column[row]) for name, column in doc.own.items()},
                Binding(doc.binding),
                quarantined[row],
                source=sources[row],
            )
            for row in range(length)
        ]

    def check_numbers(self, numbers: Sequence[int], at: Callable[[int], JsonSteps]) -> None:
        for index, number in enumerate(numbers):
            if number in self.numbers:
                raise self.source.make_error(
                    at(index), f"two examples have number {number}", "give one of them another"
                )
            self.numbers.add(number)

    def check_state(self, name: str, here: JsonSteps) -> None:
        states = self.automaton.state_names
        if name not in states:
            problem = f"automaton {self.automaton.name!r} has no state {name!r}"
            raise self.source.make_error(here, problem, f"name one of its states: {join_names(states)}")

    def check_moment(self, moment: int | None, window: int, here: JsonSteps) -> None:
        if moment is not None and moment >= self.moments:
            problem = f"it is of moment {moment}, but the record has {self.moments}"
            raise self.source.make_error((*here, "moment"), problem, "count moments from 0, or leave it out")
        if window > (0 if moment is None else moment):
            problem = f"its window reaches {window} moments back, before the record begins"
            raise self.source.make_error((*here, "window"), problem, "give no more than its moment")

    def value(self, value: DocValue, bound: BoundFeature, here: JsonSteps) -> float:
        if value is None:
            return nan
        labels = bound.kind.labels if isinstance(bound.kind, Categorical) else ()
        if isinstance(value, str) and value in labels:
            return float(labels.index(value))
        if labels or isinstance(value, str):
            right = f"one of its labels: {join_names(labels)}" if labels else "a number"
            problem = f"{value!r} is outside feature {bound}, which is {bound.kind}"
            raise self.source.make_error(here, problem, f"write {right}, or null if it is absent")
        with self.source.convert_errors(here):
            return bound.kind.check(value, where=f"feature {bound}")


OPTIONAL = ("correction", "edited", "moment", "window", "quarantined")


def _float(value: float | None) -> float:
    return nan if value is None else value


def _source(doc: SourceDoc | UnsetType) -> ExampleSource | None:
    if isinstance(doc, UnsetType):
        return None
    return ExampleSource(doc.file, doc.time_s, doc.driver, doc.certainty)


def _list_source_columns(doc: WatchedSourceDoc | UnsetType) -> list[tuple[JsonSteps, Sequence[object]]]:
    """List the columns of the sources of watched examples, each with its place in the document."""
    if isinstance(doc, UnsetType):
        return []
    certainty: list[tuple[JsonSteps, Sequence[object]]] = [(("source", "certainty"), doc.certainty)]
    return [(("source", "time_s"), doc.time_s), *(certainty if doc.certainty else [])]


def _watched_sources(doc: WatchedSourceDoc | UnsetType, length: int) -> Sequence[ExampleSource | None]:
    if isinstance(doc, UnsetType):
        return [None] * length
    certainties = doc.certainty or [1.0] * length
    return [
        ExampleSource(doc.file, time_s, doc.driver, certainty)
        for time_s, certainty in zip(doc.time_s, certainties, strict=True)
    ]


def decode_trees(doc: BuiltDoc, automaton: Automaton, source: Source) -> Mapping[str, Tree]:
    """Decode the tree of each state, by its name."""
    here: JsonSteps = ("built", "trees")
    movable = [state.name for state in automaton.states if state.flag is None]
    if automaton.stateless and EVERY_STATE in doc.trees and EVERY_STATE not in automaton.state_names:
        if list(doc.trees) != [EVERY_STATE]:
            problem = f"there are trees besides {EVERY_STATE!r}, which is the tree of all states"
            raise source.make_error(here, problem, "keep one or the other")
        shared = _tree(doc.trees[EVERY_STATE], automaton, source, (*here, EVERY_STATE))
        return dict.fromkeys(movable, shared)
    for name in doc.trees:
        if name not in movable:
            problem = (
                f"there is a tree for {name!r}, which is not a state of {automaton.name!r} that can be left"
            )
            raise source.make_error((*here, name), problem, f"give trees to {join_names(movable)} only")
    return {name: _tree(nodes, automaton, source, (*here, name)) for name, nodes in doc.trees.items()}


def _tree(nodes: list[NodeDoc], automaton: Automaton, source: Source, here: JsonSteps) -> Tree:
    if not nodes:
        raise source.make_error(
            here, "this tree has no nodes", "leave out the tree of a state that is never left"
        )
    reader = _Nodes(automaton, len(nodes), source)
    return Tree(tuple(reader.node(node, index, (*here, index)) for index, node in enumerate(nodes)))


class _Nodes:
    """A decoder of one tree's nodes."""

    def __init__(self, automaton: Automaton, length: int, source: Source) -> None:
        self.automaton, self.length, self.source = automaton, length, source
        self.names = [format_feature_label(bound) for bound in automaton.features]

    def node(self, doc: NodeDoc, index: int, here: JsonSteps) -> Node:
        if isinstance(doc, StayDoc):
            return make_leaf(STAY)
        if isinstance(doc, GoDoc):
            if doc.to not in self.automaton.state_names:
                problem = f"it goes to {doc.to!r}, which is not a state of automaton {self.automaton.name!r}"
                remedy = f"name one of its states: {join_names(self.automaton.state_names)}"
                raise self.source.make_error((*here, "to"), problem, remedy)
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
            raise self.source.make_error(
                here, f"feature {doc.feature} has labels, not numbers", "test it by label"
            )
        if isinstance(doc, BelowDoc):
            return Node(TestKind.BELOW, feature, high=doc.cut, yes=yes, no=no, absent=absent)
        return self.arc(doc, kind, Node(TestKind.ARC, feature, doc.low, doc.high, yes, no, absent), here)

    def arc(self, doc: ArcDoc, kind: object, node: Node, here: JsonSteps) -> Node:
        if not isinstance(kind, Toroidal):
            raise self.source.make_error(
                here, f"feature {doc.feature} is not toroidal: it has no arcs", "test it by a cut"
            )
        return node

    def label(self, doc: LabelDoc, feature: int, index: int, here: JsonSteps) -> Node:
        kind = self.automaton.features[feature].kind
        labels = kind.labels if isinstance(kind, Categorical) else ()
        if set(doc.branches) != set(labels):
            right = f"give one each for {join_names(labels)}" if labels else "test it by a cut"
            problem = f"feature {doc.feature} is {kind}, but the branches are for {join_names(doc.branches)}"
            raise self.source.make_error((*here, "branches"), problem, right)
        branches = tuple(
            self.child(doc.branches[label], index, (*here, "branches", label)) for label in labels
        )
        absent = self.child(doc.absent, index, (*here, "absent"))
        return Node(TestKind.LABEL, feature, absent=absent, branches=branches)

    def feature(self, name: str, here: JsonSteps) -> int:
        if name not in self.names:
            problem = f"it tests {name!r}, which is not a feature of automaton {self.automaton.name!r}"
            raise self.source.make_error(
                (*here, "feature"), problem, f"name one of its features: {join_names(self.names)}"
            )
        return self.names.index(name)

    def child(self, child: ChildDoc, parent: int, here: JsonSteps) -> int:
        if child == "stay":
            return STAY
        if child >= self.length:
            problem = f"it leads to node {child}, but the tree has nodes 0 to {self.length - 1}"
            raise self.source.make_error(here, problem, "lead to a node below, or to 'stay'")
        if child <= parent:
            problem = f"node {parent} leads back to node {child}"
            raise self.source.make_error(
                here, problem, "lead to a node further down, so that every path ends"
            )
        return child
