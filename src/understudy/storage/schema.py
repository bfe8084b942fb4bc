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

Count: TypeAlias = Annotated[int, Meta(ge=0, le=2**53)]
Name: TypeAlias = Annotated[str, Meta(min_length=1)]
Value: TypeAlias = float | str | None
"""A feature's value: a number, a label, or null where absent."""
ChildDoc: TypeAlias = Annotated[int, Meta(ge=1)] | Literal["stay"]


class Part(Struct, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A part of a document: unknown fields are refused, fields at their default are left out."""


class StateDoc(Part, kw_only=True):
    """A state."""

    name: Name
    behavior: str | None = None
    binding: dict[str, str] = {}
    flag: str | None = None


class FeatureDoc(Part, kw_only=True):
    """A feature as the automaton uses it. `sort`: of the body, or which of the automaton's own."""

    name: Name
    binding: dict[str, str] = {}
    sort: Literal["body", "flag", "counter", "timer", "time in state"] = "body"
    kind: str
    unit: str = ""


class AutomatonDoc(Part, omit_defaults=False, kw_only=True):
    """The automaton without its transition functions."""

    name: Name
    parameters: list[str]
    stateless: bool
    states: list[StateDoc]
    features: list[FeatureDoc]


class TreesDoc(Part, tag_field="learns", tag="trees", omit_defaults=False, kw_only=True):
    """Decision trees. `defaults` is left out where they teach, `pruning` where there is none."""

    boundary: Literal["default keeps the gap", "midpoint"]
    defaults: bool | UnsetType = UNSET
    pruning: float | UnsetType = UNSET


class ScikitDoc(Part, tag_field="learns", tag="scikit-learn", omit_defaults=False, kw_only=True):
    """A classifier of scikit-learn."""

    classifier: str
    parameters: dict[str, float | int | str | bool | None]


class OptionsDoc(Part, omit_defaults=False, kw_only=True):
    """How the lesson is learned. `unlearning` is there where corrections quarantine bad examples."""

    reaction_s: float
    watched: bool
    learner: TreesDoc | ScikitDoc
    unlearning: bool | UnsetType = UNSET


class ExampleDoc(Part, kw_only=True):
    """A press-made example. `own`: the automaton's own readings then, null where absent."""

    number: Count
    state: str
    next: str
    kind: Literal["directive", "default", "confirmation"]
    values: list[Value]
    correction: bool = False
    edited: bool = False
    moment: Count | None = None
    window: Count = 0
    own: dict[str, float | None] = {}
    binding: dict[str, str] = {}
    quarantined: str = ""


class WatchedDoc(Part, kw_only=True):
    """Watched examples whose `own` has the same keys and whose `binding` is the same: a column each."""

    number: list[Count]
    state: list[str]
    next: list[str]
    values: list[list[Value]]
    correction: list[bool] = []
    edited: list[bool] = []
    moment: list[Count | None] = []
    window: list[Count] = []
    own: dict[str, list[float | None]] = {}
    binding: dict[str, str] = {}
    quarantined: list[str] = []


class ReadingDoc(Part, kw_only=True):
    """The column of one reading in the record, packed."""

    reading: Name
    of: str | None = None
    values: str


class RecordDoc(Part, omit_defaults=False, kw_only=True):
    """All readings at the moments the lesson keeps; columns are base64 of zlib of little-endian float64."""

    moments: Count
    seconds: str
    readings: list[ReadingDoc]


class OutcomeDoc(Part, kw_only=True):
    """What the lesson promises; `scenario` and `snapshot` are base64 of zlib."""

    flag: Name
    within_s: float
    world: str
    agent: Count = 0
    sort: str = ""
    targets: dict[str, str] = {}
    scenario: str
    snapshot: str


class LessonDoc(Part, omit_defaults=False, kw_only=True):
    """What was shown, and how it is learned. `outcomes` is left out where nothing is promised."""

    options: OptionsDoc
    examples: list[ExampleDoc]
    watched: list[WatchedDoc]
    record: RecordDoc
    outcomes: list[OutcomeDoc] | UnsetType = UNSET


class GoDoc(Part, tag_field="node", tag="go", kw_only=True):
    """A leaf that goes to a state."""

    to: str


class StayDoc(Part, tag_field="node", tag="stay", kw_only=True):
    """A leaf that keeps the current state."""


class BelowDoc(Part, tag_field="node", tag="below", omit_defaults=False, kw_only=True):
    """Is the feature below the cut?"""

    feature: str
    cut: float
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class ArcDoc(Part, tag_field="node", tag="arc", omit_defaults=False, kw_only=True):
    """Is the feature on the arc `low` <= x < `high`, across the seam where low > high?"""

    feature: str
    low: float = field(name="from")
    high: float = field(name="to")
    yes: ChildDoc
    no: ChildDoc
    absent: ChildDoc


class AbsentDoc(Part, tag_field="node", tag="absent", kw_only=True):
    """Is the feature absent?"""

    feature: str
    yes: ChildDoc
    no: ChildDoc


class LabelDoc(Part, tag_field="node", tag="label", omit_defaults=False, kw_only=True):
    """Which label is it?"""

    feature: str
    branches: dict[str, ChildDoc]
    absent: ChildDoc


NodeDoc: TypeAlias = GoDoc | StayDoc | BelowDoc | ArcDoc | AbsentDoc | LabelDoc


class BuiltDoc(Part, omit_defaults=False, kw_only=True):
    """The trees by state, a stateless automaton's under `*`; `hash` is None for those written by hand."""

    hash: str | None
    trees: dict[str, list[NodeDoc]]


class Document(Part, omit_defaults=False, kw_only=True):
    """One automaton: `lesson` is None if written by hand, `built` where it must be fitted on loading."""

    format: int
    automaton: AutomatonDoc
    lesson: LessonDoc | None
    built: BuiltDoc | None


class Versioned(Struct):
    """What every format has had: its number."""

    format: int
