"""The identifiers of an export to C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from understudy.export.hierarchy import Hierarchy
from understudy.export.identifiers import make_identifier, make_identifiers

KEYWORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while asm bool class
delete explicit export false friend mutable namespace new operator private protected public template this throw true
try catch typename using virtual wchar_t and or not xor main
"""
MEMBERS = "issued traced leaf trace"
RESERVED = frozenset(f"{KEYWORDS} {MEMBERS}".split())
"""Words of C and C++, and members of the structures of an export."""


@dataclass(frozen=True, slots=True)
class CNames:
    """The identifiers of an export to C: what everything begins with, and those of its parts by name."""

    prefix: str
    readings: Mapping[str, str]
    channels: Mapping[str, str]
    basics: Mapping[str, str]
    automata: Mapping[str, str]
    states: Mapping[str, str]


def name_for_c(hierarchy: Hierarchy) -> CNames:
    """Make the identifiers of a hierarchy; DefinitionError if two names become the same."""
    states: dict[str, str] = {}
    automata = make_identifiers(
        [each.name for each in hierarchy.automata], what="automata", reserved=RESERVED
    )
    for each in hierarchy.automata:
        of = make_identifiers([state.name for state in each.states], what=f"states of {each.name}")
        states |= {f"{each.name}/{name}": identifier for name, identifier in of.items()}
    return CNames(
        make_identifier(hierarchy.name, RESERVED).lower(),
        make_identifiers([str(each) for each in hierarchy.readings], what="readings", reserved=RESERVED),
        make_identifiers([each.name for each in hierarchy.channels], what="channels", reserved=RESERVED),
        make_identifiers([each.name for each in hierarchy.basics], what="behaviors", reserved=RESERVED),
        automata,
        states,
    )
