"""The names of an export to BehaviorTree.CPP: node types, trees, ports, and the keys of the blackboard."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from understudy.export.hierarchy import FeatureSource, GroundAutomaton, Hierarchy
from understudy.export.identifiers import make_identifier, make_identifiers
from understudy.export.targets.c99_names import RESERVED, CNames, name_functions

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
FUNCTIONS = """
absolute finite_or_absent greater is_absent lesser measure_elapsed or_rest read_label read_number register_nodes root
to_label wrap write_readings understudy bt r
"""
WORDS = RESERVED | set(f"{BUILT_IN} {PORTS} {FUNCTIONS}".split())


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
    automata = make_identifiers([each.name for each in hierarchy.automata], what="automata", reserved=WORDS)
    basics = make_identifiers([each.name for each in hierarchy.basics], what="behaviors", reserved=WORDS)
    readings = make_identifiers([str(each) for each in hierarchy.readings], what="readings", reserved=WORDS)
    states: dict[str, str] = {}
    for each in hierarchy.automata:
        of = make_identifiers([state.name for state in each.states], what=f"states of {each.name}")
        states |= {f"{each.name}/{name}": identifier for name, identifier in of.items()}
    types = _Names(basics.values())
    trees = {name: types.add(identifier) for name, identifier in automata.items()}
    prefix = make_identifier(hierarchy.name, WORDS).lower()
    channels = make_identifiers([each.name for each in hierarchy.channels], what="channels", reserved=WORDS)
    keys = _Names(("now", *readings.values()))
    used = hierarchy.computed_features
    nodes = {index: types.add(f"compute_{make_identifier(hierarchy.computed[index].name)}") for index in used}
    computed = {index: keys.add(make_identifier(hierarchy.computed[index].name, WORDS)) for index in used}
    memory = {
        (number, sort, index): keys.add(f"{automata[each.name]}_{make_identifier(name)}")
        for number, each in enumerate(hierarchy.automata)
        for sort, index, name in _list_memory(each)
    }
    return TreeNames(
        CNames(prefix, readings, channels, basics, trees, states, name_functions(hierarchy)),
        nodes,
        computed,
        memory,
    )


def _list_memory(automaton: GroundAutomaton) -> list[tuple[str, int, str]]:
    """List what an automaton remembers, and what its trees measure: sort, index and name."""
    found = [("state", 0, "state"), ("entered", 0, "entered"), ("leaf", 0, "leaf")]
    found += [("counter", index, name) for index, name in enumerate(automaton.counters)]
    found += [("timer", index, f"{name} set") for index, name in enumerate(automaton.timers)]
    found += [
        ("measured", index, source.name)
        for index, source in enumerate(automaton.features)
        if is_measured(source)
    ]
    return found


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
