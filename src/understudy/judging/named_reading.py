"""Readings by name, as goals and metrics of evaluations name them: features of a kit or readings of a body."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from understudy.errors import SettingError, UnknownName
from understudy.model.features import BoundFeature, Feature, Percept, ReadingKey
from understudy.model.library import Library
from understudy.model.value_kinds import BOOLEAN, Column, Kind, clear_infinite
from understudy.runtime.body import Body, Reading, check_reading_keys
from understudy.runtime.feature_columns import FeatureColumns
from understudy.training.lesson_design import parse_feature

_CALL = re.compile(r"\s*([^\s(),]+)\s*(?:\(\s*([^\s(),]+)\s*\))?\s*")
YES = float(BOOLEAN.labels.index("yes"))


@dataclass(frozen=True, slots=True)
class NamedReading:
    """A feature or reading on one body; `keys` are the readings that the body must sense for it."""

    text: str
    kind: Kind
    keys: tuple[ReadingKey, ...]
    feature: FeatureColumns | None = None
    """How the feature is computed. None: it is a reading of the body."""
    unit: str = ""

    def read(self, percept: Percept) -> Column:
        """Return its values [N] in a snapshot; NaN where it is absent, or infinite."""
        if self.feature is None:
            return clear_infinite(np.asarray(percept[self.keys[0]], np.float64))
        column: Column = self.feature.columns(percept)[0]
        return column


def find_reading(
    text: str, library: Library, body: Body, *, binding: Mapping[str, str], where: str
) -> NamedReading:
    """Find a feature of the library's kit that the body senses, or else a reading of the body.

    Parameters
    ----------
    text
        Its name, with targets in parentheses where it needs them: "distance_to(station)". A parameter of the behavior,
        such as A, stands for the target that it is bound to.
    library
        The library, whose kit has the features.
    body
        The body.
    binding
        The target of each parameter of the behavior.
    where
        The words for the body in an error.

    Returns
    -------
    NamedReading
        What to sense, and how to read it.

    Raises
    ------
    UnknownName
        If neither the kit nor the body has it, or the body has no such target.
    SettingError
        If a target is missing or needless.
    """
    name = text.partition("(")[0].strip()
    features = {key: each for key, each in library.kit.features.items() if isinstance(each, Feature)}
    readings = {reading.name: reading for reading in body.readings}
    if name in features and _is_sensed(features[name], readings):
        bound = parse_feature(library, text)
        columns = FeatureColumns([BoundFeature(bound.feature, bound.binding.substitute(binding))], body)
        return NamedReading(text, bound.kind, columns.keys, columns, bound.feature.unit)
    if name not in readings:
        names = list(dict.fromkeys([*features, *readings]))
        raise UnknownName(what="feature or reading", name=name, where=where, known=names)
    call = _CALL.fullmatch(text)
    if call is None:
        remedy = "write its name, with a target in parentheses where it needs one: range(station)"
        raise SettingError(where=where, setting=f"reading {text!r}", problem="is not one", remedy=remedy)
    target = call[2] and binding.get(call[2], call[2])
    check_reading_keys([(name, target)], readings=body.readings, targets=body.targets, where=where)
    return NamedReading(text, readings[name].kind, ((name, target),), unit=readings[name].unit)


def _is_sensed(feature: Feature, readings: Mapping[str, Reading]) -> bool:
    """Return whether a body with these readings senses a feature: its reading, or all readings of its function."""
    if feature.reading is None:
        return True
    return feature.reading in readings and readings[feature.reading].kind == feature.kind


def check_yes_or_no(reading: NamedReading, *, where: str) -> None:
    """Refuse a goal that is a reading of another kind than yes or no, with SettingError."""
    if reading.kind != BOOLEAN:
        remedy = "name one that is yes or no, or give a function"
        raise SettingError(
            where=where, setting=f"goal {reading.text!r}", problem=f"is {reading.kind}", remedy=remedy
        )
