"""The shape of a document: what msgspec checks before anything else looks at a file (docs/formats.md).

A document has three parts: the automaton, the lesson it was taught in, and the trees built from that lesson.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeAlias

from msgspec import UNSET, Meta, Struct, UnsetType, field

FORMAT = 1
"""The format that is written. Older ones are brought up to it by `MIGRATIONS`, newer ones refused."""

MIGRATIONS: dict[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""Per older format, the function that brings a document to the next one."""

DocCount: TypeAlias = Annotated[int, Meta(ge=0, le=2**53)]
DocName: TypeAlias = Annotated[str, Meta(min_length=1)]
DocValue: TypeAlias = float | str | None
"""A feature's value: a number, a label, or null where absent."""
ChildDoc: TypeAlias = Annotated[int, Meta(ge=1)] | Literal["stay"]


class DocStruct(Struct, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A part of a document: unknown fields are refused, fields at their default are left out."""


class StateDoc(DocStruct, kw_only=True):
    """A state."""

    name: DocName
    behavior: str | None = None
    binding: dict[str, str] = {}
    flag: str | None = None


class FeatureDoc(DocStruct, kw_only=True):
    """A feature as the automaton uses it. `sort`: of the body, or which of the automaton's own."""

    name: DocName
    binding: dict[str, str] = {}
    sort: Literal["body", "flag", "counter", "timer", "time in state"] = "body"
    kind: str
    unit: str = ""


class AutomatonDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The automaton without its transition functions."""

    name: DocName
    parameters: list[str]
    stateless: bool
    states: list[StateDoc]
    features: list[FeatureDoc]


class TreesDoc(DocStruct, tag_field="learns", tag="trees", omit_defaults=False, kw_only=True):
    """Decision trees. `defaults` is left out where they teach, `pruning` where there is none."""

    boundary: Literal["default keeps the gap", "midpoint"]
    defaults: bool | UnsetType = UNSET
    pruning: float | UnsetType = UNSET


class ScikitDoc(DocStruct, tag_field="learns", tag="scikit-learn", omit_defaults=False, kw_only=True):
    """A classifier of scikit-learn."""

    classifier: str
    parameters: dict[str, float | int | str | bool | None]


class OptionsDoc(DocStruct, omit_defaults=False, kw_only=True):
    """How the lesson is learned. `unlearning` is there where corrections quarantine bad examples."""

    reaction_s: float
    watched: bool
    learner: TreesDoc | ScikitDoc
    unlearning: bool | UnsetType = UNSET


class ExampleDoc(DocStruct, kw_only=True):
    """A press-made example. `own`: the automaton's own readings then, null where absent."""

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


class WatchedDoc(DocStruct, kw_only=True):
    """Watched examples whose `own` has the same keys and whose `binding` is the same: a column each."""

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


class ReadingDoc(DocStruct, kw_only=True):
    """The column of one reading in the record, packed."""

    reading: DocName
    of: str | None = None
    values: str


class RecordDoc(DocStruct, omit_defaults=False, kw_only=True):
    """All readings at the moments the lesson keeps; columns are base64 of zlib of little-endian float64."""

    moments: DocCount
    seconds: str
    readings: list[ReadingDoc]


class OutcomeDoc(DocStruct, kw_only=True):
    """What the lesson promises; `scenario` and `snapshot` are base64 of zlib."""

    flag: DocName
    within_s: float
    world: str
    agent: DocCount = 0
    sort: str = ""
    targets: dict[str, str] = {}
    scenario: str
    snapshot: str


class LessonDoc(DocStruct, omit_defaults=False, kw_only=True):
    """What was shown, and how it is learned. `outcomes` is left out where nothing is promised."""

    options: OptionsDoc
    examples: list[ExampleDoc]
    watched: list[WatchedDoc]
    record: RecordDoc
    outcomes: list[OutcomeDoc] | UnsetType = UNSET


class GoDoc(DocStruct, tag_field="node", tag="go", kw_only=True):
    """A leaf that goes to a state."""

    to: str


class StayDoc(DocStruct, tag_field="node", tag="stay", kw_only=True):
    """A leaf that keeps the current state."""


class BelowDoc(DocStruct, tag_field="node", tag="below", omit_defaults=False, kw_only=True):
    """Is the feature below the cut?"""

    feature: str
    cut: float
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class ArcDoc(DocStruct, tag_field="node", tag="arc", omit_defaults=False, kw_only=True):
    """Is the feature on the arc `low` <= x < `high`, across the seam where low > high?"""

    feature: str
    low: float = field(name="from")
    high: float = field(name="to")
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class AbsentDoc(DocStruct, tag_field="node", tag="absent", kw_only=True):
    """Is the feature absent?"""

    feature: str
    yes: ChildDoc
    no: ChildDoc


class LabelDoc(DocStruct, tag_field="node", tag="label", omit_defaults=False, kw_only=True):
    """Which label is it?"""

    feature: str
    branches: dict[str, ChildDoc]
    absent: ChildDoc


NodeDoc: TypeAlias = GoDoc | StayDoc | BelowDoc | ArcDoc | AbsentDoc | LabelDoc


class BuiltDoc(DocStruct, omit_defaults=False, kw_only=True):
    """The trees by state, a stateless automaton's under `*`; `hash` is None for those written by hand."""

    hash: str | None
    trees: dict[str, list[NodeDoc]]


class Document(DocStruct, omit_defaults=False, kw_only=True):
    """One automaton: `lesson` is None if written by hand, `built` where it must be fitted on loading."""

    format: int
    automaton: AutomatonDoc
    lesson: LessonDoc | None
    built: BuiltDoc | None


class FormatVersion(Struct):
    """What every format has had: its number."""

    format: int
