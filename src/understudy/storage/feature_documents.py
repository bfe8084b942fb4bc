"""Features in documents: encoding and decoding of what an automaton says of each of its features."""

from __future__ import annotations

from typing import Literal

from msgspec import UNSET, UnsetType

from understudy.errors import OtherKit, join_names
from understudy.model.binding import Binding
from understudy.model.features import (
    AnyFeature,
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    OwnFeature,
    TimeInState,
    TimerFeature,
    make_pair_feature,
)
from understudy.model.library import Kit
from understudy.model.reading_pairs import (
    DEEPEST,
    PairedReading,
    PairOperation,
    PairSide,
    ReadingPair,
    find_pair_kind,
)
from understudy.model.value_kinds import Kind, parse_kind
from understudy.storage.json_text import JsonSteps, Source
from understudy.storage.library_schema import DifferenceDoc, FeatureDoc, PairedReadingDoc, QuotientDoc

OWN: dict[str, type[OwnFeature]] = {
    "flag": FlagFeature,
    "counter": CounterFeature,
    "timer": TimerFeature,
    "time in state": TimeInState,
}


def encode_feature(bound: BoundFeature) -> FeatureDoc:
    """Encode a feature as an automaton uses it."""
    sort: Literal["body", "flag", "counter", "timer", "time in state"]
    pair = bound.feature.pair if isinstance(bound.feature, Feature) else None
    match bound.feature:
        case Feature():
            sort = "body"
        case FlagFeature():
            sort = "flag"
        case CounterFeature():
            sort = "counter"
        case TimerFeature():
            sort = "timer"
        case _:
            sort = "time in state"
    return FeatureDoc(
        name=bound.feature.name,
        binding=dict(bound.binding),
        sort=sort,
        kind=str(bound.kind),
        unit=bound.feature.unit,
        pair=UNSET if pair is None else _pair_doc(pair),
    )


def _pair_doc(pair: ReadingPair) -> QuotientDoc | DifferenceDoc:
    doc = QuotientDoc if pair.operation is PairOperation.QUOTIENT else DifferenceDoc
    return doc(left=_side_doc(pair.left), right=_side_doc(pair.right))


def _side_doc(side: PairSide) -> PairedReadingDoc | QuotientDoc | DifferenceDoc:
    if isinstance(side, ReadingPair):
        return _pair_doc(side)
    return PairedReadingDoc(reading=side.reading, of=side.of, name=side.name)


def decode_feature(doc: FeatureDoc, kit: Kit | None, source: Source, here: JsonSteps) -> BoundFeature:
    """Decode a feature: one of the kit, a pair of readings, or one of the automaton itself.

    Without a kit, it is made from what the document says.
    """
    with source.convert_errors(
        (*here, "kind"), remedy="restore an earlier version if you did not mean to edit it"
    ):
        kind = parse_kind(doc.kind, where=f"feature {doc.name!r}")
    if not isinstance(doc.pair, UnsetType):
        feature = _paired(doc, doc.pair, kind, source, here)
    else:
        feature = _declared(doc, kind) if kit is None else _known(doc, kind, kit, source, here)
    if set(doc.binding) != set(feature.parameters):
        bound = f"it binds {join_names(doc.binding)}" if doc.binding else "it binds nothing"
        what = (
            f"exactly its parameters ({join_names(feature.parameters)})" if feature.parameters else "nothing"
        )
        raise source.make_error((*here, "binding"), f"{bound}, for feature {doc.name!r}", f"bind {what}")
    return BoundFeature(feature, Binding(doc.binding))


def _declared(doc: FeatureDoc, kind: Kind) -> AnyFeature:
    if doc.sort == "body":
        return Feature(doc.name, kind, reading=doc.name, unit=doc.unit, parameters=tuple(doc.binding))
    return OWN[doc.sort](doc.name, kind, doc.unit)


def _paired(
    doc: FeatureDoc, pair_doc: QuotientDoc | DifferenceDoc, kind: Kind, source: Source, here: JsonSteps
) -> AnyFeature:
    """Make the feature of a pair of readings, which no kit needs to have."""
    pair = _pair(pair_doc, source, (*here, "pair"))
    if find_pair_kind(pair.operation, kind, kind) is None or doc.sort != "body":
        problem = (
            f"feature {doc.name!r} is a {pair.operation}, but it is stored as {kind}, of sort {doc.sort!r}"
        )
        raise source.make_error((*here, "kind"), problem, "restore an earlier version, or teach it again")
    if doc.name != str(pair):
        problem = f"feature {doc.name!r} is computed as {pair}"
        raise source.make_error((*here, "name"), problem, f"give it this name: {pair}")
    return make_pair_feature(pair, kind, doc.unit)


def _pair(
    doc: QuotientDoc | DifferenceDoc, source: Source, here: JsonSteps, *, depth: int = 1
) -> ReadingPair:
    if depth > DEEPEST:
        problem = f"more than {DEEPEST} pairs are within each other"
        raise source.make_error(here, problem, "restore an earlier version, or teach it again")
    operation = PairOperation.QUOTIENT if isinstance(doc, QuotientDoc) else PairOperation.DIFFERENCE
    left, right = (
        PairedReading(each.reading, each.of, each.name)
        if isinstance(each, PairedReadingDoc)
        else _pair(each, source, (*here, side), depth=depth + 1)
        for side, each in (("left", doc.left), ("right", doc.right))
    )
    return ReadingPair(operation, left, right)


def _known(doc: FeatureDoc, kind: Kind, kit: Kit, source: Source, here: JsonSteps) -> AnyFeature:
    of_kit = kit.features.get(doc.name)
    if doc.sort != "body" and (of_kit is None or _own_sort(of_kit) == doc.sort):
        return OWN[doc.sort](doc.name, kind, doc.unit)
    if of_kit is None:
        has = join_names(name for name, feature in kit.features.items() if isinstance(feature, Feature))
        problem = f"the kit has no feature {doc.name!r}; its features are {has}"
        raise source.make_error(
            (*here, "name"),
            problem,
            "open it with the kit it was taught with, or correct the name",
            OtherKit,
        )
    if _own_sort(of_kit) != doc.sort:
        problem = f"feature {doc.name!r} is stored as one of sort {doc.sort!r}, but in the kit its sort is "
        remedy = "open it with the kit it was taught with, or rename the feature in the kit"
        raise source.make_error((*here, "sort"), f"{problem}{_own_sort(of_kit)!r}", remedy, OtherKit)
    for what, stored, now in (("kind", str(kind), str(of_kit.kind)), ("unit", doc.unit, of_kit.unit)):
        if stored and stored != now:  # a table of examples tells no unit: that of the kit
            problem = (
                f"feature {doc.name!r} was taught with {what} {stored!r}, but the kit has it with {now!r}"
            )
            remedy = "open it with the kit it was taught with, or teach it again with this one"
            raise source.make_error((*here, what), problem, remedy, OtherKit)
    return of_kit


def _own_sort(feature: AnyFeature) -> str:
    return next((sort for sort, own in OWN.items() if isinstance(feature, own)), "body")
