"""Export of an automaton of a library, with everything below it, to a folder of files that run without Understudy.

An export goes one way, in which each step takes what the last one made: the cuts of the automata are rounded, if
single precision is asked for; the program is linked, and flattened to plain tables (`hierarchy`); a run of the program
answers rows of readings (`conformance`); a target makes files of all that (`targets`); and these are written into the
folder, with a manifest (`export_folder`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from understudy.addons.export.body_interface import BodyInterface, RobotInterface, describe_body, describe_kit
from understudy.addons.export.conformance import MS_PER_S, make_conformance
from understudy.addons.export.export_folder import MANIFEST, check_export_folder, make_manifest, write_export
from understudy.addons.export.hierarchy import Hierarchy, flatten_program
from understudy.addons.export.single_precision import RoundedCut, round_library
from understudy.addons.export.target_files import ExportJob
from understudy.addons.export.targets.target_table import TARGETS, ExportTarget, find_target
from understudy.errors import DefinitionError, SettingError, join_names
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.library import Library, list_dependencies
from understudy.records.record import Record
from understudy.runtime.body import Body
from understudy.runtime.link import Program, link
from understudy.storage.document import fingerprint_automaton, hash_content


@dataclass(frozen=True, slots=True)
class ExportResult:
    """The files and facts of a finished export.

    Parameters
    ----------
    folder
        The folder of the export.
    target
        The target.
    files
        Number of bytes by file.
    ticks
        Number of rows of the conformance file.
    untranslated
        Functions that could not be translated: name, readings and reason of each.
    rounded
        Cuts that single precision decides otherwise.
    notes
        What one should know before it runs, as sentences without a full stop.
    """

    folder: Path
    target: str
    files: Mapping[str, int]
    ticks: int
    untranslated: tuple[tuple[str, tuple[str, ...], str], ...]
    rounded: tuple[RoundedCut, ...]
    notes: tuple[str, ...] = ()


def export_automaton(
    library: Library,
    name: str,
    folder: Path | str,
    *,
    to: str,
    binding: Mapping[str, str] = NOTHING_BOUND,
    body: Body | BodyInterface | RobotInterface | None = None,
    single_precision: bool = False,
    runs: Sequence[Record] = (),
) -> ExportResult:
    """Export an automaton with everything below it.

    Parameters
    ----------
    library
        The library of a type of robots, or of the coordinators of a kind of squads.
    name
        Name of the automaton.
    folder
        Folder to write. It must be empty or hold only an earlier export.
    to
        The target, one of `list_targets`, such as "c99" or "scxml".
    binding
        A target for each parameter of the automaton.
    body
        The body that it is for, which says the channels' values at rest and the length of a tick. None: channels are
        at rest at 0, and a tick is 0.1 s. Target ros2 needs a robot, as `describe_robot` describes it.
    single_precision
        Whether numbers are 32-bit floats and times milliseconds, for small microcontrollers.
    runs
        Recorded runs, as `read_records` reads them, whose readings the conformance file has, too: the exported code
        then is tried on what robots sensed.

    Returns
    -------
    ExportResult
        What was written, and what could not be translated.

    Raises
    ------
    UnknownName
        If the library has no such automaton or the target is unknown, or the body has not what it uses.
    UnboundParameter
        If a parameter is not bound.
    DefinitionError
        If it cannot be exported, such as a classifier of scikit-learn.
    SettingError
        If the target has no single precision, or cannot keep the length of the tick, or cannot run on the robot.
    FileError
        If the folder holds something else, or cannot be written.
    DefinitionError
        If the runs have none of the readings that the automaton uses.
    """
    target = find_target(to)
    check_export_folder(folder)
    robot = body if isinstance(body, RobotInterface) else None
    if isinstance(body, RobotInterface):
        body = body.body
    elif not isinstance(body, BodyInterface):
        body = describe_kit(library) if body is None else describe_body(body)
    fingerprints = fingerprint_automata(library, name)
    job = prepare_export(
        library,
        name,
        to=to,
        binding=binding,
        body=body,
        fingerprint=combine_fingerprints(fingerprints),
        single_precision=single_precision,
        robot=robot,
        runs=runs,
    )
    target_files = target.make_files(job)
    manifest = make_manifest(job, target_files, target=to, fingerprints=fingerprints)
    files = write_export(folder, {**target_files.files, MANIFEST: manifest}, target_files.by_hand)
    return ExportResult(
        Path(folder),
        to,
        {each: len(content) for each, content in sorted(files.items())},
        len(job.conformance.ticks),
        tuple((each.name, each.readings, each.problem) for each in job.hierarchy.functions_to_write),
        job.rounded,
        target_files.notes,
    )


def prepare_export(
    library: Library,
    name: str,
    *,
    to: str,
    binding: Mapping[str, str],
    body: BodyInterface,
    fingerprint: str,
    single_precision: bool = False,
    robot: RobotInterface | None = None,
    runs: Sequence[Record] = (),
) -> ExportJob:
    """Prepare what a target is written from: round the cuts if need be, link, flatten, and answer rows of readings."""
    rounded: tuple[RoundedCut, ...] = ()
    if single_precision:
        _check_single(to, find_target(to), body.tick_s)
        library, rounded = round_library(library, list_exported_automata(library, name))
    program, hierarchy = link_ground(library, name, binding, body)
    find_target(to).check_size(hierarchy)
    conformance = make_conformance(
        program,
        hierarchy,
        library,
        single_precision=single_precision,
        runs=_choose_runs(runs, hierarchy),
    )
    return ExportJob(hierarchy, conformance, library, fingerprint, single_precision, robot, rounded)


def _choose_runs(runs: Sequence[Record], hierarchy: Hierarchy) -> list[Record]:
    """Return the runs that have readings of an automaton; refuse runs of which none has."""
    used = {(each.reading, each.target) for each in hierarchy.readings}
    chosen = [run for run in runs if used & run.values.keys()]
    if runs and used and not chosen:
        readings = join_names(sorted(map(str, hierarchy.readings)))
        raise DefinitionError(
            what=f"run {runs[0].source}",
            problem=f"it has none of the readings of {hierarchy.name}: {readings}",
            remedy="give a run of a robot that has them",
        )
    return chosen


def list_exported_automata(library: Library, name: str) -> list[str]:
    """List the automata of a library that an automaton consists of, itself included, by name."""
    library.automaton(name)
    return sorted(list_dependencies(library, name))


def fingerprint_automata(library: Library, name: str) -> dict[str, str]:
    """Return the fingerprint of each automaton of a library that an automaton consists of."""
    used = list_exported_automata(library, name)
    return {each: fingerprint_automaton(library.taught[each]) for each in used}


def combine_fingerprints(fingerprints: Mapping[str, str]) -> str:
    """Combine the fingerprints of automata into the fingerprint of an export."""
    return hash_content("".join(f"{name}={mark};" for name, mark in sorted(fingerprints.items())).encode())


def link_ground(
    library: Library, name: str, binding: Mapping[str, str], interface: BodyInterface
) -> tuple[Program, Hierarchy]:
    """Link an automaton and make its intermediate form."""
    program = link(library, name, binding)
    return program, flatten_program(program, name=name, binding=Binding(binding), body=interface)


def _check_single(to: str, target: ExportTarget, tick_s: float) -> None:
    if not target.single_precision:
        offering = [each for each, other in TARGETS.items() if other.single_precision]
        remedy = f"leave it out, or export to {join_names(offering)}"
        raise SettingError(
            where=f"target {to}", setting="single precision", problem="is not offered", remedy=remedy
        )
    if abs(tick_s * MS_PER_S - round(tick_s * MS_PER_S)) > 1e-9 or tick_s * MS_PER_S < 1:
        raise SettingError(
            where="single precision",
            setting="tick",
            problem=f"of {tick_s:g} s is no whole number of milliseconds, which its clock counts",
            remedy="export with double precision, or choose a tick of whole milliseconds",
        )
