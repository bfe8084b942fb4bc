"""The identifiers of exports to C and C++, and the names of an export to BehaviorTree.CPP.

The latter are node types, trees, ports, and the keys of the blackboard.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from understudy.addons.export.hierarchy import FeatureSource, GroundAutomaton, Hierarchy
from understudy.addons.export.identifiers import make_identifier, make_identifiers
from understudy.errors import DefinitionError

KEYWORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while asm bool class
delete explicit export false friend mutable namespace new operator private protected public template this throw true
try catch typename using virtual wchar_t and or not xor main alignas alignof and_eq bitand bitor char8_t char16_t
char32_t compl concept consteval constexpr constinit const_cast co_await co_return co_yield decltype dynamic_cast
noexcept not_eq nullptr or_eq reinterpret_cast requires static_assert static_cast thread_local typeid typeof xor_eq
"""
MACROS = """
nan infinity huge_val null eof absent rows progmem stay no_tree answer before after is_absent
"""
"""Macros of the headers that an export includes, and its own."""
MEMBERS = "issued traced leaf trace levels tick_ms trace_header h"
FUNCTIONS = "start enter pulse next tree flag value command conformance embedded embedded_rows"
HEADERS = "assert errno math signal stdint stdio stdlib string time"
"""Headers of C for which that of an export must not be taken."""
RESERVED = frozenset(f"{KEYWORDS} {MACROS} {MEMBERS}".split())
"""Words of C and C++, and members of the structures of an export."""
MOST = 255
"""How many states an automaton may have, and how many basic behaviors there may be: their indices are one byte."""
BUILT_IN = """
action alwaysfailure alwayssuccess asyncsequence behaviortree condition control decorator delay entryupdated fallback
forcefailure forcesuccess ifthenelse include inverter isabsent isatleast isbelow isinarc isoffarc
keeprunninguntilfailure loopbool loopdouble loopint loopstring manualselector measureelapsed parallel parallelall
precondition reactivefallback reactivesequence repeat retryuntilsuccessful root runonce script scriptcondition sequence
sequencewithmemory setblackboard skipunlessupdated sleep subtree switch switch2 switch3 switch4 switch5 switch6 timeout
treenodesmodel unsetblackboard waitvalueupdated wasentryupdated
"""
"""The node types of BehaviorTree.CPP and of every export, and the tags of its files."""
PORTS = "name id since now value limit low high elapsed true false commands readings config behavior node board tag"
"""Names of ports and parameters that an export uses, and words of scripts."""
NODE_FUNCTIONS = """
absolute finite_or_absent greater is_absent lesser measure_elapsed or_rest read_label read_number register_nodes root
to_label wrap write_readings understudy bt r
"""
WORDS = RESERVED | set(f"{BUILT_IN} {PORTS} {NODE_FUNCTIONS}".split())


@dataclass(frozen=True, slots=True)
class CNames:
    """The identifiers of an export to C: what everything begins with, and those of its parts by name."""

    prefix: str
    readings: Mapping[str, str]
    channels: Mapping[str, str]
    basics: Mapping[str, str]
    automata: Mapping[str, str]
    states: Mapping[str, str]
    functions: Mapping[str, str] = field(default_factory=dict)
    """The functions to write, by their name in `Hierarchy.functions_to_write`."""

    @property
    def by_sort(self) -> Mapping[str, Mapping[str, str]]:
        """The identifiers as a manifest has them."""
        return {
            "readings": self.readings,
            "channels": self.channels,
            "basics": self.basics,
            "automata": self.automata,
            "states": self.states,
        }


def name_for_c(hierarchy: Hierarchy) -> CNames:
    """Make the identifiers of a hierarchy; DefinitionError if two names become the same."""
    for what, count in [
        ("the hierarchy has basic behaviors", len(hierarchy.basics)),
        *((f"automaton {each.name!r} has states", len(each.states)) for each in hierarchy.automata),
    ]:
        if count > MOST:
            raise DefinitionError(what="target c99", problem=f"{what}: {count}", remedy=f"it can take {MOST}")
    prefix = make_identifier(hierarchy.name, RESERVED | set(f"{FUNCTIONS} {HEADERS}".split())).lower()
    names = _name_parts(hierarchy, prefix, RESERVED)
    _check_constants(hierarchy, names.basics, names.automata, names.states)
    return names


def _name_parts(hierarchy: Hierarchy, prefix: str, reserved: Collection[str]) -> CNames:
    states: dict[str, str] = {}
    automata = make_identifiers(
        [each.name for each in hierarchy.automata], what="automata", reserved=reserved
    )
    for each in hierarchy.automata:
        of = make_identifiers([state.name for state in each.states], what=f"states of {each.name}")
        states |= {f"{each.name}/{name}": identifier for name, identifier in of.items()}
    return CNames(
        prefix,
        make_identifiers([str(each) for each in hierarchy.readings], what="readings", reserved=reserved),
        make_identifiers([each.name for each in hierarchy.channels], what="channels", reserved=reserved),
        make_identifiers([each.name for each in hierarchy.basics], what="behaviors", reserved=reserved),
        automata,
        states,
        name_functions(hierarchy),
    )


def name_functions(hierarchy: Hierarchy) -> Mapping[str, str]:
    """Make the names of the functions that could not be translated; an export repeated has the same ones."""
    return make_identifiers([each.name for each in hierarchy.functions_to_write], what="functions")


def _check_constants(
    hierarchy: Hierarchy, basics: Mapping[str, str], automata: Mapping[str, str], states: Mapping[str, str]
) -> None:
    """Refuse a behavior and a state, or two states of different automata, whose constants would be the same."""
    constants = [(f"behavior {each.name!r}", basics[each.name]) for each in hierarchy.basics]
    constants += [
        (
            f"state {state.name!r} of {each.name}",
            f"{automata[each.name]}_in_{states[f'{each.name}/{state.name}']}",
        )
        for each in hierarchy.automata
        for state in each.states
    ]
    names: dict[str, str] = {}
    for what, constant in constants:
        if constant.upper() in names:
            raise DefinitionError(
                what=f"{names[constant.upper()]} and {what}",
                problem=f"both become {constant!r} in the exported code",
                remedy="rename one of the two",
            )
        names[constant.upper()] = what


@dataclass(frozen=True, slots=True)
class TreeNames:
    """The names of an export to BehaviorTree.CPP.

    `c` has the identifiers that the export shares with C. `nodes` has the types of the nodes of computed values, by
    their index. `memory` has the keys of what an automaton remembers, by its index, a sort and an index.
    """

    c: CNames
    nodes: Mapping[int, str]
    computed: Mapping[int, str]
    memory: Mapping[tuple[int, str, int], str]

    def state(self, automaton: GroundAutomaton, index: int) -> str:
        """Return the value of the blackboard that stands for a state."""
        return self.c.states[f"{automaton.name}/{automaton.states[index].name}"]


def name_for_trees(hierarchy: Hierarchy) -> TreeNames:
    """Make the names of a hierarchy; DefinitionError if two names become the same."""
    names = _name_parts(hierarchy, make_identifier(hierarchy.name, WORDS).lower(), WORDS)
    types = _Names(names.basics.values())
    trees = {name: types.add(identifier) for name, identifier in names.automata.items()}
    keys = _Names(("now", *names.readings.values()))
    used = hierarchy.feature_functions
    nodes = {index: types.add(f"compute_{make_identifier(hierarchy.computed[index].name)}") for index in used}
    computed = {index: keys.add(make_identifier(hierarchy.computed[index].name, WORDS)) for index in used}
    memory = {
        (number, sort, index): keys.add(f"{names.automata[each.name]}_{make_identifier(name)}")
        for number, each in enumerate(hierarchy.automata)
        for sort, index, name in _list_memory(each)
    }
    return TreeNames(replace(names, automata=trees), nodes, computed, memory)


def _list_memory(automaton: GroundAutomaton) -> list[tuple[str, int, str]]:
    """List what an automaton remembers, and what its trees measure: sort, index and name."""
    fields = [("state", 0, "state"), ("entered", 0, "entered"), ("leaf", 0, "leaf")]
    fields += [("counter", index, name) for index, name in enumerate(automaton.counters)]
    fields += [("timer", index, f"{name} set") for index, name in enumerate(automaton.timers)]
    fields += [
        ("measured", index, source.name)
        for index, source in enumerate(automaton.features)
        if is_measured(source)
    ]
    return fields


def is_measured(source: FeatureSource) -> bool:
    """Return whether a value must be measured before the questions about it: a time, or one that a switch resets."""
    return source.sort in ("time in state", "timer") or source.fresh is not None


class _Names:
    """Names of which each is used once, ignoring case."""

    def __init__(self, taken: Iterable[str]) -> None:
        self.taken = {each.lower() for each in taken}

    def add(self, name: str) -> str:
        """Add a name, with underscores if it is taken."""
        while name.lower() in self.taken:
            name += "_"
        self.taken.add(name.lower())
        return name
