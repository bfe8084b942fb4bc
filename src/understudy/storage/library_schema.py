"""The schema of documents, which msgspec checks before anything else uses a file (docs/reference/library-format.md).

A document has three parts: the automaton, the lesson from which it was learned, and the trees built from that
lesson.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeAlias

import msgspec
from msgspec import UNSET, Meta, Struct, UnsetType, field

from understudy.model.property import PropertyKind

FORMAT = 1
"""The number of the format that is written. Older formats are converted by `MIGRATIONS`, newer ones refused."""

MIGRATIONS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""For each older format, the function that converts a document to the next one."""

DocCount: TypeAlias = Annotated[int, Meta(ge=0, le=2**53)]
DocName: TypeAlias = Annotated[str, Meta(min_length=1)]
DocValue: TypeAlias = float | str | None
"""The value of a feature: a number, a label, or null if absent."""
ChildDoc: TypeAlias = Annotated[int, Meta(ge=1)] | Literal["stay"]


class DocStruct(Struct, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A part of a document, without unknown fields; fields that have their default are left out."""


class StateDoc(DocStruct, kw_only=True):
    """A state."""

    name: DocName
    behavior: str | None = None
    binding: dict[str, str] = {}
    flag: str | None = None


class PairedReadingDoc(DocStruct, tag_field="term", tag="reading", kw_only=True):
    """A reading of the body, or of the target of a parameter of the feature; `name` is that of the kit's feature."""

    reading: DocName
    of: str | None = None
    name: str = ""


class QuotientDoc(DocStruct, tag_field="term", tag="quotient", kw_only=True):
    """A quotient: absent where a side is, and where `right` is 0."""

    left: PairedReadingDoc | QuotientDoc | DifferenceDoc
    right: PairedReadingDoc | QuotientDoc | DifferenceDoc


class DifferenceDoc(DocStruct, tag_field="term", tag="difference", kw_only=True):
    """A difference: absent where a side is, and wrapped if it is one of angles."""

    left: PairedReadingDoc | QuotientDoc | DifferenceDoc
    right: PairedReadingDoc | QuotientDoc | DifferenceDoc


class FeatureDoc(DocStruct, kw_only=True):
    """A feature as the automaton uses it.

    `sort` is "body" or the sort of an automaton's own feature. `pair` says how it is computed, if no kit has it.
    """

    name: DocName
    binding: dict[str, str] = {}
    sort: Literal["body", "flag", "counter", "timer", "time in state"] = "body"
    kind: str
    unit: str = ""
    pair: QuotientDoc | DifferenceDoc | UnsetType = UNSET


class AutomatonDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The automaton without its transition functions."""

    name: DocName
    parameters: list[str]
    stateless: bool
    states: list[StateDoc]
    features: list[FeatureDoc]


class TreesDoc(DocStruct, tag_field="learns", tag="trees", omit_defaults=False, kw_only=True):
    """The settings for learning decision trees.

    `defaults` is left out if true, `pruning` if 0, and `order` if gain comes first.
    """

    boundary: Literal["default keeps the gap", "midpoint"]
    defaults: bool | UnsetType = UNSET
    pruning: float | UnsetType = UNSET
    order: Literal["flags first"] | UnsetType = UNSET


class ScikitDoc(DocStruct, tag_field="learns", tag="scikit-learn", omit_defaults=False, kw_only=True):
    """The settings for learning with a classifier of scikit-learn."""

    classifier: str
    parameters: dict[str, float | int | str | bool | None]


class OptionsDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The options for learning the lesson; `unlearning` and `live` are left out if false."""

    reaction_s: float
    watched: bool
    learner: TreesDoc | ScikitDoc
    unlearning: bool | UnsetType = UNSET
    live: bool | UnsetType = UNSET


class SourceDoc(DocStruct, kw_only=True):
    """The place in a recording that an example was made from."""

    file: str
    time_s: float
    driver: str = ""
    certainty: float = 1.0


class WatchedSourceDoc(DocStruct, kw_only=True):
    """The places in one recording that watched examples were made from; times and certainties are columns."""

    file: str
    time_s: list[float]
    driver: str = ""
    certainty: list[float] = []


class ExampleDoc(DocStruct, kw_only=True):
    """A press-made example; `own` holds the values of the automaton's own features, null if absent."""

    number: DocCount
    state: str
    next: str
    kind: Literal["directive", "default", "confirmation"]
    values: list[DocValue]
    correction: bool = False
    edited: bool = False
    moment: DocCount | None = None
    window: DocCount = 0
    own: dict[str, float | None] = {}
    binding: dict[str, str] = {}
    quarantined: str = ""
    reaction_s: Annotated[float, Meta(ge=0, le=1)] | UnsetType = UNSET
    source: SourceDoc | UnsetType = UNSET


class WatchedDoc(DocStruct, kw_only=True):
    """Watched examples with the same keys of `own`, the same `binding` and the same recording, stored as columns."""

    number: list[DocCount]
    state: list[str]
    next: list[str]
    values: list[list[DocValue]]
    correction: list[bool] = []
    edited: list[bool] = []
    moment: list[DocCount | None] = []
    window: list[DocCount] = []
    own: dict[str, list[float | None]] = {}
    binding: dict[str, str] = {}
    quarantined: list[str] = []
    source: WatchedSourceDoc | UnsetType = UNSET


class ReadingDoc(DocStruct, kw_only=True):
    """The packed column of one reading in the record."""

    reading: DocName
    of: str | None = None
    values: str


class RecordDoc(DocStruct, omit_defaults=False, kw_only=True):
    """All readings at the moments that the lesson keeps; columns are base64 of zlib of little-endian float64."""

    moments: DocCount
    seconds: str
    readings: list[ReadingDoc]


class OutcomeDoc(DocStruct, kw_only=True):
    """A property from a stored moment: a `flag` in time, or a `kind` with `what`. Packed parts are base64 of zlib."""

    flag: DocName | UnsetType = UNSET
    kind: PropertyKind | UnsetType = UNSET
    what: str | UnsetType = UNSET
    within_s: float | UnsetType = UNSET
    limit_s: float | UnsetType = UNSET
    world: str
    agent: DocCount = 0
    sort: str = ""
    targets: dict[str, str] = {}
    scenario: str
    snapshot: str


class GoalDoc(DocStruct, kw_only=True):
    """What success means in any world: a property, in the words of properties of a file; `name` says it shortly."""

    name: str = ""
    kind: PropertyKind
    what: str
    within_s: float | UnsetType = UNSET
    limit_s: Annotated[float, Meta(gt=0)] | UnsetType = UNSET
    world: str


class KitFeatureDoc(DocStruct, kw_only=True):
    """A feature that is a reading: of its own name unless `reading` says otherwise, and about the parameter `of`."""

    name: DocName
    reading: str = ""
    of: str | None = None
    kind: str
    unit: str = ""
    doc: str = ""


class KitDoc(DocStruct, omit_defaults=False, kw_only=True):
    """What a lesson of a recording needs: features, the command by channel of each behavior, and targets."""

    features: list[KitFeatureDoc]
    behaviors: dict[str, dict[str, float]]
    targets: list[DocName]


class LessonDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The lesson: options, examples and record; `outcomes`, its properties, `goal` and `kit` are left out if none."""

    options: OptionsDoc
    examples: list[ExampleDoc]
    watched: list[WatchedDoc]
    record: RecordDoc
    outcomes: list[OutcomeDoc] | UnsetType = UNSET
    goal: GoalDoc | UnsetType = UNSET
    kit: KitDoc | UnsetType = UNSET


class GoDoc(DocStruct, tag_field="node", tag="go", kw_only=True):
    """A leaf that switches to a state."""

    to: str


class StayDoc(DocStruct, tag_field="node", tag="stay", kw_only=True):
    """A leaf that keeps the current state."""


class BelowDoc(DocStruct, tag_field="node", tag="below", omit_defaults=False, kw_only=True):
    """A test whether a feature is less than `cut`."""

    feature: str
    cut: float
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class ArcDoc(DocStruct, tag_field="node", tag="arc", omit_defaults=False, kw_only=True):
    """A test whether a feature is on the arc `low` <= x < `high`, which crosses the seam if low > high."""

    feature: str
    low: float = field(name="from")
    high: float = field(name="to")
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class AbsentDoc(DocStruct, tag_field="node", tag="absent", kw_only=True):
    """A test whether a feature is absent."""

    feature: str
    yes: ChildDoc
    no: ChildDoc


class LabelDoc(DocStruct, tag_field="node", tag="label", omit_defaults=False, kw_only=True):
    """A test with one branch for each label of a feature."""

    feature: str
    branches: dict[str, ChildDoc]
    absent: ChildDoc


NodeDoc: TypeAlias = GoDoc | StayDoc | BelowDoc | ArcDoc | AbsentDoc | LabelDoc


class BuiltDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The trees by state, those of a stateless automaton under `*`; `hash` is None if written by hand."""

    hash: str | None
    trees: dict[str, list[NodeDoc]]


class Document(DocStruct, omit_defaults=False, kw_only=True):
    """One automaton; `lesson` is None if it was written by hand, `built` if it must be learned on loading."""

    format: int
    automaton: AutomatonDoc
    lesson: LessonDoc | None
    built: BuiltDoc | None


class FormatVersion(Struct):
    """The number of a document's format, which documents of every format have."""

    format: int


def make_document_schema() -> dict[str, Any]:
    """Make the JSON Schema (draft 2020-12) of the documents of a library."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Understudy library document",
    }
    return {**schema, **msgspec.json.schema(Document)}
