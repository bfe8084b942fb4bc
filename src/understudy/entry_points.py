"""Find objects that other packages offer by entry points, and objects of the user's own modules.

Each group of entry points is an extension point; `understudy.spi` has what each of them takes.
"""

from __future__ import annotations

import sys
from importlib import import_module, metadata
from pathlib import Path
from typing import Any, TypeVar

from understudy.errors import SettingError, UnderstudyError

KITS, WORLDS, STUDIES = "understudy.kits", "understudy.worlds", "understudy.studies"
"""Groups of entry points: kits, functions that make scenarios, and experiments."""

BODIES = "understudy.bodies"
"""Group of entry points: functions that make bodies, of robots or of worlds that are no scenarios."""

COMMANDS, BASELINES = "understudy.commands", "understudy.baselines"
"""Groups of entry points: commands of `understudy`, and functions from a scenario to its baseline, or None."""

TRANSPORTS = "understudy.transports"
"""Group of entry points: functions that connect to a robot, called as `transport` in robot files."""

EXPORT_TARGETS, READERS = "understudy.export_targets", "understudy.readers"
"""Groups of entry points: targets of exports, and readers of recordings, called as the end of the names of files."""

Offered = TypeVar("Offered")


def list_entry_points(group: str) -> list[str]:
    """List the names that installed packages offer in a group of entry points, as declared; nothing is imported."""
    return list(dict.fromkeys(entry.name for entry in metadata.entry_points(group=group)))


def load_instance(name: str, group: str, type: type[Offered], *, where: str, remedy: str) -> Offered:
    """Import an object as `load_object` does, and refuse one of another class.

    Parameters
    ----------
    name
        Name of an entry point of the group, or MODULE:NAME.
    group
        The group of entry points.
    type
        The class that the object must be an instance of.
    where
        The option or the function that was given the name, for the error.
    remedy
        What would be right, for the error.

    Returns
    -------
    Offered
        The object.

    Raises
    ------
    SettingError
        If there is no such object, its module raises an error when it is imported, or it is of another class.
    """
    found = load_object(name, group, where=where, remedy=remedy)
    if not isinstance(found, type):
        problem = f"is a {found.__class__.__name__}"
        raise SettingError(where=where, setting=repr(name), problem=problem, remedy=remedy)
    return found


def load_object(name: str, group: str, *, where: str, remedy: str) -> Any:
    """Import an object by its entry point or by its place.

    Parameters
    ----------
    name
        Name of an entry point of the group, or MODULE:NAME for a module that Python finds from the working folder.
    group
        The group of entry points.
    where
        The option or the function that was given the name, for the error.
    remedy
        What would be right, for the error.

    Returns
    -------
    Any
        The object; it can be anything.

    Raises
    ------
    SettingError
        If there is no such object, or its module raises an error when it is imported.
    """
    module, colon, attribute = name.partition(":")
    offered = list(metadata.entry_points(group=group, name=name))
    if not offered and not colon:
        problem = f"is not offered by any installed package (entry point group {group})"
        raise SettingError(where=where, setting=repr(name), problem=problem, remedy=remedy)
    try:
        if offered:
            return offered[0].load()
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.insert(0, here)
        return getattr(import_module(module), attribute)
    except UnderstudyError:
        raise
    except Exception as error:  # a user's module can raise any error when it is imported
        problem = f"cannot be imported: {type(error).__name__}: {error}"
        raise SettingError(where=where, setting=repr(name), problem=problem, remedy=remedy) from error
