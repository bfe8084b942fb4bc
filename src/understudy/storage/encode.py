"""Encoding of automata and lessons as documents."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isnan
from typing import Literal, TypeVar, cast

from msgspec import UNSET, UnsetType

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.binding import format_bound_name
from understudy.model.example_source import ExampleSource
from understudy.model.features import BoundFeature
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.model.library import TrainedAutomaton
from understudy.model.property import Property, StoredMoment
from understudy.model.tree import STAY, Node, TestKind, Tree
from understudy.model.value_kinds import Categorical
from understudy.storage.feature_documents import encode_feature
from understudy.storage.kit_parts import encode_kit
from understudy.storage.library_schema import (
    AbsentDoc,
    ArcDoc,
    AutomatonDoc,
    BelowDoc,
    BuiltDoc,
    ChildDoc,
    DocValue,
    ExampleDoc,
    GoalDoc,
    GoDoc,
    LabelDoc,
    LessonDoc,
    NodeDoc,
    OptionsDoc,
    OutcomeDoc,
    ReadingDoc,
    RecordDoc,
    ScikitDoc,
    SourceDoc,
    StateDoc,
    StayDoc,
    TreesDoc,
    WatchedDoc,
    WatchedSourceDoc,
)
from understudy.storage.packing import pack_bytes, pack_column

T = TypeVar("T")

EVERY_STATE = "*"
"""The key under which a stateless automaton's shared tree is stored, for all states."""


def sort_examples(lesson: Lesson) -> Lesson:
    """Return the lesson with its examples sorted by number, as documents store them."""
    return replace(lesson, examples=tuple(sorted(lesson.examples, key=lambda example: example.number)))


def encode_automaton(automaton: Automaton) -> AutomatonDoc:
    """Encode an automaton's states, features and parameters."""
    return AutomatonDoc(
        name=automaton.name,
        parameters=list(automaton.parameters),
        stateless=automaton.stateless,
        states=[
            StateDoc(name=state.name, behavior=state.behavior, binding=dict(state.binding), flag=state.flag)
            for state in automaton.states
        ],
        features=[encode_feature(bound) for bound in automaton.features],
    )


def format_feature_label(bound: BoundFeature) -> str:
    """Format a feature as trees in documents do, with its arguments in alphabetical order of the parameters."""
    return format_bound_name(bound.feature.name, bound.binding)


def encode_lesson(lesson: Lesson) -> LessonDoc:
    """Encode a lesson's options, examples, record and properties."""
    features = lesson.automaton.features
    examples = sort_examples(lesson).examples
    return LessonDoc(
        options=_options_doc(lesson.options),
        examples=[_example_doc(example, features) for example in examples if example.is_from_press],
        watched=_watched_docs([example for example in examples if not example.is_from_press], features),
        record=_record_doc(lesson.record),
        outcomes=[
            _outcome_doc(each, each.start)
            for each in lesson.properties
            if isinstance(each.start, StoredMoment)
        ]
        or UNSET,
        goal=UNSET if lesson.goal is None else _goal_doc(lesson.goal),
        kit=UNSET if lesson.kit is None else encode_kit(lesson.kit),
    )


def _goal_doc(goal: Property) -> GoalDoc:
    limit_s = goal.start.limit_s
    return GoalDoc(
        name=goal.name,
        kind=goal.kind,
        what=goal.what,
        within_s=UNSET if goal.seconds is None else goal.seconds,
        limit_s=UNSET if limit_s is None else limit_s,
        world=goal.start.world,
    )


def _outcome_doc(stored: Property, start: StoredMoment) -> OutcomeDoc:
    by_flag = stored.flag is not None
    return OutcomeDoc(
        flag=stored.flag or UNSET,
        kind=UNSET if by_flag else stored.kind,
        what=UNSET if by_flag else stored.what,
        within_s=UNSET if stored.seconds is None else stored.seconds,
        limit_s=UNSET if start.limit_s is None else start.limit_s,
        world=start.world,
        agent=start.agent,
        sort=start.sort,
        targets=dict(stored.targets),
        scenario=pack_bytes(start.scenario.encode()),
        snapshot=pack_bytes(start.snapshot),
    )


def _options_doc(options: LearnerOptions) -> OptionsDoc:
    learner: TreesDoc | ScikitDoc
    if isinstance(options.learner, TreeOptions):
        trees = options.learner
        learner = TreesDoc(
            boundary=trees.boundary,
            defaults=UNSET if trees.defaults else False,
            pruning=trees.pruning or UNSET,
            order="flags first" if trees.order == "flags first" else UNSET,
        )
    else:
        learner = ScikitDoc(
            classifier=options.learner.classifier, parameters=dict(sorted(options.learner.parameters.items()))
        )
    return OptionsDoc(
        reaction_s=options.reaction_s,
        watched=options.watched,
        learner=learner,
        unlearning=options.unlearning or UNSET,
        live=options.live or UNSET,
    )


def _example_doc(example: Example, features: Sequence[BoundFeature]) -> ExampleDoc:
    return ExampleDoc(
        number=example.number,
        state=example.state,
        next=example.next,
        kind=cast(Literal["directive", "default", "confirmation"], example.kind.value),
        values=_values(example, features),
        correction=example.correction,
        edited=example.edited,
        moment=example.moment,
        window=example.window,
        own={name: encode_number(value) for name, value in example.own.items()},
        binding=dict(example.binding),
        quarantined=example.quarantined,
        reaction_s=UNSET if example.reaction_s is None else example.reaction_s,
        source=UNSET if example.source is None else _source_doc(example.source),
    )


def _source_doc(source: ExampleSource) -> SourceDoc:
    return SourceDoc(file=source.file, time_s=source.time_s, driver=source.driver, certainty=source.certainty)


def _values(example: Example, features: Sequence[BoundFeature]) -> list[DocValue]:
    if len(example.values) != len(features):
        raise DefinitionError(
            what=f"example {example.number}",
            problem=f"it has {len(example.values)} values",
            remedy=f"give one for each of the {len(features)} features",
        )
    values: list[DocValue] = []
    for bound, value in zip(features, example.values, strict=True):
        checked = bound.kind.check(value, where=f"example {example.number}, feature {bound}")
        label = isinstance(bound.kind, Categorical) and not isnan(checked)
        values.append(cast(Categorical, bound.kind).labels[int(checked)] if label else encode_number(checked))
    return values


def encode_number(value: float) -> float | None:
    """Convert a number to what JSON can hold: None if absent (NaN)."""
    return None if isnan(value) else float(value)


def _watched_docs(examples: Iterable[Example], features: Sequence[BoundFeature]) -> list[WatchedDoc]:
    groups: dict[object, list[Example]] = {}
    for example in examples:
        recording = None if example.source is None else (example.source.driver, example.source.file)
        groups.setdefault((tuple(sorted(example.own)), example.binding, recording), []).append(example)
    return [_watched_doc(group, features) for group in groups.values()]


def _watched_doc(group: Sequence[Example], features: Sequence[BoundFeature]) -> WatchedDoc:
    rows = [_values(example, features) for example in group]
    return WatchedDoc(
        number=[example.number for example in group],
        state=[example.state for example in group],
        next=[example.next for example in group],
        values=[list(column) for column in zip(*rows, strict=True)],
        correction=_unless_all([example.correction for example in group], False),
        edited=_unless_all([example.edited for example in group], False),
        moment=_unless_all([example.moment for example in group], None),
        window=_unless_all([example.window for example in group], 0),
        own={name: [encode_number(example.own[name]) for example in group] for name in group[0].own},
        binding=dict(group[0].binding),
        quarantined=_unless_all([example.quarantined for example in group], ""),
        source=_watched_source_doc([each.source for each in group if each.source is not None]),
    )


def _watched_source_doc(sources: Sequence[ExampleSource]) -> WatchedSourceDoc | UnsetType:
    """Encode the sources of a group of watched examples, which are of one recording; UNSET if there are none."""
    if not sources:
        return UNSET
    return WatchedSourceDoc(
        file=sources[0].file,
        time_s=[each.time_s for each in sources],
        driver=sources[0].driver,
        certainty=_unless_all([each.certainty for each in sources], 1.0),
    )


def _unless_all(column: list[T], usual: T) -> list[T]:
    return [] if all(value == usual for value in column) else column


def _record_doc(record: ReadingLog) -> RecordDoc:
    return RecordDoc(
        moments=len(record),
        seconds=pack_column(record.seconds),
        readings=[
            ReadingDoc(reading=reading, of=target, values=pack_column(record.values[:, column]))
            for column, (reading, target) in enumerate(record.keys)
        ],
    )


def encode_built_trees(taught: TrainedAutomaton) -> BuiltDoc | None:
    """Encode the trees of an automaton; return None for classifiers, which are fitted again on loading.

    Refuse a transition function that is neither a tree nor learned with a classifier.
    """
    automaton = taught.automaton
    trees: dict[str, list[NodeDoc]] = {}
    for state, transition in automaton.transitions.items():
        if not isinstance(transition, Tree):
            if taught.lesson is None or isinstance(taught.lesson.options.learner, TreeOptions):
                raise DefinitionError(
                    what=f"automaton {automaton.name!r}",
                    problem=f"the transition function of state {state!r} is not a tree",
                    remedy="only trees can be stored; keep the lesson it was learned from",
                )
            return None
        trees[state] = [_node_doc(node, automaton) for node in transition.nodes]
    if automaton.stateless and _shared(automaton.transitions, automaton):
        trees = {EVERY_STATE: next(iter(trees.values()))}
    return BuiltDoc(hash=None, trees=trees)


def _shared(transitions: Mapping[str, object], automaton: Automaton) -> bool:
    states = [state.name for state in automaton.states if state.flag is None]
    told_apart = EVERY_STATE not in automaton.state_names
    return (
        told_apart
        and list(transitions) == states
        and all(each == transitions[states[0]] for each in transitions.values())
    )


def _node_doc(node: Node, automaton: Automaton) -> NodeDoc:
    if node.test == TestKind.LEAF:
        return StayDoc() if node.yes == STAY else GoDoc(to=automaton.states[node.yes].name)
    bound = automaton.features[node.feature]
    feature = format_feature_label(bound)
    yes, no, absent = _child(node.yes), _child(node.no), _child(node.absent)
    if node.test == TestKind.BELOW:
        return BelowDoc(feature=feature, cut=float(node.high), yes=yes, no=no, absent=absent)
    if node.test == TestKind.ARC:
        return ArcDoc(
            feature=feature, low=float(node.low), high=float(node.high), yes=yes, no=no, absent=absent
        )
    if node.test == TestKind.ABSENT:
        return AbsentDoc(feature=feature, yes=yes, no=no)
    labels = cast(Categorical, bound.kind).labels
    branches = {label: _child(child) for label, child in zip(labels, node.branches, strict=True)}
    return LabelDoc(feature=feature, branches=branches, absent=absent)


def _child(index: int) -> ChildDoc:
    return "stay" if index == STAY else index
