"""Manifests: what an export reads, commands and contains, for people and for programs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from understudy.export.hierarchy import GroundAutomaton, GroundBasic, Hierarchy
from understudy.export.target_files import ExportJob, TargetFiles, fingerprint_file, format_json
from understudy.model.kinds import Categorical, Toroidal

MANIFEST = "manifest.json"
FORMAT = "understudy export"
VERSION = 1


def make_manifest(
    job: ExportJob, made: TargetFiles, *, target: str, fingerprints: Mapping[str, str]
) -> bytes:
    """Make the manifest of an export."""
    hierarchy, conformance = job.hierarchy, job.conformance
    names = made.names
    copies = [path for file in made.by_hand.values() for path in file.copies]
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
            "from_lessons": conformance.recorded,
            "leaves": {"reached": conformance.leaves[0], "of": conformance.leaves[1]},
            "boundaries": {"reached": conformance.boundaries[0], "of": conformance.boundaries[1]},
        },
        **made.facts,
        "files": sorted((*made.files, *made.by_hand, *copies)),
        "by_hand": {name: fingerprint_file(file.write()) for name, file in sorted(made.by_hand.items())},
        "makes": sorted(made.makes),
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
