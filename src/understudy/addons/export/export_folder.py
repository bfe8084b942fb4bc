"""The folder of an export, which holds a whole export at every moment, and nothing else: its manifest and its files.

The manifest says what an export reads, commands and contains, for people and for programs.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from understudy.addons.export.hierarchy import GroundAutomaton, GroundBasic, Hierarchy
from understudy.addons.export.target_files import ExportJob, FileByHand, TargetFiles, fingerprint_file
from understudy.errors import FileError
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.storage.atomic_write import UNFINISHED, check_folder_place, convert_os_errors, sync_folder
from understudy.storage.json_text import format_json

MANIFEST = "manifest.json"
FORMAT = "understudy export"
VERSION = 1
WRITING = "writing the export"
FORMER = f".former{UNFINISHED}"
"""The ending of the name that an earlier export has while a new one takes its place."""


def make_manifest(
    job: ExportJob, target_files: TargetFiles, *, target: str, fingerprints: Mapping[str, str]
) -> bytes:
    """Make the manifest of an export."""
    hierarchy, conformance = job.hierarchy, job.conformance
    names = target_files.names
    copies = [path for file in target_files.by_hand.values() for path in file.copies]
    content = {
        "format": FORMAT,
        "version": VERSION,
        "target": target,
        "automaton": hierarchy.name,
        "binding": dict(hierarchy.binding),
        "is_coordinator": hierarchy.is_coordinator,
        "fingerprint": job.fingerprint,
        "fingerprints": dict(fingerprints),
        "precision": "single" if job.single_precision else "double",
        "tick_s": hierarchy.tick_s,
        "time": "ms" if job.single_precision else "s",
        "readings": [
            {
                "name": slot.reading,
                "target": slot.target,
                "identifier": names.get("readings", {}).get(str(slot)),
                **_describe_kind(slot.kind),
                "unit": slot.unit,
                "doc": slot.doc,
            }
            for slot in hierarchy.readings
        ],
        "commands": [
            {
                "channel": channel.name,
                "identifier": names.get("channels", {}).get(channel.name),
                "rest": channel.rest,
                "unit": channel.unit,
                "doc": channel.doc,
            }
            for channel in hierarchy.channels
        ],
        "flags": list(hierarchy.flags),
        "basics": [_describe_basic(each, names) for each in hierarchy.basics],
        "automata": [_describe_automaton(each, hierarchy, names) for each in hierarchy.automata],
        "root": hierarchy.root.index,
        "untranslated": [
            {"name": each.name, "readings": each.readings, "problem": each.problem}
            for each in hierarchy.functions_to_write
        ],
        "rounded_cuts": job.rounded,
        "conformance": {
            "ticks": len(conformance.ticks),
            "from_lessons": conformance.recorded - conformance.from_runs,
            **({"from_runs": conformance.from_runs} if conformance.from_runs else {}),
            "leaves": {"reached": conformance.leaves[0], "of": conformance.leaves[1]},
            "boundaries": {"reached": conformance.boundaries[0], "of": conformance.boundaries[1]},
        },
        **target_files.facts,
        "files": sorted((*target_files.files, *target_files.by_hand, *copies)),
        "by_hand": {
            name: fingerprint_file(file.write()) for name, file in sorted(target_files.by_hand.items())
        },
        "makes": sorted(target_files.makes),
    }
    return format_json(content)


def _describe_kind(kind: object) -> dict[str, Any]:
    if isinstance(kind, Categorical):
        return {"kind": "categorical", "labels": list(kind.labels)}
    if isinstance(kind, Toroidal):
        return {"kind": "toroidal", "period": kind.period}
    return {"kind": "continuous"}


def _describe_basic(basic: GroundBasic, names: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": basic.name,
        "behavior": basic.behavior,
        "binding": dict(basic.binding),
        "identifier": names.get("basics", {}).get(basic.name),
        "command": dict(basic.command),
        "computes": sorted(basic.computed),
        "changes": basic.changes,
    }
    if basic.order is not None:
        described["order"] = [
            {
                "behavior": duty.behavior,
                "binding": dict(duty.binding),
                "role": duty.role,
                "share": None if duty.share is None else str(duty.share),
            }
            for duty in basic.order.duties
        ]
    return described


def _describe_automaton(
    automaton: GroundAutomaton, hierarchy: Hierarchy, names: Mapping[str, Mapping[str, str]]
) -> dict[str, Any]:
    def runs(index: int) -> str:
        child = automaton.states[index].child
        return (hierarchy.automata if child.is_automaton else hierarchy.basics)[child.index].name

    return {
        "name": automaton.name,
        "automaton": automaton.automaton,
        "binding": dict(automaton.binding),
        "identifier": names.get("automata", {}).get(automaton.name),
        "states": [
            {
                "name": state.name,
                "identifier": names.get("states", {}).get(f"{automaton.name}/{state.name}"),
                "runs": runs(index),
                "flag": None if state.flag is None else hierarchy.flags[state.flag],
            }
            for index, state in enumerate(automaton.states)
        ],
        "features": [each.name for each in automaton.features],
        "counters": list(automaton.counters),
        "timers": list(automaton.timers),
    }


def write_export(
    folder: Path | str, files: Mapping[str, bytes], by_hand: Mapping[str, FileByHand] | None = None
) -> Mapping[str, bytes]:
    """Write the files of an export to a folder that is empty, does not exist, or holds only an earlier export.

    Anything else is refused with FileError, and nothing is changed. The files are written to a folder beside it,
    which then takes its place. Of files of functions to write, the earlier export's are kept, with what a person has
    written there. The files as they were written are returned.
    """
    folder = Path(folder)
    check_export_folder(folder)
    with convert_os_errors(folder, WRITING):
        files = {**files, **_keep_files_by_hand(folder, by_hand or {})}
        folder.parent.mkdir(parents=True, exist_ok=True)
        place = folder.resolve()
        unfinished = place.with_name(f".{place.name}.{os.getpid()}{UNFINISHED}")
        former = place.with_name(f".{place.name}.{os.getpid()}{FORMER}")
        try:
            for name, content in files.items():
                path = unfinished / name
                path.parent.mkdir(parents=True, exist_ok=True)
                with path.open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
            if place.exists():
                place.rename(former)
            unfinished.rename(place)
            sync_folder(place.parent)
        finally:
            if former.exists() and not place.exists():
                former.rename(place)
            for left in (unfinished, former):
                shutil.rmtree(left, ignore_errors=True)
    return files


def _keep_files_by_hand(folder: Path, by_hand: Mapping[str, FileByHand]) -> dict[str, bytes]:
    """Make the files of functions to write: those of the earlier export, with stubs for what they lack."""
    earlier = _read_manifest(folder).get("by_hand", {})
    for name, fingerprint in earlier.items():
        path = folder / name
        if name not in by_hand and path.exists() and fingerprint_file(path.read_bytes()) != fingerprint:
            raise FileError(
                path=folder,
                place="",
                problem=f"{name} has functions that you wrote, and this export has no such file",
                remedy="name a new folder, or move the file",
            )
    files: dict[str, bytes] = {}
    for name, file in by_hand.items():
        content, path = file.write(), folder / name
        if name in earlier and path.exists():
            there = path.read_bytes()
            if fingerprint_file(there) != earlier[name]:
                text = there.decode("utf-8", "replace")
                missing = [
                    stub for called, stub in file.stubs.items() if not re.search(rf"\b{called}\b", text)
                ]
                content = "\n".join((text, *missing)).encode() if missing else there
        files |= dict.fromkeys((name, *file.copies), content)
    return files


def check_export_folder(folder: Path | str) -> None:
    """Refuse a folder that holds something else than an export, or that cannot be written, with FileError.

    If an earlier replacement of the folder was killed halfway, the earlier export is first put back.
    """
    folder = Path(folder)
    _refuse_other_files(folder)
    check_folder_place(folder, WRITING)


def _refuse_other_files(folder: Path) -> None:
    with convert_os_errors(folder, "reading the folder of the export"):
        _recover(folder.resolve())
        if not folder.exists():
            return
        if not folder.is_dir():
            raise FileError(path=folder, place="", problem="it is not a folder", remedy="name a new folder")
        if Path.cwd().is_relative_to(folder.resolve()):
            problem, remedy = "it is the working folder, which cannot be replaced", "name a folder inside it"
            raise FileError(path=folder, place="", problem=problem, remedy=remedy)
        there = {
            path.relative_to(folder).as_posix()
            for path in folder.rglob("*")
            if path.is_symlink() or not path.is_dir()
        }
    if not there:
        return
    names = _list_files(folder)
    folders = tuple(each for each in names if each.endswith("/"))
    others = sorted(each for each in there - names if not each.startswith(folders))
    if others:
        raise FileError(
            path=folder,
            place="",
            problem=f"{others[0]} is there, which is not of an export",
            remedy="name a new folder, or move what you want to keep",
        )


def _recover(place: Path) -> None:
    """Put back the earlier export if an export was killed while it took its place, and remove what else was left."""
    if not place.parent.is_dir():
        return
    pattern = re.compile(rf"\.{re.escape(place.name)}\.(\d+)(\.former)?{re.escape(UNFINISHED)}")
    for left in sorted(place.parent.glob(f".*{UNFINISHED}")):
        match = pattern.fullmatch(left.name)
        if match is None:
            continue
        if match[2] and not place.exists():
            left.rename(place)
        elif not _is_running(int(match[1])):
            shutil.rmtree(left, ignore_errors=True)


def _is_running(process: int) -> bool:
    if os.name != "posix":  # pragma: no cover - there, signal 0 would end the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return process != os.getpid()


def _list_files(folder: Path) -> set[str]:
    """List the files of the export in a folder by its manifest, and what its Makefile makes of them."""
    manifest = _read_manifest(folder)
    return {MANIFEST, *map(str, manifest["files"]), *map(str, manifest["makes"])} if manifest else set()


def _read_manifest(folder: Path) -> dict[str, Any]:
    """Read the manifest of the export in a folder; nothing if there is none."""
    try:
        manifest = json.loads((folder / MANIFEST).read_bytes())
        if manifest["format"] != FORMAT:
            return {}
        by_hand = dict(manifest.get("by_hand", {}))
        return {
            "files": list(manifest["files"]),
            "makes": list(manifest.get("makes", ())),
            "by_hand": by_hand,
        }
    except (OSError, ValueError, LookupError, TypeError):
        return {}
