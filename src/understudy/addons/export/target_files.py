"""The seam of a target: what it is given, what it returns, and the templates that it fills in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from string import Template

from understudy.addons.export.body_interface import RobotInterface
from understudy.addons.export.conformance import Conformance
from understudy.addons.export.hierarchy import Hierarchy
from understudy.addons.export.single_precision import RoundedCut
from understudy.model.library import Library

TEMPLATES = Path(__file__).parent / "templates"
"""The folder of templates of exported files."""


@dataclass(frozen=True, slots=True)
class ExportJob:
    """Everything that a target is written from.

    `library` has the automata of the hierarchy, rounded if `single_precision`; `rounded` are the cuts that this decides
    otherwise. `fingerprint` identifies the automata. `robot` is the robot that it is for, if a robot's file was given.
    """

    hierarchy: Hierarchy
    conformance: Conformance
    library: Library
    fingerprint: str
    single_precision: bool = False
    robot: RobotInterface | None = None
    rounded: tuple[RoundedCut, ...] = ()


@dataclass(frozen=True, slots=True)
class FileByHand:
    """A file of functions that a person fills in. It is written once, and later exports keep what it has become.

    `begin` is its first part. `stubs` has, by the name of each function, what stands for it until it is written; an
    export appends those that the file does not name yet. `copies` are paths that get the same content.
    """

    begin: str
    stubs: Mapping[str, str]
    copies: tuple[str, ...] = ()

    def write(self) -> bytes:
        """Write the file as it is before anything is filled in.

        Returns
        -------
        bytes
            The content.
        """
        return "\n".join((self.begin, *self.stubs.values())).encode()


def fingerprint_file(content: bytes) -> str:
    """Return what tells whether a file of functions to write is still as it was exported."""
    return sha256(content).hexdigest()


@dataclass(frozen=True, slots=True)
class TargetFiles:
    """The files of an export by their path in its folder, and how the target spells names.

    `names` has, by sort ("readings", "channels", "basics", "automata", "states"), the identifiers by name, where the
    target has such identifiers. A state's name there is "AUTOMATON/STATE". `makes` are the files that its tests make in
    the folder, which a later export may remove; a name that ends with "/" is a folder with all that is in it. `by_hand`
    are files of functions to fill in. `facts` are for the manifest, `notes` are sentences for the person who exports.
    """

    files: Mapping[str, bytes]
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    makes: tuple[str, ...] = ()
    facts: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    by_hand: Mapping[str, FileByHand] = field(default_factory=dict)


def fill_template(name: str, values: Mapping[str, str]) -> bytes:
    """Fill in a template: `$name` and `${name}` stand for values, `$$` for a dollar sign."""
    return Template((TEMPLATES / name).read_text(encoding="utf-8")).substitute(values).encode()


def fill_templates(folder: str, values: Mapping[str, str], *names: str) -> dict[str, bytes]:
    """Fill in templates of a target's folder, which keep their names."""
    return {name: fill_template(f"{folder}/{name}", values) for name in names}
