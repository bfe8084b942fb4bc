"""The interface between an exported behavior and its body: readings, channels and the tick length."""

from __future__ import annotations

from dataclasses import dataclass

from understudy.model.features import Feature
from understudy.model.library import Library
from understudy.runtime.body import ISSUED, ORDER, Body, Channel, Reading

TICK_S = 0.1
"""The length of a tick, s, where no body says it."""


@dataclass(frozen=True, slots=True)
class BodyInterface:
    """The readings that a body offers, its channels with their values at rest, and the length of its tick, s.

    If `is_complete` is False, the body may have readings that are not listed.
    """

    readings: tuple[Reading, ...]
    channels: tuple[Channel, ...]
    tick_s: float = TICK_S
    is_complete: bool = True


ORDER_CHANNELS = (
    Channel(ORDER, doc="Which order stands: the index of a basic behavior; 0 orders the members to idle."),
    Channel(ISSUED, doc="1 in the tick in which the order is given, otherwise 0."),
)
"""The channels of an exported coordinator."""


def describe_body(body: Body) -> BodyInterface:
    """Describe a body to export for."""
    return BodyInterface(tuple(body.readings), tuple(body.channels), body.tick_s)


def describe_kit(library: Library, *, tick_s: float = TICK_S) -> BodyInterface:
    """Describe the body that a library's kit is for, if no body is at hand.

    Its readings are those of the kit's features. Its channels are those of the kit's commands, at rest 0; those of a
    squad's coordinator are `ORDER_CHANNELS`.
    """
    readings: dict[str, Reading] = {}
    for feature in library.kit.features.values():
        if isinstance(feature, Feature) and feature.reading is not None:
            of_targets = feature.of is not None
            readings[feature.reading] = Reading(
                feature.reading, feature.kind, feature.unit, of_targets, feature.doc
            )
    behaviors = library.kit.behaviors.values()
    if any(each.order is not None for each in behaviors):
        return BodyInterface(tuple(readings.values()), ORDER_CHANNELS, tick_s)
    channels = {channel: None for each in behaviors for channel in each.command}
    return BodyInterface(tuple(readings.values()), tuple(map(Channel, channels)), tick_s, is_complete=False)
