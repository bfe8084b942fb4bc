"""Run failing worlds again: with a corrected library, which of them still fail, and when one goes wrong now."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import nan

from understudy.addons.checks.falsification.failing_world import FailingWorld
from understudy.addons.checks.falsification.property_measure import (
    make_property_measure,
    make_success_measure,
)
from understudy.addons.checks.falsification.trial import TICKS_AT_ONCE, TrialMeasure
from understudy.errors import SettingError, UnderstudyError
from understudy.judging.properties.property_file import FILE
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.sim.team.libraries import Libraries


def rerun_failing_worlds(
    failing: Iterable[FailingWorld],
    library: Library | Libraries,
    *,
    properties: Sequence[Property] = (),
) -> list[FailingWorld]:
    """Run failing worlds again with a library, and say which of them still fail.

    Each is the same world as when it was found, bit for bit, with the same time limit, and is judged in the same way:
    by the goal, or by the property that failed.

    Parameters
    ----------
    failing
        The failing worlds.
    library
        The library with the behaviors; or for teams the library of each sort of agents.
    properties
        The properties of the library's file, for worlds in which one of them failed; see `load_properties`.

    Returns
    -------
    list[FailingWorld]
        The same worlds in the same order, with the results. One that cannot be run has a problem instead.
    """
    return [rerun_failing_world(each, library, properties=properties) for each in failing]


def rerun_failing_world(
    failing: FailingWorld,
    library: Library | Libraries,
    *,
    properties: Sequence[Property] = (),
) -> FailingWorld:
    """Run one failing world again; see `rerun_failing_worlds`.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior; or for a team the library of each sort of agents.
    properties
        The properties of the library's file.

    Returns
    -------
    FailingWorld
        The same world, with the result.
    """
    try:
        measure = make_failure_measure(failing, library, properties=properties)
        return replace(failing, robustness=float(measure([failing.trial]).robustness[0]), problem="")
    except UnderstudyError as error:
        return replace(failing, robustness=nan, problem=str(error))


def find_wrong_time(
    failing: FailingWorld, library: Library | Libraries, *, properties: Sequence[Property] = ()
) -> float | None:
    """Find when a behavior goes wrong in a failing world now, which a correction may have changed.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior; or for a team the library of each sort of agents.
    properties
        The properties of the library's file.

    Returns
    -------
    float | None
        The time, s; None if it no longer fails.

    Raises
    ------
    UnderstudyError
        If the library does not have the behavior, or `properties` lacks the property.
    """
    trial, tick_s = failing.trial, failing.trial.scenario.tick_s
    measure = make_failure_measure(failing, library, properties=properties)
    results = measure([trial])
    if not results.failed[0]:
        return None
    until_s = float(results.progress_s[0]) + TICKS_AT_ONCE * tick_s
    until_s = min(measure.get_limit(trial.scenario), until_s)
    return measure.find_wrong_moment(trial, until_s=until_s).tick * tick_s


def make_failure_measure(
    failing: FailingWorld, library: Library | Libraries, *, properties: Sequence[Property] = ()
) -> TrialMeasure:
    """Make what runs a behavior in a failing world and judges it as the search did that found it.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior; or for a team the library of each sort of agents.
    properties
        The properties of the library's file.

    Returns
    -------
    TrialMeasure
        The measure.

    Raises
    ------
    UnderstudyError
        If the library does not have the behavior, or `properties` lacks the property.
    """
    facts, scenario = failing.facts, failing.trial.scenario
    if facts.property is None:
        return make_success_measure(
            library, facts.behavior, scenario, binding=facts.binding, limit_s=facts.limit_s
        )
    subject = next((each for each in properties if each.name == facts.property), None)
    if subject is None:
        raise SettingError(
            where=str(failing.folder),
            setting="property",
            problem=f"is {facts.property!r}, which the library's {FILE} does not have",
            remedy="restore it there, or delete this folder",
        )
    return make_property_measure(subject, library, scenario, limit_s=facts.limit_s)
