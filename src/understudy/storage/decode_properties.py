"""Decoding of the properties of lessons: those from stored moments, and what success means."""

from __future__ import annotations

from msgspec import UnsetType

from understudy.errors import DefinitionError
from understudy.model.binding import Binding
from understudy.model.property import RAISED, Property, PropertyKind, SeededWorlds, StoredMoment
from understudy.storage.json_text import JsonSteps, Source
from understudy.storage.library_schema import GoalDoc, LessonDoc, OutcomeDoc
from understudy.storage.packing import unpack_bytes

MOST_BYTES = 1 << 27
"""The largest size in bytes of a part of a property, so that a damaged file cannot fill the memory."""


def decode_properties(doc: LessonDoc, source: Source, here: JsonSteps) -> tuple[Property, ...]:
    """Decode the properties of a lesson that start at stored moments; FileError names the place of what is invalid."""
    properties = []
    for index, each in enumerate([] if isinstance(doc.outcomes, UnsetType) else doc.outcomes):
        parts = []
        for key in ("scenario", "snapshot"):
            try:
                parts.append(unpack_bytes(getattr(each, key), most=MOST_BYTES))
            except ValueError as error:
                remedy = "restore an earlier version, or the line as it was"
                raise source.make_error(
                    (*here, index, key), f"it cannot be unpacked: {error}", remedy
                ) from error
        with source.convert_errors((*here, index)):
            scenario, snapshot = parts[0].decode("utf-8", errors="replace"), parts[1]
            limit_s = None if isinstance(each.limit_s, UnsetType) else each.limit_s
            start = StoredMoment(each.world, scenario, snapshot, each.agent, each.sort, limit_s)
            properties.append(_make_property(each, start, Binding(each.targets)))
    return tuple(properties)


def _make_property(doc: OutcomeDoc, start: StoredMoment, targets: Binding) -> Property:
    seconds = None if isinstance(doc.within_s, UnsetType) else doc.within_s
    if not isinstance(doc.flag, UnsetType):
        kind, what = PropertyKind.ALWAYS, f"{doc.flag}{RAISED}"
    elif isinstance(doc.kind, UnsetType) or isinstance(doc.what, UnsetType):
        raise DefinitionError(
            what="a property",
            problem="it has neither a flag nor a kind",
            remedy="give it a flag, or kind and what",
        )
    else:
        kind, what = doc.kind, doc.what
    return Property(kind=kind, what=what, seconds=seconds, start=start, targets=targets)


def make_goal(doc: GoalDoc) -> Property:
    """Make the property that says what success means in any world."""
    seconds, limit_s = (None if isinstance(each, UnsetType) else each for each in (doc.within_s, doc.limit_s))
    start = SeededWorlds(doc.world, (), limit_s)
    return Property(kind=doc.kind, what=doc.what, seconds=seconds, start=start, name=doc.name)
