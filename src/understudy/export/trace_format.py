"""The traces that exported code writes: what is in them, and which library they belong to.

The first line names the automaton, its binding and the fingerprint of its library. Every other line is a tick: the
time, and for each level AUTOMATON.BEFORE.LEAF.AFTER, where AUTOMATON and the states are indices, and LEAF is the index
of the leaf's node, -1 if the values were never shown, or -2 if the state has no tree.
"""

from __future__ import annotations

from understudy.export.target_files import ExportJob

TRACE = "# understudy exported trace 1"
"""How the first line of a trace begins."""
NEVER_SHOWN = -1
NO_TREE = -2


def format_trace_header(job: ExportJob) -> str:
    """Format the first line of the traces of an export."""
    binding = ",".join(f"{parameter}={target}" for parameter, target in job.hierarchy.binding.items())
    return ";".join((TRACE, job.hierarchy.name, binding, job.fingerprint))
