"""Check of a target of exports, on the export of an automaton."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePosixPath

from understudy.addons.export.body_interface import BodyInterface, describe_body, describe_kit
from understudy.addons.export.export_automaton import prepare_export
from understudy.addons.export.export_folder import MANIFEST
from understudy.addons.export.target_files import ExportJob, FileByHand, TargetFiles
from understudy.addons.export.targets.target_table import ROWS, ExportTarget
from understudy.model.binding import NOTHING_BOUND
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.testing.laws import require, require_call


def check_export_target(
    target: ExportTarget,
    library: Library,
    name: str,
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    body: Body | None = None,
) -> None:
    """Check that a target makes the files of an export as its contract says.

    The same job must give the same files, all of them bytes at places within the folder, and none that the export adds
    itself. Identifiers must belong to names of the hierarchy, each to one. A target in single precision is checked with
    such a job, too.

    Parameters
    ----------
    target
        The target.
    library
        The library of the automaton. Choose one with all that the target translates, such as flags and functions.
    name
        Name of the automaton that is exported.
    binding
        A target for each of its parameters.
    body
        The body that it is for. None: channels are at rest at 0, and a tick is 0.1 s.

    Raises
    ------
    LawBroken
        If the target breaks a rule.
    """
    part = f"export target {getattr(target, 'function', target)!r}"
    law = "it is an ExportTarget"
    require(isinstance(target, ExportTarget), part, law, f"it is a {type(target).__name__}")
    interface: BodyInterface = describe_kit(library) if body is None else describe_body(body)
    for single in (False, True) if target.single_precision else (False,):
        job = prepare_export(
            library,
            name,
            to="c99",  # which has single precision
            binding=binding,
            body=interface,
            fingerprint="check",
            single_precision=single,
        )
        _check_job(part, target, job)


def _check_job(part: str, target: ExportTarget, job: ExportJob) -> None:
    law = "it makes files of every job"
    made, again = (require_call(part, law, lambda: target.load()(job)) for _ in range(2))
    require(isinstance(made, TargetFiles), part, "it returns TargetFiles", f"it returned {made!r:.60}")
    require(made == again, part, "the same job gives the same files", "the second time they differ")
    require(bool(made.files or made.by_hand), part, "it makes a file at least", "it made none")
    copies = [path for file in made.by_hand.values() for path in file.copies]
    for path in (*made.files, *made.by_hand, *copies):
        _check_path(part, path)
    for path, content in made.files.items():
        law = "the content of a file is bytes"
        require(isinstance(content, bytes), part, law, f"that of {path!r} is {type(content).__name__}")
    for path, file in made.by_hand.items():
        law = "a file of functions to write is a FileByHand"
        require(isinstance(file, FileByHand), part, law, f"{path!r} is a {type(file).__name__}")
    both = sorted(set(made.makes) & {*made.files, *made.by_hand})
    require(not both, part, "what its tests make is none of its files", f"both have {both}")
    for note in made.notes:
        require(isinstance(note, str), part, "its notes are sentences", f"one is {note!r:.60}")
    _check_names(part, made, job)
    require_call(part, "its identifiers fit the conformance rows", lambda: target.make_files(job))


def _check_path(part: str, path: object) -> None:
    law = "files have paths within the folder, with / between their parts"
    pure = PurePosixPath(str(path))
    inside = isinstance(path, str) and str(pure) == path and not pure.is_absolute() and ".." not in pure.parts
    require(inside and "\\" not in str(path), part, law, f"one is {path!r}")
    law = "it makes no file that the export adds"
    require(path not in (MANIFEST, ROWS), part, law, f"it makes {path}")


def _check_names(part: str, made: TargetFiles, job: ExportJob) -> None:
    hierarchy = job.hierarchy
    known = {
        "readings": [str(slot) for slot in hierarchy.readings],
        "channels": [channel.name for channel in hierarchy.channels],
        "basics": [basic.name for basic in hierarchy.basics],
        "automata": [each.name for each in hierarchy.automata],
        "states": [f"{each.name}/{state.name}" for each in hierarchy.automata for state in each.states],
    }
    for sort, names in made.names.items():
        law = f"its identifiers are of {', '.join(known)}"
        require(sort in known, part, law, f"it has some of {sort!r}")
        strange = sorted(set(names) - set(known[sort]))
        require(not strange, part, "identifiers belong to names of the hierarchy", f"it has {strange}")
        identifiers = list(names.values())
        if sort != "states":  # which may be called the same in two automata
            law = "no two names have the same identifier"
            require(len(set(identifiers)) == len(identifiers), part, law, f"{sort} have {identifiers}")
