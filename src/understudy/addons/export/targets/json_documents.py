"""Target json: the documents of a library and the parts of the kit that they name, with a reader in JavaScript."""

from __future__ import annotations

from typing import Any

import msgspec

from understudy.addons.export.exported_trace import format_trace_header
from understudy.addons.export.expressions import Expression, Number, ReadingValue, translate_function
from understudy.addons.export.target_files import TEMPLATES, ExportJob, TargetFiles, fill_templates
from understudy.model.behaviors import Behavior
from understudy.model.features import Feature
from understudy.model.library import TrainedAutomaton
from understudy.storage.document import encode_document
from understudy.storage.json_text import format_json
from understudy.storage.library_folder import make_file_stem
from understudy.storage.library_schema import make_document_schema


def make_json_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export as documents."""
    hierarchy = job.hierarchy
    files = {
        f"library/{make_file_stem(name)}.json": encode_document(TrainedAutomaton(job.library.automaton(name)))
        for name in sorted({each.automaton for each in hierarchy.automata})
    }
    notes = "".join(
        f"\nThe reader refuses {each.name}, which could not be translated: {each.problem}.\n"
        for each in hierarchy.functions_to_write
    )
    files["parts.json"] = format_json(_describe_parts(job))
    files["library.schema.json"] = format_json(make_document_schema())
    files["reader.mjs"] = (TEMPLATES / "json" / "reader.mjs").read_bytes()
    files |= fill_templates("json", {"title": hierarchy.name, "notes": notes}, "Makefile", "README.md")
    return TargetFiles(files, makes=("trace.csv",))


def _describe_parts(job: ExportJob) -> dict[str, Any]:
    """Describe what the documents of an export refer to by name."""
    hierarchy, library = job.hierarchy, job.library
    automata = [
        library.automaton(name) for name in dict.fromkeys(each.automaton for each in hierarchy.automata)
    ]
    features = {bound.feature.name: bound.feature for each in automata for bound in each.features}
    behaviors = {state.behavior for each in automata for state in each.states}
    return {
        "format": "understudy parts",
        "version": 1,
        "root": hierarchy.name,
        "binding": dict(hierarchy.binding),
        "is_coordinator": hierarchy.is_coordinator,
        "trace_header": format_trace_header(job),
        "readings": [str(slot) for slot in hierarchy.readings],
        "channels": [
            {"channel": each.name, "rest": each.rest, "unit": each.unit} for each in hierarchy.channels
        ],
        "flags": list(hierarchy.flags),
        "basics": [basic.name for basic in hierarchy.basics],
        "automata": [each.name for each in hierarchy.automata],
        "features": {
            name: _describe_feature(feature)
            for name, feature in sorted(features.items())
            if isinstance(feature, Feature)
        },
        "behaviors": {
            name: _describe_behavior(behavior)
            for name, behavior in sorted(library.kit.behaviors.items())
            if name in behaviors
        },
    }


def _describe_feature(feature: Feature) -> dict[str, Any]:
    expression: Any = None
    if feature.function is not None:
        translated = translate_function(feature.function, feature.parameters)
        result = translated.results.get("")
        expression = [feature.name] if result is None else _spell(result)
    return {
        "reading": feature.reading,
        "of": feature.of,
        "unit": feature.unit,
        "fresh": feature.fresh,
        "expression": expression,
    }


def _describe_behavior(behavior: Behavior) -> dict[str, Any]:
    command: dict[str, Any] | None = dict(behavior.command)
    if behavior.function is not None:
        translated = translate_function(behavior.function, behavior.parameters)
        command = {channel: _spell(each) for channel, each in translated.results.items()} or None
    changes = [msgspec.to_builtins(each) for each in behavior.changes]
    return {"parameters": list(behavior.parameters), "command": command, "changes": changes}


def _spell(expression: Expression) -> Any:
    """Spell an expression as a number, or as a list of an operation and its operands."""
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, ReadingValue):
        return ["reading", expression.reading, expression.parameter]
    return [expression.name, *(_spell(each) for each in expression.operands)]
