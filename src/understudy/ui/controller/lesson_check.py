"""The static check of a lesson that is being taught: what its automaton cannot do, without a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import nan

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.scenario_facts import ScenarioFacts, collect_scenario_facts
from understudy.coaching.advice import Advice, AdviceKind
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree_regions import Box, make_full_value_set
from understudy.runtime.body import Body
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.world import World

SAME_SUBJECT: Mapping[FindingKind, AdviceKind] = {
    FindingKind.NEVER_ENTERED: AdviceKind.NEVER_ENTERED,
    FindingKind.NEVER_LEFT: AdviceKind.NEVER_LEFT,
}
"""Kinds of findings that the coach gives advice on."""


def check_lesson(
    lesson: Lesson,
    transitions: Mapping[str, Transition],
    library: Library,
    body: Body,
    *,
    advice: Sequence[Advice] = (),
) -> tuple[Finding, ...]:
    """Check the automaton that is learned from a lesson, with all that it runs.

    Parameters
    ----------
    lesson
        The lesson.
    transitions
        What is learned from it: the transition function of each state.
    library
        The automata and basic behaviors that its states run.
    body
        The robots. Only of simulated ones what their scenario guarantees is assumed.
    advice
        The coach's advice on the lesson. Findings that it states already are left out.

    Returns
    -------
    tuple[Finding, ...]
        Errors and warnings, the most severe first; nothing before the first example. Notes are left out: while a
        lesson is short, nearly all its cells rest on one example.
    """
    if not lesson.examples:
        return ()
    taught = TrainedAutomaton(replace(lesson.automaton, transitions=dict(transitions)), lesson)
    whole = library.with_automaton(taught)
    facts = _collect_facts(body, whole)
    report = check_library(whole, [lesson.automaton.name], facts=facts, kit_known=True)
    advised = {(each.kind, each.state) for each in advice}
    return tuple(
        each
        for each in report.findings
        if each.severity is not Severity.NOTE
        and not any((SAME_SUBJECT.get(each.kind), state) in advised for state in each.states)
    )


@dataclass(frozen=True, slots=True)
class FindingSituation:
    """The situation of a finding, to be set up; see `SituationSpec`."""

    sentence: str
    state: str
    region: Box
    at: tuple[float, ...]


def locate_finding(finding: Finding, lesson: Lesson) -> FindingSituation | None:
    """Return the first cell of a finding as a situation in which the robot can be placed.

    None if the finding has no cell, or its cell restricts features that the lesson does not have.
    """
    features = lesson.automaton.features
    for cell in finding.cells[:1]:
        if set(cell.features) <= set(features) and finding.states:
            region = dict(zip(cell.features, cell.box, strict=True))
            values = dict(zip(cell.features, cell.at, strict=True))
            return FindingSituation(
                finding.sentence,
                finding.states[0],
                tuple(region.get(each) or make_full_value_set(each.feature.kind) for each in features),
                tuple(values.get(each, nan) for each in features),
            )
    return None


def _collect_facts(body: Body, library: Library) -> ScenarioFacts:
    ground = body.ground if isinstance(body, CoordinatorBody) else body
    if not isinstance(ground, World):
        return ScenarioFacts(tick_s=body.tick_s)
    squad = body.squads.squad if isinstance(body, CoordinatorBody) else None
    return replace(collect_scenario_facts(ground.scenario, library, squad), tick_s=body.tick_s)
