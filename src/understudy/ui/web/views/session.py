"""Describe a session as data for the page; rebuild the lesson's part only when the lesson changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Self

from msgspec import UNSET, UnsetType, field, structs

from understudy.learning.report import list_contradicting_numbers
from understudy.model import describe
from understudy.model.automaton import Automaton, State, Transition
from understudy.model.change_summary import ChangeSummary, TransitionChange
from understudy.model.describe import list_conditions_by_switch
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library
from understudy.training.trainee import Mode
from understudy.ui.controller.key_bindings import Arrow
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.messages.base import Data
from understudy.ui.web.rewind import QueryStatusData
from understudy.ui.web.unseen_worlds import EvaluationData, ScoreData, describe_score
from understudy.ui.web.views.scene import FeatureData


class NestedStateData(Data, frozen=True, kw_only=True):
    """A state, for drawing."""

    name: str
    flag: bool
    runs: str | None
    automaton: str | None
    """The trained automaton that it runs."""

    @classmethod
    def of_state(cls, state: State, library: Library, **more: object) -> Self:
        """Describe a state of an automaton of a library, with what else a subclass has."""
        return cls.of(
            state,
            flag=state.flag is not None,
            runs=None if state.behavior is None else library.format_call(state.behavior, state.binding),
            automaton=state.behavior if state.behavior in library.taught else None,
            **more,
        )


class TransitionData(Data, frozen=True, kw_only=True):
    """The conditions for switching from one state to another."""

    from_: str = field(name="from")
    to: str
    when: list[str]
    """The conditions in words, one line for each alternative."""


class NestedAutomatonData(Data, frozen=True, kw_only=True):
    """An automaton that a state runs."""

    states: list[NestedStateData]
    edges: list[TransitionData]


class NestedAutomata:
    """A cache of descriptions of the trained automata that an automaton runs, directly or through others."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Automaton, NestedAutomatonData]] = {}

    def describe_nested(self, automaton: Automaton, library: Library) -> dict[str, NestedAutomatonData]:
        """Return, by name, the descriptions of all trained automata that an automaton runs."""
        nested: dict[str, NestedAutomatonData] = {}
        left = [automaton]
        while left:
            for state in left.pop().states:
                name = state.behavior
                if name is not None and name in library.taught and name not in nested:
                    inner = library.automaton(name)
                    nested[name] = self._drawn(inner, library)
                    left.append(inner)
        return nested

    def _drawn(self, automaton: Automaton, library: Library) -> NestedAutomatonData:
        cached = self._known.get(automaton.name)
        if cached is None or cached[0] is not automaton:
            cached = automaton, _drawn(automaton, library, library.taught[automaton.name].lesson)
            self._known[automaton.name] = cached
        return cached[1]


def _drawn(automaton: Automaton, library: Library, lesson: Lesson | None) -> NestedAutomatonData:
    return NestedAutomatonData(
        states=[NestedStateData.of_state(state, library) for state in automaton.states],
        edges=list_ways(automaton, lesson),
    )


def list_ways(automaton: Automaton, lesson: Lesson | None) -> list[TransitionData]:
    """Return the conditions for each switch of an automaton in words; its lesson tells which were shown."""
    return [
        TransitionData(from_=state, to=following, when=when)
        for (state, following), when in list_conditions_by_switch(automaton, lesson).items()
    ]


class StateData(NestedStateData, frozen=True, kw_only=True):
    """A state of the automaton in training, with its keys."""

    key: str
    arrow: Arrow | None


class EdgeData(TransitionData, frozen=True, kw_only=True):
    """A learned switch between states, with the examples that taught it."""

    examples: list[int]


class ExampleData(Data, frozen=True, kw_only=True):
    """An example of the lesson."""

    number: int
    state: str
    next: str
    values: list[str]
    kind: ExampleKind
    correction: bool
    time_s: float | None
    """When the example was given, in s of the world's time; null if it was typed."""
    contradicts: bool
    quarantined: str
    """Why the example is in quarantine; empty if it is not."""
    source: str
    """The place in a recording that it was made from, and who drove; empty for any other example."""


class SuspectData(Data, frozen=True, kw_only=True):
    """An example that may be wrong."""

    number: int
    reason: str


class DoubtData(Data, frozen=True, kw_only=True):
    """The diagnosis of the last correction, if it found suspect examples that are not resolved yet."""

    reason: str
    suspects: list[SuspectData]


class ChangeSummaryData(Data, frozen=True, kw_only=True):
    """What the automaton decides otherwise than before, apart from what presses say."""

    line: str
    """The most important changes in one line."""
    changes: tuple[TransitionChange, ...]
    """All of them, the most important first."""


class BehaviorCallData(Data, frozen=True, kw_only=True):
    """A behavior and the targets of its parameters."""

    behavior: str
    targets: dict[str, str]


class LessonData(Data, frozen=True, kw_only=True):
    """The part of a session that changes only with the lesson."""

    parameters: list[str]
    states: list[StateData]
    features: list[FeatureData]
    examples: list[ExampleData]
    edges: list[EdgeData]
    nested: dict[str, NestedAutomatonData]
    """The automata it runs, directly or through others, by name."""
    watched: bool
    """Whether the lesson also records examples from silence."""
    reaction_s: float
    unlearning: bool
    """Whether a correction puts bad examples in quarantine by itself."""
    live: bool
    """Whether it is taught live; otherwise as in the paper."""
    flags: list[str]
    """The flags that it can raise: done, failed, or any name."""
    properties: list[str]
    """The properties, such as "done is raised within 20 s in forage, A = station"."""
    pruning: float | None
    """How many examples each leaf must set right; 0: nothing is pruned, null: there are no trees."""
    edition: int
    """Grows whenever the lesson changes."""


class SessionData(LessonData, frozen=True, kw_only=True):
    """The state of the open session."""

    name: str
    targets: dict[str, str]
    mode: Mode
    state: str
    path: list[str]
    flag: str | None
    waiting: str | None = field(name="pending")
    agent: int
    undoable: str | None
    redoable: str | None
    unsaved: bool
    presses: int
    watching: bool
    """Whether examples are recorded from silence now."""
    doubt: DoubtData | None
    changed: ChangeSummaryData | None
    """What the last press or edit changed beyond what it says; null if nothing."""
    others: BehaviorCallData | None
    """The behavior of the robots not in training; null if they idle."""
    activities: list[str]
    """The names of the robots' activities, indexed by the numbers in frames."""
    queries: QueryStatusData
    score: ScoreData
    evaluation: EvaluationData | UnsetType = UNSET
    """Omitted if nothing was evaluated in unseen worlds."""


class SessionViewBuilder:
    """A builder of the page's data of one session."""

    def __init__(self, trainer: Trainer) -> None:
        self._trainer = trainer
        self._of: Lesson | None = None
        self._lesson: LessonData | None = None
        self._nested = NestedAutomata()

    def build(
        self,
        *,
        others: BehaviorCallData | None,
        doing: list[str],
        asking: QueryStatusData,
        evaluation: EvaluationData | UnsetType = UNSET,
    ) -> SessionData:
        """Return the data of the session in its present state."""
        trainer, view = self._trainer, self._trainer.session_view
        return SessionData.of(
            view,
            **structs.asdict(self._taught()),
            name=trainer.name,
            agent=trainer.robot,
            unsaved=trainer.has_unsaved_changes,
            presses=view.examples,
            watching=trainer.session.is_watching,
            doubt=_doubt(trainer),
            changed=describe_change(trainer.session.last_change),
            others=others,
            activities=doing,
            queries=asking,
            score=describe_score(trainer.score, trainer.continuation.better),
            evaluation=evaluation,
        )

    def _taught(self) -> LessonData:
        """Return the part that changes only with the lesson."""
        lesson, learned = self._trainer.explainer.learn_lesson()
        if lesson is not self._of or self._lesson is None:
            self._of = lesson
            automaton, options = lesson.automaton, lesson.options
            self._lesson = LessonData.of(
                options,
                parameters=automaton.parameters,
                states=[self._state(state) for state in automaton.states],
                features=[
                    FeatureData.of_kind(bound.kind, str(bound), bound.feature.unit)
                    for bound in automaton.features
                ],
                examples=_examples(lesson),
                edges=list(_edges(lesson, learned)),
                nested=self._nested.describe_nested(automaton, self._trainer.session.library),
                flags=automaton.flags,
                properties=list(map(str, lesson.properties)),
                pruning=options.learner.pruning if isinstance(options.learner, TreeOptions) else None,
                edition=1 if self._lesson is None else self._lesson.edition + 1,
            )
        return self._lesson

    def _state(self, state: State) -> StateData:
        keys = self._trainer.keys
        key, arrow = keys.plain.get(state.name, ""), keys.arrows.get(state.name)
        return StateData.of_state(state, self._trainer.session.library, key=key, arrow=arrow)


def describe_change(change: ChangeSummary | None) -> ChangeSummaryData | None:
    """Return what an automaton decides otherwise than before as the page shows it."""
    return None if change is None else ChangeSummaryData(line=str(change), changes=change.changes)


def _doubt(trainer: Trainer) -> DoubtData | None:
    """Return the diagnosis of the last correction if it found suspect examples that are not resolved yet."""
    judgement = trainer.session.correction_diagnosis
    if judgement is None:
        return None
    held = {example.number for example in trainer.session.examples if not example.quarantined}
    suspects = [
        SuspectData(number=number, reason=reason)
        for number, reason in judgement.reasons.items()
        if number in held
    ]
    return DoubtData(reason=judgement.reason, suspects=suspects) if suspects else None


def _examples(lesson: Lesson) -> list[ExampleData]:
    features = lesson.automaton.features
    against = list_contradicting_numbers(lesson)
    return [
        ExampleData.of(
            example,
            values=[
                describe.format_value(bound, value)
                for bound, value in zip(features, example.values, strict=True)
            ],
            time_s=_time(lesson, example),
            contradicts=example.number in against,
            source="" if example.source is None else str(example.source),
        )
        for example in lesson.examples
    ]


def _time(lesson: Lesson, example: Example) -> float | None:
    return None if example.moment is None else float(lesson.record.seconds[example.moment])


def _edges(lesson: Lesson, learned: Mapping[str, Transition]) -> Iterator[EdgeData]:
    """Yield the learned switches between states with their conditions and examples."""
    numbers: dict[tuple[str, str], list[int]] = {}
    for example in lesson.examples:
        if example.is_from_press:
            numbers.setdefault((example.state, example.next), []).append(example.number)
    for each in list_ways(replace(lesson.automaton, transitions=learned), lesson):
        yield EdgeData.of(each, examples=numbers.get((each.from_, each.to), []))
