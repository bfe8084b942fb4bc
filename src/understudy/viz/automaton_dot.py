"""Write automata as text for Graphviz: states as nodes, transitions with their conditions as edges."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.model.automaton import Automaton
from understudy.model.library import TrainedAutomaton
from understudy.viz.automaton_graph import AutomatonGraph, GraphNode, lay_out_taught
from understudy.viz.palette import FAINT, INK

WRAP = 36
"""The number of letters after which a condition goes on in the next line."""


def write_automata_dot(automata: Sequence[TrainedAutomaton]) -> str:
    """Return Graphviz text of automata: one graph, or a cluster each with lines from states to what they run."""
    graphs = [lay_out_taught(taught) for taught in automata]
    head = [
        f"digraph {_quote(graphs[0].title)} {{",
        "  compound=true; rankdir=LR;",
        f'  node [shape=box, style="rounded,filled", fontname="Helvetica", color="{FAINT}", fontcolor="{INK}"];',
        f'  edge [fontname="Helvetica", fontsize=11, color="{FAINT}", fontcolor="{INK}"];',
    ]
    if len(graphs) == 1:
        return "\n".join([*head, *_list_lines(graphs[0], 0, "  "), "}", ""])
    lines = list(head)
    for at, graph in enumerate(graphs):
        lines += [f"  subgraph cluster_{at} {{", f"    label={_quote(graph.title)};"]
        lines += [*_list_lines(graph, at, "    "), "  }"]
    names = [taught.automaton.name for taught in automata]
    for at, taught in enumerate(automata):
        lines += _list_calls(taught.automaton, at, names)
    return "\n".join([*lines, "}", ""])


def _list_lines(graph: AutomatonGraph, at: int, indent: str) -> list[str]:
    order = {node.name: index for index, node in enumerate(graph.nodes)}
    lines = [f"{indent}s{at}_{index} [{_describe_node(node)}];" for index, node in enumerate(graph.nodes)]
    lines += [f"{indent}b{at} [shape=point, width=0.12];", f"{indent}b{at} -> s{at}_0;"]
    for edge in graph.edges:
        label = _quote("\n".join(_wrap(" ".join(line.text for line in edge.lines))))
        begin, end = (f"s{at}_{order[name]}" for name in (edge.begin, edge.end))
        lines.append(f'{indent}{begin} -> {end} [label={label}, color="{edge.color}"];')
    return lines


def _describe_node(node: GraphNode) -> str:
    label = _quote(f"{node.name}\n{node.below}" if node.below else node.name)
    dashes = ', style="rounded,filled,dashed"' if node.flagged else ""
    return f'label={label}, fillcolor="{node.fill}", color="{node.stroke}"{dashes}'


def _list_calls(automaton: Automaton, at: int, names: Sequence[str]) -> list[str]:
    """List dotted lines from the states of an automaton to the automata that they run."""
    return [
        f"  s{at}_{index} -> b{names.index(state.behavior)} "
        f"[style=dotted, arrowhead=none, lhead=cluster_{names.index(state.behavior)}];"
        for index, state in enumerate(automaton.states)
        if state.behavior in names
    ]


def _wrap(text: str) -> list[str]:
    from textwrap import wrap

    return wrap(text, WRAP, break_long_words=False, break_on_hyphens=False) or [""]


def _quote(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
