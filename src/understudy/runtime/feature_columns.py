"""Sensing: from a body's readings to the columns of ground features that a program decides on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnknownName
from understudy.model.features import (
    BoundFeature,
    Feature,
    Percept,
    ReadingKey,
    ReadingsView,
    call_user_function,
)
from understudy.model.reading_pairs import ReadingPair
from understudy.model.value_kinds import ABSENT, LARGEST, Categorical, Column, Toroidal, clear_infinite
from understudy.runtime.body import Body, Reading, list_reading_keys


class FeatureColumns:
    """The columns of ground body features for one body; `keys` are the readings that the body must sense for them.

    `agents` is the number of rows of its snapshots, if they are not one for each agent of the body.
    """

    def __init__(self, features: Sequence[BoundFeature], body: Body, *, agents: int | None = None) -> None:
        self.features = tuple(features)
        self.agents = body.agents if agents is None else agents
        readings = {reading.name: reading for reading in body.readings}
        keys: dict[ReadingKey, None] = {}
        for bound in self.features:
            feature = get_body_feature(bound)
            check_targets(body, bound.binding)
            if feature.pair is not None:
                keys.update(dict.fromkeys(_list_pair_keys(feature, feature.pair, bound, readings)))
                continue
            if feature.reading is None:  # which readings a function looks at, only running it can tell
                keys.update(
                    (key, None)
                    for key in list_reading_keys(body)
                    if key[1] in (None, *bound.binding.values())
                )
                continue
            refuse_unknown_reading(feature.reading, readings)
            if readings[feature.reading].kind != feature.kind:
                raise DefinitionError(
                    what=f"feature {feature.name!r}",
                    problem=f"it is {feature.kind}, but the body's reading {feature.reading!r} is "
                    f"{readings[feature.reading].kind}",
                    remedy="give the feature the reading's kind",
                )
            keys[get_feature_key(bound)] = None
        self.keys: tuple[ReadingKey, ...] = tuple(keys)
        kinds = [bound.kind for bound in self.features]
        ranges = [
            (0.0, len(kind.labels) - 1.0) if isinstance(kind, Categorical) else (-LARGEST, LARGEST)
            for kind in kinds
        ]
        self._least, self._most = np.array(ranges, np.float64).reshape(-1, 2).T[:, :, None]
        self._whole = np.array([isinstance(kind, Categorical) for kind in kinds], np.bool_)[:, None]

    def columns(self, percept: Percept) -> NDArray[np.float64]:
        """Return the values [F, N] of the features in one snapshot; KindError for a value outside its kind.

        What is infinite is absent (NaN).
        """
        values = np.empty((len(self.features), self.agents))
        for index, bound in enumerate(self.features):
            values[index] = _read_column(bound, percept, self.agents)
        if self._find_outside(values).any():
            values[np.isinf(values)] = ABSENT
            for index, agent in np.argwhere(self._find_outside(values))[:1].tolist():
                _refuse(get_body_feature(self.features[index]), values[index], agent)
        return values

    def _find_outside(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which values are infinite, or no label of a categorical feature."""
        outside: NDArray[np.bool_] = (
            (values < self._least) | (values > self._most) | (self._whole & (np.floor(values) < values))
        )
        return outside


def refuse_unknown_reading(reading: str, readings: Mapping[str, Reading]) -> None:
    """Refuse the name of a reading that a body does not have, with UnknownName."""
    if reading not in readings:
        raise UnknownName(what="reading", name=reading, where="the body", known=list(readings))


def _list_pair_keys(
    feature: Feature, pair: ReadingPair, bound: BoundFeature, readings: Mapping[str, Reading]
) -> Iterator[ReadingKey]:
    """Yield the readings of a pair with a ground binding; refuse those that the body lacks, or has as another kind."""
    for each in pair.readings:
        refuse_unknown_reading(each.reading, readings)
        if readings[each.reading].kind != feature.kind:
            raise DefinitionError(
                what=f"feature {feature.name!r}",
                problem=f"it is {feature.kind}, but the body's reading {each.reading!r} is "
                f"{readings[each.reading].kind}",
                remedy="divide or subtract readings of its kind",
            )
        yield each.reading, bound.binding[each.of] if each.of else None


def check_targets(body: Body, binding: Mapping[str, str]) -> None:
    """Refuse a ground binding to a target that the body does not have, with UnknownName."""
    for target in binding.values():
        if target not in body.targets:
            raise UnknownName(what="target", name=target, where="the body", known=list(body.targets))


def get_body_feature(bound: BoundFeature) -> Feature:
    """Get the body feature of a bound feature; DefinitionError for a feature of the automaton itself."""
    if not isinstance(bound.feature, Feature):
        raise DefinitionError(
            what=f"feature {bound}", problem="it belongs to an automaton", remedy="a body cannot sense it"
        )
    return bound.feature


def get_feature_key(bound: BoundFeature) -> ReadingKey:
    """Get the reading, with its target, that a data feature with a ground binding reads."""
    feature = get_body_feature(bound)
    return feature.reading or "", bound.binding[feature.of] if feature.of else None


def read_feature_column(bound: BoundFeature, percept: Percept, *, agents: int) -> Column:
    """Read the values [N] of one feature, with its targets, from a snapshot; check those of a Python function.

    What is infinite is absent (NaN).
    """
    return clear_infinite(_read_column(bound, percept, agents))


def _read_column(bound: BoundFeature, percept: Percept, agents: int) -> Column:
    """Read the values of a feature, of which those that the body gave can be infinite."""
    feature = get_body_feature(bound)
    if feature.function is None:
        reading: object = percept[get_feature_key(bound)]
        if isinstance(reading, np.ndarray) and reading.dtype == np.float64 and reading.shape == (agents,):
            return reading  # as nearly all bodies give it, at every tick
        return _check_column(reading, feature, f"the body's reading {feature.reading!r} has", agents)
    targets = [ReadingsView(percept, bound.binding[parameter]) for parameter in feature.parameters]
    returned = call_user_function(
        f"feature {feature.name!r}", feature.function, [ReadingsView(percept), *targets]
    )
    column = clear_infinite(_check_column(returned, feature, "it returned", agents))
    if isinstance(feature.kind, Categorical):
        for agent in np.flatnonzero(_no_label(column, len(feature.kind.labels)))[:1].tolist():
            _refuse(feature, column, agent)
    return feature.kind.wrap(column) if isinstance(feature.kind, Toroidal) else column


def _check_column(values: object, feature: Feature, gave: str, agents: int) -> Column:
    what = f"feature {feature.name!r}"
    column = check_float_column(values, what=what, remedy="return one number per agent")
    if column.shape != (agents,):
        raise DefinitionError(
            what=what,
            problem=f"{gave} shape {column.shape}",
            remedy=f"return one value per agent: shape ({agents},)",
        )
    return column


def _no_label(column: Column, labels: int) -> NDArray[np.bool_]:
    """Return which values are neither absent nor the index of a label."""
    present = column == column
    outside: NDArray[np.bool_] = present & ((column < 0) | (column >= labels) | (column != np.floor(column)))
    return outside


def _refuse(feature: Feature, column: Column, agent: int) -> None:
    feature.kind.check(float(column[agent]), where=f"feature {feature.name!r} of agent {agent}")


def check_float_column(values: object, *, what: str, remedy: str) -> Column:
    """Convert the result of a function to a column of floats; DefinitionError if that is not possible."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DefinitionError(what=what, problem=f"it returned {values!r:.60}", remedy=remedy) from error
