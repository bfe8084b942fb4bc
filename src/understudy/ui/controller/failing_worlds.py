"""Failing worlds in a user interface: run them again with what is in training, and open a session in one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path

from understudy.addons.checks.falsification.failing_world import FailingWorld
from understudy.addons.checks.falsification.open_failure import TeachingMoment, find_failure_moment
from understudy.addons.checks.falsification.rerun_failures import find_wrong_time, rerun_failing_world
from understudy.errors import SessionError, UnderstudyError, UnknownName
from understudy.judging.properties.library_properties import FittingLibraries, run_library_properties
from understudy.judging.properties.property_file import FILE, load_properties
from understudy.judging.properties.run_property import PropertyResult
from understudy.judging.rollout import Progress, skip_progress
from understudy.learning.fit import learn
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.property import Property
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.files import add_markers
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import (
    Libraries,
    collect_libraries,
    find_type_folders,
    load_type_libraries,
)
from understudy.storage.library_folder import open_each_automaton
from understudy.ui.controller.interrupted_sessions import finish_journal
from understudy.ui.controller.open_session import OpenSession, begin_session
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices, SessionStart, TrainingPlan

FOLDER = Path("failures")
"""The folder of failing worlds, where `understudy falsify` keeps them by default."""


@dataclass(frozen=True, slots=True)
class Draft:
    """The automaton in training as it stands, and the folder that it is saved to."""

    taught: TrainedAutomaton
    folder: Path
    unsaved: bool

    @property
    def name(self) -> str:
        """Its name."""
        return self.taught.automaton.name


def make_draft(trainer: Trainer | None) -> Draft | None:
    """Make the draft of what is in training; None if nothing is, or nothing was shown yet."""
    if trainer is None or not trainer.session.examples:
        return None
    return Draft(trainer.session.make_trained_automaton(), trainer.folder, trainer.has_unsaved_changes)


@dataclass(frozen=True, slots=True)
class LibrarySource:
    """The folder of a library, and the kit with which its automata are read for a scenario."""

    folder: Path
    find_kit: Callable[[Scenario], Kit]

    def open_libraries(self, scenario: Scenario, draft: Draft | None = None) -> Libraries:
        """Open the libraries of all sorts of agents in a scenario, with the draft in its place."""

        def look(where: Path, kit: Kit) -> Library:
            library = open_each_automaton(where, kit, learn).library if where.is_dir() else Library(kit)
            here = draft is not None and draft.folder.absolute() == where.absolute()
            return library.with_automaton(draft.taught) if draft is not None and here else library

        robots = load_type_libraries(scenario, self.folder, self.find_kit(scenario), look)
        return collect_libraries(scenario, robots, lambda name, kit: look(self.folder / name, kit))

    def open_world(self, name: str, draft: Draft | None = None) -> FittingLibraries:
        """Open a scenario by name or path, and the libraries for it, with the draft in its place."""
        scenario = find_scenario(name)
        return FittingLibraries(scenario, self.open_libraries(scenario, draft))

    def load_properties(self) -> tuple[Property, ...]:
        """Load the properties of the library's file; none if it has no file."""
        path = self.folder / FILE
        return load_properties(path) if path.exists() else ()


@dataclass(frozen=True, slots=True)
class RerunResults:
    """The results of running failing worlds and the library's properties; `problem` says why the latter were not."""

    worlds: tuple[FailingWorld, ...]
    properties: tuple[PropertyResult, ...]
    problem: str = ""


def rerun_all(
    worlds: Sequence[FailingWorld],
    library: LibrarySource,
    draft: Draft | None,
    *,
    progress: Progress = skip_progress,
) -> RerunResults:
    """Run failing worlds again with what is in training, and the properties of the library's file beside them.

    Parameters
    ----------
    worlds
        The failing worlds.
    library
        The library.
    draft
        What is in training.
    progress
        Function called with the number of finished worlds and their total.

    Returns
    -------
    RerunResults
        The results.
    """
    opened = dict[str, Libraries]()

    def open_once(scenario: Scenario) -> Libraries:
        key = scenario.name
        if key not in opened or scenario.squads:  # the members of squads are counted in each scenario
            opened[key] = library.open_libraries(scenario, draft)
        return opened[key]

    def open_world(name: str) -> FittingLibraries:
        scenario = find_scenario(name)
        return FittingLibraries(scenario, open_once(scenario))

    problem, claims = "", tuple[Property, ...]()
    try:
        claims = library.load_properties()
    except UnderstudyError as error:
        problem = str(error)
    results = list[FailingWorld]()
    for number, each in enumerate(worlds):
        progress(number, len(worlds))
        try:
            results.append(rerun_failing_world(each, open_once(each.trial.scenario), properties=claims))
        except UnderstudyError as error:
            results.append(replace(each, robustness=nan, problem=str(error)))
    progress(len(worlds), len(worlds))
    properties = list[PropertyResult]()
    if claims:
        try:
            for result in run_library_properties(
                library.folder / FILE,
                open_world,
                progress=lambda *_: progress(len(worlds), len(worlds)),
            ):
                properties.append(result)
        except UnderstudyError as error:
            problem = str(error)
    return RerunResults(tuple(results), tuple(properties), problem)


@dataclass(frozen=True, slots=True)
class PreparedSession:
    """A session that can begin at a moment of a run, in a failing world shortly before it goes wrong."""

    moment: TeachingMoment
    plan: TrainingPlan
    sentence: str
    name: str
    """The name of the failing world."""

    def begin(self, wall: Callable[[], float]) -> OpenSession:
        """Begin the session with a journal of its own, paused at that moment."""
        start = SessionStart(self.moment.lesson, dict(self.moment.targets))
        opened = begin_session(
            self.plan,
            start,
            wall,
            body=self.moment.body,
            agent=self.moment.agent,
            carried_to=self.name,
        )
        trainer = opened.trainer
        try:
            self.moment.restore_in(trainer.session)
            trainer.session.test(afresh=False)  # until a press, nothing that happens here teaches
            trainer.note_moved("back")
            trainer.pause()
        except BaseException:
            opened.close()
            finish_journal(opened.journal, self.plan.folder, self.plan.name)
            raise
        trainer.status = StatusMessage(self.sentence)
        return opened


def prepare_failure(
    failing: FailingWorld, library: LibrarySource, draft: Draft | None, *, discard: bool = False
) -> PreparedSession:
    """Run a failing world until shortly before it goes wrong with what is in training; nothing is changed yet.

    The automaton to correct is the innermost one that runs then. If the draft is unsaved, it is the draft.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library.
    draft
        What is in training.
    discard
        Whether an unsaved draft that does not run then may be left.

    Returns
    -------
    PreparedSession
        The moment, from which a session can begin.

    Raises
    ------
    UnderstudyError
        If the behavior cannot be run or corrected there, or the draft is unsaved and does not run then.
    """
    scenario = add_markers(failing.trial.scenario)
    libraries = library.open_libraries(scenario, draft)
    wrong_s = find_wrong_time(failing, libraries, properties=library.load_properties())
    moment = find_failure_moment(failing, libraries, wrong_s=wrong_s)
    if draft is not None and draft.unsaved and moment.name != draft.name:
        try:
            moment = find_failure_moment(failing, libraries, name=draft.name, wrong_s=wrong_s)
        except UnknownName:
            if not discard:
                raise SessionError(
                    f"{draft.name} has unsaved changes: save it first, or discard them"
                ) from None
    sort = moment.sort or moment.world.names.types[int(moment.world.state.robots["type"][moment.agent])]
    places = find_type_folders(scenario, library.folder, library.find_kit(scenario))
    folder = library.folder / sort if moment.sort else places[sort][0]
    saved = library.open_libraries(scenario)[sort]
    plan = TrainingPlan(
        moment.name, folder, moment.world.scenario, saved, LessonChoices(), failing.trial.seed
    )
    sentence = describe_opening(failing, moment, wrong_s)
    return PreparedSession(moment, plan, sentence, failing.folder.name)


def describe_opening(failing: FailingWorld, moment: TeachingMoment, wrong_s: float | None) -> str:
    """Describe where a session in a failing world begins."""
    before_s = (failing.facts.wrong_s if wrong_s is None else wrong_s) - moment.world.time_s
    where = (
        "where it goes wrong" if before_s < moment.world.tick_s else f"{before_s:.1f} s before it goes wrong"
    )
    if wrong_s is None:
        where = f"at {moment.world.time_s:.1f} s; it passes now"
    return f"Paused in {failing.folder.name}, {where}. Press what {moment.name} should do, and resume"
