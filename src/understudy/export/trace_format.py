"""The traces that exported code writes: what is in them, and which library they belong to.

The first line names the automaton, its binding and the fingerprint of its library, with %XX for the characters that
separate them. Every other line is a tick: the
time, and for each level AUTOMATON.BEFORE.LEAF.AFTER, where AUTOMATON and the states are indices, and LEAF is the index
of the leaf's node, -1 if the values were never shown, or -2 if the state has no tree.
"""

from __future__ import annotations

from understudy.export.target_files import ExportJob

TRACE = "# understudy exported trace 1"
"""How the first line of a trace begins."""
SEPARATORS = "%;,=\r\n"
"""Characters of names that the first line spells as %XX."""
NEVER_SHOWN = -1
NO_TREE = -2


def format_trace_header(job: ExportJob) -> str:
    """Format the first line of the traces of an export."""
    binding = ",".join(
        f"{_quote(parameter)}={_quote(target)}" for parameter, target in job.hierarchy.binding.items()
    )
    return ";".join((TRACE, _quote(job.hierarchy.name), binding, job.fingerprint))


def _quote(name: str) -> str:
    return "".join(f"%{ord(each):02X}" if each in SEPARATORS else each for each in name)
