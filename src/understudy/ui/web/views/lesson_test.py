"""Test lessons, evaluate in unseen worlds, find regressions before saving, and preview pruning for the page."""

from __future__ import annotations

from itertools import count, islice

from msgspec import field

from understudy.errors import SessionError, SettingError, UnderstudyError
from understudy.judging.evaluate import SUCCESS_FLAG, evaluate, make_evaluation_task
from understudy.judging.properties import lesson_tests
from understudy.judging.properties.lesson_tests import (
    LessonTestResult,
    find_regressions_since_saved,
    run_lesson_test,
)
from understudy.judging.properties.monitor import PropertyRule
from understudy.judging.properties.offered_goals import find_behavior_success
from understudy.judging.simplify_preview import BeforeAfter
from understudy.learning.fit import learn
from understudy.learning.pruning_suggestions import ENOUGH, PruningSuggestion
from understudy.model.binding import format_bound_name
from understudy.model.library import Library, TrainedAutomaton, list_dependencies
from understudy.model.property import Property, StoredMoment
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.files import format_scenario
from understudy.sim.world import World
from understudy.storage.library_folder import list_versions, load_version
from understudy.training.other_agents import SessionSnapshot
from understudy.ui.controller import lesson_actions
from understudy.ui.controller.lesson_actions import preview_pruning
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import (
    CancelEvaluation,
    EvaluateSession,
    GoToProperty,
    PreviewSimplify,
    TestLesson,
)
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.unseen_worlds import UnseenWorldsEvaluation

FIRST_SEED = 1000
"""Unseen worlds are counted from here: those that people go through one after the other begin at 0."""
MOST_WORLDS = 1000
SAVED = "it was saved"


class PropertyResultData(Data, frozen=True, kw_only=True):
    """The result of testing a property of the lesson."""

    description: str
    was_met: bool = field(name="held")
    took_s: float | None
    """The time until what it demands was reached, s; null where it was not, or the property demands nothing."""
    problem: str
    """Why it could not be tested; empty if it could."""


class LessonTestData(Data, frozen=True, kw_only=True):
    """The result of testing an automaton on its lesson."""

    name: str
    is_passing: bool = field(name="works")
    examples: int
    otherwise: int
    """How many examples, shown or watched, are decided otherwise."""
    properties: list[PropertyResultData]
    """In the order of the lesson."""
    regressions: list[str]
    """The regressions: what worked before and no longer does."""
    differences: list[str]
    """The other decisions that differ from the former version."""


class LessonTestReply(Data, frozen=True, kw_only=True):
    """The result of testing an automaton on its lesson."""

    test: LessonTestData


def handle_test_lesson(host: SessionHost, message: TestLesson) -> LessonTestReply:
    """Test an automaton on its lesson and compare it with its former version; unsaved changes count."""
    name, library = message.name, _present(host)
    library.automaton(name)
    formers = {each: _former(host, each) for each in list_dependencies(library, name)}
    libraries = host.groups.collect_libraries(host.sort, host.agent, library)
    result = run_lesson_test(
        library, name, {each: taught for each, (_, taught) in formers.items() if taught}, libraries
    )
    return LessonTestReply(test=_tested(result, formers[name][0]))


def _present(host: SessionHost) -> Library:
    """Return the library with the automaton in training in its present state."""
    trainer, library = host.trainer, host.library_view.library
    return library if trainer is None else library.with_automaton(trainer.session.make_trained_automaton())


def _former(host: SessionHost, name: str) -> tuple[str, TrainedAutomaton | None]:
    """Return the name and the automaton of the state to compare with: the saved one, or the last former version."""
    trainer, saved = host.trainer, host.library_view.library.taught.get(name)
    if trainer is not None and name == trainer.name and trainer.has_unsaved_changes:
        return SAVED, saved
    versions = list_versions(host.library_view.folder, name)
    if not versions:
        return "", None
    try:
        last = load_version(host.library_view.folder, name, versions[-1].number, host.kit, learn).taught
    except UnderstudyError:
        return "", None  # it cannot be compared with
    return f"version {versions[-1].number}", last


def _tested(result: LessonTestResult, former: str) -> LessonTestData:
    return LessonTestData.of(
        result,
        examples=result.replayed.examples,
        otherwise=len(result.replayed.mismatches) + result.replayed.overruled,
        properties=[PropertyResultData.of(each, description=str(each.tested)) for each in result.properties],
        regressions=list(lesson_tests.describe_regressions(result)),
        differences=list(lesson_tests.describe_other_differences(result, former)),
    )


def find_unsaved_regressions(host: SessionHost) -> tuple[str, ...]:
    """Return what worked with the saved automaton and no longer does, including in the automata that use it."""
    library, taught = host.library_view.library, host.active_trainer.session.make_trained_automaton()
    libraries = host.groups.collect_libraries(host.sort, host.agent, library)
    return find_regressions_since_saved(host.library_view.folder, library, taught, libraries)


def handle_evaluate_session(host: SessionHost, message: EvaluateSession) -> StatusMessage:
    """Start an evaluation of the automaton in training in worlds that the page has not shown."""
    trainer, scenario = host.active_trainer, host.world.scenario
    if not 1 <= message.count <= MOST_WORLDS:
        problem, remedy = f"is {message.count}", f"give one from 1 to {MOST_WORLDS}"
        raise SettingError(where="the studio", setting="number of worlds", problem=problem, remedy=remedy)
    if isinstance(host.world, BodyWorld):
        raise SessionError(
            f"{host.world.name} is a body of your own: test it in other worlds with understudy eval"
        )
    if not isinstance(host.world, World):
        raise SessionError("real robots cannot be tested in other worlds")
    if host.sort is not None:
        raise SessionError("coordinators cannot be tested in other worlds yet, only behaviors of robots")
    if host.evaluation is not None and host.evaluation.is_running:
        raise SessionError("a test in other worlds is running already: wait for it, or cancel it")
    if not any(example.is_from_press for example in trainer.session.examples):
        raise SessionError("there is nothing to test yet: press a state to direct the robot first")
    name, library, targets = trainer.name, _present(host), dict(trainer.session_view.targets)
    success = find_behavior_success(library, name)
    if success is None and scenario.goal is None:
        raise SessionError(
            f"success is not defined: scenario {scenario.name} has no goal, and {name} has no flag "
            f"{SUCCESS_FLAG}, nor a single other one; choose what success means beside the score"
        )
    goal = PropertyRule(success) if isinstance(success, Property) else None
    make_evaluation_task(library, name, scenario, binding=targets, goal=goal)  # mistakes are told at once
    unseen = (seed for seed in count(FIRST_SEED) if seed not in host.seen_seeds)
    seeds = list(islice(unseen, message.count))
    data = host.session_data()
    host.evaluation = UnseenWorldsEvaluation(
        format_bound_name(name, targets),
        0 if data is None else data.edition,
        targets,
        worlds=len(seeds),
        evaluate=lambda progress: evaluate(
            library, name, scenario, seeds, binding=targets, goal=goal, progress=progress
        ),
        beside=host.beside,
    )
    plural = "s" * (len(seeds) != 1)
    return StatusMessage(f"Testing {name} in {len(seeds)} unseen world{plural}")


def handle_cancel_evaluation(host: SessionHost, _: CancelEvaluation) -> StatusMessage | None:
    """Cancel the evaluation in unseen worlds, or drop its result."""
    running = host.evaluation is not None and host.evaluation.is_running
    host.end_evaluation()
    return StatusMessage("Test cancelled") if running else None


def go_to_property(host: SessionHost, message: GoToProperty) -> StatusMessage:
    """Restore the moment from which a property starts, with the automaton restarted; record nothing."""
    trainer = host.active_trainer
    subject = lesson_actions.find_property(trainer, message.property)
    start = subject.start
    if not isinstance(start, StoredMoment):
        raise SessionError("this property has no stored moment")
    if start.scenario != format_scenario(host.world.scenario) or start.sort != (host.sort or ""):
        raise SessionError(f"this property starts in another world: {start.world} as it was then")
    if start.agent != trainer.session.agent:
        raise SessionError(f"this property is about robot {start.agent + 1}: train that robot to see it")
    others = trainer.session.other_agents.snapshot()
    host.go_back(SessionSnapshot(start.snapshot, (), trainer.session.mode, others))
    if dict(subject.targets) != dict(trainer.session_view.targets):
        trainer.bind_targets(subject.targets)
    return StatusMessage(f"Property from here: {subject}")


class StateConditionsData(Data, frozen=True, kw_only=True):
    """The conditions for leaving a state, in words, before and after pruning."""

    state: str
    before: list[str]
    after: list[str]


class ChangedDecisionData(Data, frozen=True, kw_only=True):
    """An example at which the pruned automaton decides differently."""

    number: int
    state: str
    shown: str
    before: str | None
    after: str | None


class MomentsData(Data, frozen=True, kw_only=True):
    """The number of moments in the second before presses, and at how many the decision changes."""

    all: int
    changed: int


class SimplifyPreviewData(Data, frozen=True, kw_only=True):
    """A preview of the automaton with fewer splits."""

    pruning: float
    suggested: PruningSuggestion | None
    """Null if there are too few examples for a suggestion."""
    examples_needed: int
    """The number of examples needed for a suggestion."""
    leaves: BeforeAfter[int]
    """The number of leaves of all trees."""
    states: list[StateConditionsData]
    decisions: list[ChangedDecisionData]
    examples: int
    """The number of examples replayed."""
    moments: MomentsData


class SimplifyReply(Data, frozen=True, kw_only=True):
    """A preview of the automaton with fewer splits."""

    preview: SimplifyPreviewData


def handle_preview_simplify(host: SessionHost, message: PreviewSimplify) -> SimplifyReply:
    """Return the conditions before and after pruning and the decisions that would change, without changing anything."""
    preview = preview_pruning(host.active_trainer, message.pruning)
    changed = sum(each.moments for each in preview.replayed.changes)
    return SimplifyReply(
        preview=SimplifyPreviewData.of(
            preview,
            examples_needed=ENOUGH,
            states=[StateConditionsData.of(each, state=state) for state, each in preview.conditions.items()],
            examples=preview.replayed.examples,
            moments=MomentsData(all=preview.replayed.before, changed=changed),
        )
    )
