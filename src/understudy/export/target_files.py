"""The seam of a target: what it is given, and what it returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from understudy.export.conformance import Conformance
from understudy.export.hierarchy import Hierarchy
from understudy.export.robot_interface import RobotInterface
from understudy.model.library import Library


@dataclass(frozen=True, slots=True)
class ExportJob:
    """Everything that a target is written from.

    `library` has the automata of the hierarchy, rounded if `single_precision`. `fingerprint` identifies the automata.
    `robot` is the robot that it is for, if a robot's file was given.
    """

    hierarchy: Hierarchy
    conformance: Conformance
    library: Library
    fingerprint: str
    single_precision: bool = False
    robot: RobotInterface | None = None


@dataclass(frozen=True, slots=True)
class TargetFiles:
    """The files of an export by their path in its folder, and how the target spells names.

    `names` has, by sort ("readings", "channels", "basics", "automata", "states"), the identifiers by name, where the
    target has such identifiers. A state's name there is "AUTOMATON/STATE". `makes` are the files that its tests make in
    the folder, which a later export may remove; a name that ends with "/" is a folder with all that is in it. `facts`
    are for the manifest, and `notes` are sentences for the person who exports.
    """

    files: Mapping[str, bytes]
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    makes: tuple[str, ...] = ()
    facts: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


MakeFiles: TypeAlias = Callable[[ExportJob], TargetFiles]
"""A target: a function from a job to its files. Beside those, every export gets a manifest."""
