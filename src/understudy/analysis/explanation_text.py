"""Put explanations of decisions into sentences, and into plain data for programs.

The one place where a "why" is composed: the terminal, the page and the command line arrange what is made here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from understudy.errors import join_names
from understudy.learning.explain import Explanation
from understudy.model.describe import convert_to_plain, format_condition, format_values
from understudy.model.lesson import ExampleKind

if TYPE_CHECKING:
    from understudy.analysis.explain_run import (
        AgentExplanation,
        DecisionReason,
        LevelExplanation,
        RunExplanation,
    )

MOST_EXAMPLES = 6
"""So many examples are named in a sentence, and shown behind a decision."""
DIGITS = 6
"""To so many digits times are given, s."""


def describe_decision(explanation: Explanation) -> str:
    """What is decided, and because of what: "goes from forward to done because distance_to(A) is below 0.35 m"."""
    stays = explanation.next == explanation.state
    what = (
        f"stays in {explanation.state}" if stays else f"goes from {explanation.state} to {explanation.next}"
    )
    return what + _describe_conditions(explanation)


def describe_switch(before: str, after: str, explanation: Explanation, examples: str = "") -> str:
    """Why a state was left for another, or what would be decided there by now: the lesson may have changed since.

    `examples`, such as `list_examples` names, follow the conditions.
    """
    what = f"went from {before} to {after}"
    if explanation.next == after:
        return f"{what}{_describe_conditions(explanation)}{examples}"
    return f"{what}; by now it {describe_decision(explanation)}{examples}"


def describe_rest(level: LevelExplanation) -> str:
    """Why there is nothing to decide at a level."""
    return (
        f"{level.flag} is raised; a flag state is never left" if level.flag else "there are no examples there"
    )


def describe_present(decision: Explanation | None, flag: str | None) -> str:
    """What an automaton that decides by itself does now, in a sentence; without a decision, its flag is raised."""
    if decision is None:
        return f"It raised {flag}; a flag state is never left."
    return f"It {describe_decision(decision)}{list_examples(decision)}."


def describe_intention(decision: Explanation | None) -> str:
    """What an automaton would do now while a person decides; without a decision, its flag is raised."""
    if decision is None:
        return "A raised flag is never left."
    return f"In testing it {describe_decision(decision)}{list_examples(decision)}."


def list_examples(explanation: Explanation) -> str:
    """The press-made examples behind a decision: " (shown by 3, 7)"; nothing where nothing was shown."""
    numbers = [str(example.number) for example in explanation.examples if example.is_from_press]
    if not (explanation.shown and numbers):
        return ""
    more = "…" if len(numbers) > MOST_EXAMPLES else ""
    return f" (shown by {', '.join(numbers[:MOST_EXAMPLES])}{more})"


def describe_values(reason: DecisionReason) -> str:
    """The feature values that were decided on: "distance_to(A) = 3.42 m, angle_to(A) = −31°"."""
    return format_values(reason.taught.automaton.features, list(reason.values.values()))


def describe_source(reason: DecisionReason) -> str:
    """Where a decision comes from: "shown by 3 (directive at 12.3 s), 7 (correction at 40.1 s) and 5 more"."""
    if reason.taught.lesson is None:
        return "it was written by hand: no example is behind it"
    examples = list_example_data(reason)
    named = [_describe_example(each) for each in examples[:MOST_EXAMPLES]]
    more = [f"{len(examples) - len(named)} more"] if len(examples) > len(named) else []
    return f"shown by {join_names([*named, *more])}" if named else ""


def _describe_conditions(explanation: Explanation) -> str:
    """The conditions that held, or that nothing was ever shown where they do."""
    held = format_condition(" and ".join(explanation.conditions))
    if explanation.shown:
        return f" because {held}" if held else ", always"
    return f": there are no examples where {held}" if held else ": there are no examples there"


def _describe_example(example: DecisionExampleData) -> str:
    corrects = example.correction and example.kind is not ExampleKind.DEFAULT
    when = "" if example.shown_s is None else f" at {example.shown_s:.1f} s"
    return f"{example.number} ({'correction' if corrects else example.kind}{when})"


@dataclass(frozen=True, slots=True)
class DecisionExampleData:
    """An example behind a decision; `shown_s` is when, s of the demonstrator's time in its session."""

    number: int
    kind: ExampleKind
    correction: bool
    next: str
    shown_s: float | None


@dataclass(frozen=True, slots=True)
class DecisionData:
    """A decision and what was behind it, as --json prints it."""

    time_s: float
    automaton: str
    before: str
    after: str
    conditions: Sequence[str]
    shown: bool
    values: Mapping[str, float | str | None]
    read: str
    by_hand: bool
    examples: Sequence[DecisionExampleData]

    @classmethod
    def from_reason(cls, reason: DecisionReason) -> DecisionData:
        """The data of a decision."""
        explanation, features = reason.explanation, reason.taught.automaton.features
        read = zip(features, reason.values.items(), strict=True)
        return cls(
            time_s=round(reason.time_s, DIGITS),
            automaton=reason.automaton,
            before=explanation.state,
            after=explanation.next,
            conditions=explanation.conditions,
            shown=explanation.shown,
            values={label: convert_to_plain(value, bound) for bound, (label, value) in read},
            read=describe_values(reason),
            by_hand=reason.taught.lesson is None,
            examples=list_example_data(reason),
        )

    @classmethod
    def from_optional_reason(cls, reason: DecisionReason | None) -> DecisionData | None:
        """The data of a decision, where there is one."""
        return None if reason is None else cls.from_reason(reason)


@dataclass(frozen=True, slots=True)
class DecisionLevelData:
    """One automaton of an agent, as --json prints it; `rests` says why there was nothing to decide."""

    automaton: str
    state: str
    since_s: float
    decision: DecisionData | None
    rests: str | None
    entry: DecisionData | None

    @classmethod
    def from_level(cls, level: LevelExplanation) -> DecisionLevelData:
        """The data of a level."""
        decision, entry = map(DecisionData.from_optional_reason, (level.decision, level.entry))
        rests = describe_rest(level) if level.decision is None else None
        return cls(level.automaton, level.state, round(level.since_s, DIGITS), decision, rests, entry)


@dataclass(frozen=True, slots=True)
class AgentData:
    """One agent, from a coordinator at the top to the robot, as --json prints it."""

    sort: str
    agent: int
    ordered: str | None
    levels: Sequence[DecisionLevelData]

    @classmethod
    def from_agent(cls, asked: AgentExplanation) -> AgentData:
        """The data of an agent."""
        return cls(
            asked.sort,
            asked.agent,
            asked.ordered,
            [DecisionLevelData.from_level(each) for each in asked.levels],
        )


@dataclass(frozen=True, slots=True)
class WhyData:
    """What all levels decided at a moment of a run, as --json prints it.

    `former` has the versions of automata that are others by now.
    """

    scenario: str
    seed: int
    robot: int
    doing: str
    time_s: float
    decided_s: float
    former: Mapping[str, int]
    switched: bool
    agents: Sequence[AgentData]
    last_switch: DecisionData | None

    @classmethod
    def from_explanation(
        cls, why: RunExplanation, former: Mapping[str, int], scenario: str, seed: int, robot: int, doing: str
    ) -> WhyData:
        """The data of a moment."""
        times = round(why.time_s, DIGITS), round(why.decided_s, DIGITS)
        agents = [AgentData.from_agent(each) for each in why.agents]
        return cls(
            scenario,
            seed,
            robot,
            doing,
            *times,
            former,
            why.has_switch,
            agents,
            DecisionData.from_optional_reason(why.last),
        )


def list_example_data(reason: DecisionReason) -> list[DecisionExampleData]:
    """The examples behind a decision: what the demonstrator said first, then what was recorded by itself."""
    return [
        DecisionExampleData(
            each.number, each.kind, each.correction, each.next, reason.moments.get(each.number)
        )
        for each in sorted(reason.explanation.examples, key=lambda each: (not each.is_shown, each.number))
    ]
