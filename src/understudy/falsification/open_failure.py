"""Sessions that begin shortly before a behavior went wrong in a failing world, so that a press can correct it."""

from __future__ import annotations

from pathlib import Path

from understudy.analysis.evaluate import find_runners
from understudy.falsification.failing_run import FailingRun
from understudy.falsification.failing_world import FailingWorld, read_failing_world
from understudy.falsification.failure_moment import FailureMoment
from understudy.model.library import Library
from understudy.sim.scenario.files import add_markers
from understudy.sim.team.libraries import Libraries, collect_libraries, list_running_sorts
from understudy.training.session import Session

BEFORE_S = 3.0
"""The time before the failure at which a session begins by default, s."""

AFTER_S = 1.0
"""The time after the end of progress at which the innermost automaton is taken for the one that made the mistake, s."""


def open_failure(
    failing: FailingWorld | Path | str,
    library: Library | Libraries,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
) -> Session:
    """Open a live session some seconds before a behavior went wrong in a failing world.

    The robot runs as it ran in the search until then, and the session goes on from there with one of the automata that
    were running. A press corrects it; `save_automaton` keeps it. Other robots restart the behavior. In a team, where a
    coordinator is corrected all agents go on as they were; where a robot is, the other robots go on with their last
    orders, and coordinators give no further ones.

    Parameters
    ----------
    failing
        The failing world, or its folder.
    library
        The library with the behavior, and with the lesson to correct; or for a team the library of each sort of agents.
    name
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure it begins, s; later if the run, or that automaton, began later.

    Returns
    -------
    Session
        The session. Nothing has been recorded.

    Raises
    ------
    FileError
        If the folder does not have a failing world.
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or is that of a coordinator below another one.
    """
    found = failing if isinstance(failing, FailingWorld) else read_failing_world(failing)
    moment = find_failure_moment(found, library, name=name, before_s=before_s)
    session = Session(moment.body, moment.library, moment.lesson, targets=moment.targets, agent=moment.agent)
    moment.restore_in(session)
    return session


def find_failure_moment(
    failing: FailingWorld,
    library: Library | Libraries,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
    wrong_s: float | None = None,
) -> FailureMoment:
    """Run a failing world until some seconds before the behavior goes wrong.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior, and with the lesson to correct; or for a team the library of each sort of agents.
    name
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure, s; later if the run, or that automaton, began later.
    wrong_s
        When it goes wrong, s. None: as it was kept.

    Returns
    -------
    FailureMoment
        The moment.

    Raises
    ------
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or is that of a coordinator below another one.
    """
    scenario, facts = add_markers(failing.trial.scenario), failing.facts
    at_s = facts.wrong_s if wrong_s is None else wrong_s
    after_s = AFTER_S if facts.property is None else 0.0
    ticks, until = round((at_s - before_s) / scenario.tick_s), round((at_s + after_s) / scenario.tick_s)
    libraries, sort, behavior, found = find_runners(library, facts.behavior, scenario)
    if sort is None or isinstance(libraries, Library):
        libraries, sorts = collect_libraries(scenario, found), [*scenario.types]
    else:
        sorts = list_running_sorts(libraries, sort, behavior)
    roots = dict.fromkeys(sorts, (behavior, facts.binding))
    run = FailingRun(failing, scenario, libraries, roots, is_led=sort is not None)
    return run.find_moment(ticks, until, name=name)
