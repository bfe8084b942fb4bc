"""Descriptions of decisions, as sentences for people and as plain data for programs.

The terminal, the web page and the command line all take their texts from here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from understudy.errors import join_names
from understudy.learning.explain import Explanation
from understudy.model.describe import convert_to_plain, format_values
from understudy.model.example_source import ExampleSource
from understudy.model.lesson import ExampleKind

if TYPE_CHECKING:
    from understudy.judging.explain_run import (
        AgentExplanation,
        DecisionReason,
        LevelExplanation,
        RunExplanation,
    )

MOST_EXAMPLES = 6
"""The largest number of examples that a sentence names."""
DIGITS = 6
"""The number of digits to which times are rounded, in s."""


def describe_decision(explanation: Explanation) -> str:
    """Describe a decision and its conditions: "goes from forward to done because distance_to(A) is below 0.35 m"."""
    stays = explanation.next == explanation.state
    what = (
        f"stays in {explanation.state}" if stays else f"goes from {explanation.state} to {explanation.next}"
    )
    return what + _describe_conditions(explanation)


def describe_switch(before: str, after: str, explanation: Explanation, examples: str = "") -> str:
    """Describe why an automaton went from state `before` to `after`.

    If the lesson has changed since and would decide otherwise, the present decision is added. `examples`, a text as
    from `list_examples`, follows the conditions.
    """
    what = f"went from {before} to {after}"
    if explanation.next == after:
        return f"{what}{_describe_conditions(explanation)}{examples}"
    return f"{what}; by now it {describe_decision(explanation)}{examples}"


def describe_rest(level: LevelExplanation) -> str:
    """Describe why an automaton had no decision to make."""
    return (
        f"{level.flag} is raised; a flag state is never left" if level.flag else "there are no examples there"
    )


def describe_present(decision: Explanation | None, flag: str | None) -> str:
    """Describe in a sentence the present decision of an automaton.

    `decision` is None if the automaton's flag is raised.
    """
    if decision is None:
        return f"It raised {flag}; a flag state is never left."
    return f"It {describe_decision(decision)}{list_examples(decision)}."


def describe_intention(decision: Explanation | None) -> str:
    """Describe, while a person decides, the decision that the automaton itself would make in testing.

    `decision` is None if the automaton's flag is raised.
    """
    if decision is None:
        return "A raised flag is never left."
    return f"In testing it {describe_decision(decision)}{list_examples(decision)}."


def list_examples(explanation: Explanation) -> str:
    """Name the press-made examples behind a decision: " (shown by 3, 7)"; return an empty text if there are none."""
    numbers = [str(example.number) for example in explanation.examples if example.is_from_press]
    if not (explanation.shown and numbers):
        return ""
    more = "…" if len(numbers) > MOST_EXAMPLES else ""
    return f" (shown by {', '.join(numbers[:MOST_EXAMPLES])}{more})"


def describe_values(reason: DecisionReason) -> str:
    """Format the feature values of a decision: "distance_to(A) = 3.42 m, angle_to(A) = −31°"."""
    return format_values(reason.taught.automaton.features, list(reason.values.values()))


def describe_source(reason: DecisionReason) -> str:
    """Describe the examples behind a decision.

    The text is such as "shown by 3 (directive at 12.3 s), 7 (correction at 40.1 s) and 5 more", or for examples made
    from recordings "shown by 3 (directive, anna.csv at 12.3 s, driven by anna)".
    """
    if reason.taught.lesson is None:
        return "it was written by hand: no example is behind it"
    examples = list_example_data(reason)
    named = [_describe_example(each) for each in examples[:MOST_EXAMPLES]]
    more = [f"{len(examples) - len(named)} more"] if len(examples) > len(named) else []
    return f"shown by {join_names([*named, *more])}" if named else ""


def _describe_conditions(explanation: Explanation) -> str:
    """Describe the conditions of a decision, or say that no example was given under them."""
    held = " and ".join(explanation.conditions)
    if explanation.shown:
        return f" because {held}" if held else ", always"
    return f": there are no examples where {held}" if held else ": there are no examples there"


def _describe_example(example: DecisionExampleData) -> str:
    corrects = example.correction and example.kind is not ExampleKind.DEFAULT
    when = "" if example.shown_s is None else f" at {example.shown_s:.1f} s"
    when = when if example.source is None else f", {example.source}"
    return f"{example.number} ({'correction' if corrects else example.kind}{when})"


@dataclass(frozen=True, slots=True)
class DecisionExampleData:
    """An example behind a decision.

    `shown_s` is when it was recorded, in s since its session began; None if it was not recorded in a session.
    `source` is the place in a recording that it was made from; None for any other example.
    """

    number: int
    kind: ExampleKind
    correction: bool
    next: str
    shown_s: float | None
    source: ExampleSource | None = None


@dataclass(frozen=True, slots=True)
class DecisionData:
    """A decision and its reasons, as `--json` prints it.

    `values` has the feature values by label, and `read` the same as text. `shown` is False if no example was ever
    given under such values. `by_hand` is True if the automaton has no lesson.
    """

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
        """Convert a decision to data."""
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
        """Convert a decision to data; return None for None."""
        return None if reason is None else cls.from_reason(reason)


@dataclass(frozen=True, slots=True)
class DecisionLevelData:
    """One automaton of an agent, as `--json` prints it.

    `since_s` is when its state was entered, in s. `decision` is that of the explained tick; if there was none,
    `rests` is the reason. `entry` is the decision that entered the state; None if the automaton started there.
    """

    automaton: str
    state: str
    since_s: float
    decision: DecisionData | None
    rests: str | None
    entry: DecisionData | None

    @classmethod
    def from_level(cls, level: LevelExplanation) -> DecisionLevelData:
        """Convert one automaton of an agent to data."""
        decision, entry = map(DecisionData.from_optional_reason, (level.decision, level.entry))
        rests = describe_rest(level) if level.decision is None else None
        return cls(level.automaton, level.state, round(level.since_s, DIGITS), decision, rests, entry)


@dataclass(frozen=True, slots=True)
class AgentData:
    """One agent, a coordinator or the robot, as `--json` prints it.

    `ordered` is the last order that it got; None if no coordinator is above it.
    """

    sort: str
    agent: int
    ordered: str | None
    levels: Sequence[DecisionLevelData]

    @classmethod
    def from_agent(cls, agent: AgentExplanation) -> AgentData:
        """Convert an agent to data."""
        return cls(
            agent.sort,
            agent.agent,
            agent.ordered,
            [DecisionLevelData.from_level(each) for each in agent.levels],
        )


@dataclass(frozen=True, slots=True)
class WhyData:
    """The decisions of all levels at a moment of a run, as `--json` prints them.

    `former` has the version number, by name, of automata that were changed after the run.
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
        """Convert the explanation of a moment of a run to data."""
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
    """List the examples behind a decision: directives and confirmations first, each group by number."""
    return [
        DecisionExampleData(
            each.number,
            each.kind,
            each.correction,
            each.next,
            reason.moments.get(each.number),
            each.source,
        )
        for each in sorted(reason.explanation.examples, key=lambda each: (not each.is_shown, each.number))
    ]
