"""Test all properties of a library's file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from understudy.errors import UnderstudyError
from understudy.judging.properties.property_file import find_condition_key, load_properties, locate_errors
from understudy.judging.properties.run_property import (
    PropertyResult,
    check_property,
    make_property_task,
    run_property,
)
from understudy.judging.rollout import Progress, skip_progress
from understudy.model.property import Property
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries


@dataclass(frozen=True, slots=True)
class FittingLibraries:
    """A scenario, and the libraries of all sorts of its agents."""

    scenario: Scenario
    libraries: Libraries


OpenWorld = Callable[[str], FittingLibraries]
"""A function that opens a scenario by name or path, and the libraries for it."""


def open_properties(path: Path | str, open_world: OpenWorld) -> list[tuple[Property, FittingLibraries]]:
    """Load a file of properties, and check that its scenarios and behaviors have all that it names.

    Parameters
    ----------
    path
        The file.
    open_world
        Opens a scenario and the libraries for it.

    Returns
    -------
    list[tuple[Property, FittingLibraries]]
        Each property with its scenario and the libraries for that.

    Raises
    ------
    FileError
        If the file is not valid, or names something that does not exist. It names the table and the key.
    """
    opened: dict[str, FittingLibraries] = {}
    return [(each, check_in_world(path, each, open_world, opened)) for each in load_properties(path)]


def check_in_world(
    path: Path | str,
    subject: Property,
    open_world: OpenWorld,
    opened: dict[str, FittingLibraries] | None = None,
) -> FittingLibraries:
    """Check that the scenario and the behavior of a property have all that it names.

    Parameters
    ----------
    path
        The file of the property, which errors name.
    subject
        The property.
    open_world
        Opens a scenario and the libraries for it.
    opened
        Scenarios that are open already, by name; the property's is added.

    Returns
    -------
    FittingLibraries
        The scenario of the property, and the libraries for it.

    Raises
    ------
    FileError
        If the property names something that does not exist. It names the table and the key.
    """
    opened = {} if opened is None else opened
    world = subject.start.world
    if world not in opened:
        with locate_errors(path, subject.name, "world"):
            opened[world] = open_world(world)
    where = opened[world]
    with locate_errors(path, subject.name, "behavior"):
        task = make_property_task(subject, where.libraries, where.scenario)
    with locate_errors(path, subject.name, find_condition_key(subject.kind)):
        check_property(subject, task, where.scenario)
    return where


def run_library_properties(
    path: Path | str, open_world: OpenWorld, *, progress: Progress = skip_progress
) -> Iterator[PropertyResult]:
    """Test the properties of a file one after the other; nothing is run before all have been checked.

    Parameters
    ----------
    path
        The file.
    open_world
        Opens a scenario and the libraries for it.
    progress
        Function called repeatedly with the number of completed worlds of a property and their total.

    Yields
    ------
    PropertyResult
        The result of each property, in order.

    Raises
    ------
    FileError
        If the file is not valid, or names something that does not exist. It names the table and the key.
    """
    for subject, where in open_properties(path, open_world):
        yield try_property(subject, {subject.start.world: where}.__getitem__, progress=progress)


def try_property(
    subject: Property, open_world: OpenWorld, *, progress: Progress = skip_progress
) -> PropertyResult:
    """Test a property in its scenario, which this function opens; if it cannot be run, the result has a problem."""
    try:
        where = open_world(subject.start.world)
        return run_property(subject, where.libraries, where.scenario, progress=progress)
    except UnderstudyError as error:
        return PropertyResult.from_problem(subject, str(error))
