"""Find states that cannot be entered or left, flags that are waited for and never raised, and missing behaviors."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.addons.checks.verification.cells import Axis, Leaf, intersect
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.subject import MOST_EXAMPLES, Subject
from understudy.errors import join_names
from understudy.model.describe import name_examples
from understudy.model.tree import STAY


def find_states_never_entered(subject: Subject) -> Iterator[Finding]:
    """Find states that no series of switches from the start state leads to."""
    states = subject.level.automaton.states
    for index, state in enumerate(states):
        if index in subject.level.reachable_states:
            continue
        what = f"flag {state.flag} is never raised" if state.flag is not None else "it never runs"
        why, assumptions = _explain_never_entered(subject, index)
        yield Finding(
            FindingKind.NEVER_ENTERED,
            Severity.ERROR,
            subject.label,
            f"State {state.name} is never entered, so {what}: {why}.",
            (state.name,),
            assumptions,
            remedy=f"Show when to go to {state.name}, or remove the state.",
        )


def _explain_never_entered(subject: Subject, index: int) -> tuple[str, tuple[str, ...]]:
    """Say why a state is never entered, and what is assumed for that."""
    level, names = subject.level, subject.level.automaton.state_names
    sources = [names[other] for other, exits in enumerate(level.exits) if index in exits]
    if sources:
        leads, them = ("leads", "it") if len(sources) == 1 else ("lead", "them")
        return f"only {join_names(sources)} {leads} there, and nothing from start leads to {them}", ()
    waiting = [state for state in range(len(names)) if state != index and index in level.list_outcomes(state)]
    if not waiting:
        return "no leaf of any tree leads there", ()
    them = "it" if len(waiting) == 1 else "them"
    places = join_names(names[state] for state in waiting)
    tied = any(level.is_excluded_by_ties(state, index) for state in waiting)
    why = f"the leaves of {places} that lead there need what never occurs in {them}"
    return why, subject.level.space.tie_sentences if tied else ()


def find_states_never_left(subject: Subject) -> Iterator[Finding]:
    """Find states, other than flag states, that are entered and from which no leaf leads elsewhere."""
    level = subject.level
    users = subject.library.find_users(level.name)
    unless = f" unless {join_names(users)} stops {level.name}" if users else ""
    for index in sorted(level.reachable_states):
        state = level.automaton.states[index]
        if state.flag is not None or level.exits[index]:
            continue
        assumptions: tuple[str, ...] = ()
        if state.name not in level.automaton.transitions:
            why = "nothing was shown in it" if level.taught.lesson is not None else "it has no tree"
        elif outcomes := level.list_outcomes(index):
            why = "the leaves that lead elsewhere need what never occurs there"
            if any(level.is_excluded_by_ties(index, outcome) for outcome in outcomes):
                assumptions = subject.level.space.tie_sentences
        else:
            why = "every leaf of its tree stays"
        yield Finding(
            FindingKind.NEVER_LEFT,
            Severity.ERROR if index == 0 else Severity.WARNING,
            subject.label,
            f"State {state.name} is never left{unless}: {why}.",
            (state.name,),
            assumptions,
            remedy=f"Show when to leave {state.name}; if it is meant to stay there, nothing is wrong.",
        )


def find_flags_never_raised(subject: Subject) -> Iterator[Finding]:
    """Find states whose tree waits for a flag that their behavior, or the members they order, cannot raise."""
    level = subject.level
    for index in sorted(level.reachable_states):
        state, leaves = level.automaton.states[index], level.leaves[index]
        if state.flag is not None or leaves is None:
            continue
        domain = level.get_domain(index)
        for axis, constant in level.list_constants(index):
            other = axis.whole & ~constant
            lost = [
                leaf
                for leaf in leaves
                if leaf.node != STAY
                and leaf.outcome not in (STAY, index)
                and axis.whole in leaf.tested
                and not leaf.box & constant
                and intersect((domain & ~axis.whole) | other, leaf)
            ]
            if lost and not (level.automaton.stateless and _varies_elsewhere(subject, axis)):
                yield _make_flag_finding(subject, index, axis, lost)


def _make_flag_finding(subject: Subject, index: int, axis: Axis, lost: list[Leaf]) -> Finding:
    level = subject.level
    state, name = level.automaton.states[index], str(axis.bound)
    waits = join_names(dict.fromkeys(level.automaton.states[leaf.outcome].name for leaf in lost))
    examples = [each for leaf in lost for each in subject.list_examples(state.name, leaf.node)]
    numbers = tuple(sorted({each.number for each in examples}))
    why, remedy = _explain_constant(subject, index, name, numbers)
    return Finding(
        FindingKind.FLAG_NEVER_RAISED,
        Severity.WARNING if level.exits[index] else Severity.ERROR,
        subject.label,
        f"State {state.name} waits for {name} to go to {waits}, which never happens there: {why}.",
        (state.name,),
        cells=subject.make_cells([leaf.box for leaf in lost]),
        examples=numbers,
        remedy=remedy,
    )


def _varies_elsewhere(subject: Subject, axis: Axis) -> bool:
    """Return whether a flag varies in another state of a stateless automaton, whose states share their tree."""
    level = subject.level
    return any(
        axis.shift not in {other.shift for other, _ in level.list_constants(state)}
        for state in level.reachable_states
        if level.automaton.states[state].flag is None
    )


def _explain_constant(subject: Subject, index: int, flag: str, numbers: tuple[int, ...]) -> tuple[str, str]:
    """Say why a flag never changes in a state, and what would change that."""
    child, state = subject.level.children[index], subject.level.automaton.states[index]
    behind = f", or delete {name_examples(numbers, most=MOST_EXAMPLES)}" if numbers else ""
    if child is not None:
        is_raised_elsewhere = flag in child.automaton.flags
        why = f"no series of switches in {child.name} leads to a state that raises it"
        return (
            why if is_raised_elsewhere else f"{child.name} has no state that raises it",
            f"Show {child.name} when to raise {flag}.",
        )
    if subject.members is not None and state.behavior:
        order = subject.library.format_call(state.behavior, state.binding)
        why = f"members that are ordered to run {order} cannot raise the flag"
        return why, f"Let {state.name} order what raises the flag{behind}."
    runs = f"{state.behavior} is a basic behavior" if state.behavior else f"{state.name} idles"
    return f"{runs}, and raises no flags", f"Let {state.name} run an automaton that raises {flag}{behind}."


def find_missing_behaviors(subject: Subject) -> Iterator[Finding]:
    """Find states that run a behavior that the kit and the library do not have; only with a known kit."""
    library = subject.library
    if not subject.kit_known or subject.members is not None:
        return
    for state in subject.level.automaton.states:
        name = state.behavior
        if name is None or name in library.taught or name in library.kit.behaviors:
            continue
        yield Finding(
            FindingKind.MISSING_BEHAVIOR,
            Severity.ERROR,
            subject.label,
            f"State {state.name} runs {name}, which neither the robot nor the library has.",
            (state.name,),
            remedy=f"Teach {name}, or let the state run something else.",
        )
