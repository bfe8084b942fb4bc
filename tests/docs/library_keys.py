"""The keys of a library's documents, for the reference: their meanings here, types and defaults from the schema.

After a key changed, bring the page up to date with: python -m tests.docs.library_keys
"""

from __future__ import annotations

from tests.docs.pages import ROOT
from tests.docs.renew import replace_between
from tests.docs.schema_tables import Parts, format_tables

from understudy.storage.library_schema import (
    AbsentDoc,
    ArcDoc,
    AutomatonDoc,
    BelowDoc,
    BuiltDoc,
    DifferenceDoc,
    Document,
    ExampleDoc,
    FeatureDoc,
    GoalDoc,
    GoDoc,
    KitDoc,
    KitFeatureDoc,
    LabelDoc,
    LessonDoc,
    OptionsDoc,
    OutcomeDoc,
    PairedReadingDoc,
    QuotientDoc,
    ReadingDoc,
    RecordDoc,
    ScikitDoc,
    SourceDoc,
    StateDoc,
    StayDoc,
    TreesDoc,
    WatchedDoc,
    WatchedSourceDoc,
)

PAGE = ROOT / "docs" / "reference" / "library-format.md"
KEYS = (
    "<!-- keys: python -m tests.docs.library_keys puts here what the schema says -->\n",
    "<!-- end of keys -->",
)

_FEATURE = "the feature, as a [label](#labels-of-features)"
_YES = "the child if the test holds"
_NO = "the child if it does not"
_ABSENT = "the child if the feature is absent"
_COLUMN = "a column; an empty list stands for the default of the same key of an example in every row"
_OWN = "values of the automaton's own features at that moment by name, null if absent"

PARTS: Parts = {
    Document: (
        "Document",
        {
            "format": "number of the format, 1",
            "automaton": "states, features and parameters",
            "lesson": "what the automaton was learned from; null if it was written by hand",
            "built": "the trees; null if they are to be learned on opening (see [Trees and hash](#trees-and-hash))",
        },
    ),
    AutomatonDoc: (
        "Automaton",
        {
            "name": "name of the automaton, under which other automata use it as a behavior",
            "parameters": "names of the targets that are bound when the automaton is used, such as `A`",
            "stateless": "true if one tree decides in every state",
            "states": "the states; the first one is the start state, which has neither behavior nor flag",
            "features": "the features that the trees may test, in the order of the values of examples",
        },
    ),
    StateDoc: (
        "State",
        {
            "name": "name of the state, unique in the automaton",
            "behavior": "behavior that runs in the state: a basic one or an automaton; null if the state idles",
            "binding": "for each parameter of the behavior, a target or a parameter of the automaton",
            "flag": "flag that is raised on entering the state: `done`, `failed` or another name; not with `behavior`",
        },
    ),
    FeatureDoc: (
        "Feature",
        {
            "name": "name of the feature",
            "binding": "for each parameter of the feature, a target or a parameter of the automaton",
            "sort": "`body` for a feature of the kit, otherwise which of the automaton's own features it is",
            "kind": "the [kind](#kinds) of its values",
            "unit": "unit of its values, such as `m`; must be that of the kit unless left out",
            "pair": "what it is computed of, if it is a [pair of readings](#pairs-of-readings)",
        },
    ),
    QuotientDoc: (
        "Quotient",
        {"left": "the dividend", "right": "the divisor"},
    ),
    DifferenceDoc: (
        "Difference",
        {"left": "what is subtracted from", "right": "what is subtracted"},
    ),
    PairedReadingDoc: (
        "Paired reading",
        {
            "reading": "name of the body's reading",
            "of": "parameter of the feature whose target it is about; null if it is about the body itself",
            "name": "name of the kit's feature that is this reading; that of the reading if left out",
        },
    ),
    LessonDoc: (
        "Lesson",
        {
            "options": "how the lesson is learned",
            "examples": "the examples made by presses, in the order of their numbers",
            "watched": "the watched examples, in groups with the same `binding`, keys of `own` and recording",
            "record": "all readings around the presses, from which features added later get their values",
            "outcomes": "properties that start at a stored moment, which `understudy test` checks",
            "goal": "what success means in any world; left out where a flag or the world's goal counts",
            "kit": "what the automaton needs that no program defines, as one from a recording or a table",
        },
    ),
    OptionsDoc: (
        "Options",
        {
            "reaction_s": "assumed reaction time of the teacher, s; 0 to 1",
            "watched": "whether silence is recorded as watched examples",
            "learner": "the learner",
            "unlearning": "whether corrections put contradicting examples into quarantine; left out if false",
            "live": "whether the robot decides by itself from the first press on; left out if false",
        },
    ),
    TreesDoc: (
        "Decision trees",
        {
            "boundary": "where a cut lies between two examples of different outcome",
            "defaults": "whether automatic default examples teach; true if left out",
            "pruning": "how many examples a branch must set right to be kept, 0 or more; 0 if left out",
            "order": "which test is selected, if not the one with the highest gain ratio",
        },
    ),
    ScikitDoc: (
        "Classifier",
        {
            "classifier": "name of a classifier of scikit-learn",
            "parameters": "its parameters, by name",
        },
    ),
    ExampleDoc: (
        "Example",
        {
            "number": "number of the example, unique in the lesson; presses and watched examples share the numbers",
            "state": "the state in which the press came",
            "next": "the state that was pressed",
            "kind": "what made the example (see [semantics](../semantics.md))",
            "values": "one value for each feature of the automaton, in their order: a label or number, null if absent",
            "correction": "whether the press corrected what the automaton did in testing",
            "edited": "whether a person changed the example afterwards",
            "moment": "row of the record at which the values were read, from 0; null if typed",
            "window": "how many rows before `moment` a late press may be moved to; at most `moment`",
            "own": _OWN,
            "binding": "what each parameter of the automaton stood for",
            "quarantined": "why the example does not teach for now; empty if it does",
            "reaction_s": "reaction time of who pressed, s, 0 to 1; that of the options if left out",
            "source": "the place in a recording that it was made from; none for presses in a session",
        },
    ),
    SourceDoc: (
        "Source",
        {
            "file": "name of the recording's file",
            "time_s": "time in the recording, s",
            "driver": "name of the person who drove; empty if it was not said",
            "certainty": "how certain the label of the recording is there, 0 to 1",
        },
    ),
    WatchedDoc: (
        "Watched examples",
        {
            "number": "the column of numbers, which sets the length of all columns",
            "state": "the column of states",
            "next": "the column of next states",
            "values": "one column for each feature of the automaton, in their order",
            "correction": _COLUMN,
            "edited": _COLUMN,
            "moment": _COLUMN,
            "window": _COLUMN,
            "own": "one column for each of the automaton's own features, null where absent",
            "binding": "what each parameter of the automaton stood for, in all rows",
            "quarantined": _COLUMN,
            "source": "the places in one recording that they were made from; none for a session's",
        },
    ),
    WatchedSourceDoc: (
        "Source of watched examples",
        {
            "file": "name of the recording's file",
            "time_s": "the column of times in the recording, s",
            "driver": "name of the person who drove; empty if it was not said",
            "certainty": "the column of certainties, 0 to 1; an empty list stands for 1 in every row",
        },
    ),
    RecordDoc: (
        "Record",
        {
            "moments": "number of rows",
            "seconds": "[packed](#packed-numbers) times of the rows on the body's clock, s",
            "readings": "the readings, one column each",
        },
    ),
    ReadingDoc: (
        "Reading",
        {
            "reading": "name of the reading of the body",
            "of": "target that it is a reading of; null if of none",
            "values": "[packed](#packed-numbers) values, NaN where absent",
        },
    ),
    OutcomeDoc: (
        "Outcome",
        {
            "flag": "flag that the automaton must raise in time",
            "kind": "without a flag: form of the property",
            "what": "without a flag: its [condition](../properties.md#conditions), or `progress`",
            "within_s": "its time, s; positive; left out for the kind `never` only",
            "limit_s": "for how long it runs, s; by default the scenario's limit",
            "world": "name of the scenario",
            "agent": "index of the robot that runs the automaton, from 0",
            "sort": "sort of squads that a coordinator was taught to; empty for a robot",
            "targets": "target of each parameter of the automaton",
            "scenario": "the scenario's file at the time, as base64 of zlib",
            "snapshot": "the world at that moment, as base64 of zlib",
        },
    ),
    GoalDoc: (
        "Goal",
        {
            "name": "what success means, shortly, for people",
            "kind": "form of the property",
            "what": "its [condition](../properties.md#conditions), or `progress`",
            "within_s": "its time, s; positive; left out for the kind `never` only",
            "limit_s": "for how long it runs, s; positive; by default the scenario's limit",
            "world": "name of the scenario in which it was chosen; it is measured in any",
        },
    ),
    KitDoc: (
        "Kit",
        {
            "features": "the features that are readings",
            "behaviors": "the command of each behavior by channel; empty in a table",
            "targets": "the names of the targets",
        },
    ),
    KitFeatureDoc: (
        "Feature of a kit",
        {
            "name": "its name",
            "reading": "the reading that is its value; that of its own name if empty",
            "of": "the parameter whose target the reading is about; null if it is about the robot",
            "kind": "kind of its values, as that of a [feature](#feature)",
            "unit": "unit of its values",
            "doc": "what it means, for people",
        },
    ),
    BuiltDoc: (
        "Built",
        {
            "hash": "`sha256:` and 64 hexadecimal digits (see [above](#trees-and-hash)); null without a lesson",
            "trees": "the nodes of the tree of each state; `*` is the tree of all states of a stateless automaton",
        },
    ),
    GoDoc: ("Leaf `go`", {"to": "the next state"}),
    StayDoc: ("Leaf `stay`", {}),
    BelowDoc: (
        "Test `below`",
        {
            "feature": f"{_FEATURE}; continuous or toroidal",
            "cut": "the test holds if x < cut",
            "yes": _YES,
            "no": f"{_NO}: x ≥ cut",
            "absent": _ABSENT,
        },
    ),
    ArcDoc: (
        "Test `arc`",
        {
            "feature": f"{_FEATURE}; toroidal",
            "from": "beginning of the arc, which belongs to it",
            "to": "end of the arc, which does not belong to it",
            "yes": "the child if x is on the arc",
            "no": "the child if x is not on the arc",
            "absent": _ABSENT,
        },
    ),
    AbsentDoc: (
        "Test `absent`",
        {
            "feature": _FEATURE,
            "yes": "the child if the feature is absent",
            "no": "the child if it has a value",
        },
    ),
    LabelDoc: (
        "Test `label`",
        {
            "feature": f"{_FEATURE}; categorical or boolean",
            "branches": "one child for each label of the kind: all of them, and no others",
            "absent": _ABSENT,
        },
    ),
}


def make_tables() -> str:
    """Return the part of the page with all keys."""
    return format_tables(PARTS)


if __name__ == "__main__":
    replace_between(PAGE, KEYS, make_tables())
