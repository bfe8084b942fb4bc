"""Find states that cannot be entered or left, flags that are waited for and never raised, and missing behaviors."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.errors import join_names
from understudy.model.features import FlagFeature
from understudy.model.kinds import YES
from understudy.model.tree import STAY
from understudy.verification.cells import intersect
from understudy.verification.finding import Finding, FindingKind, Severity
from understudy.verification.subject import Subject, list_tie_sentences, name_examples


def find_states_never_entered(subject: Subject) -> Iterator[Finding]:
    """Find states that no series of switches from the start state leads to."""
    states = subject.level.automaton.states
    for index, state in enumerate(states):
        if index in subject.level.entered:
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
    waiting = [
        names[state]
        for state, leaves in enumerate(level.leaves)
        if state != index and any(leaf.node != STAY and leaf.outcome == index for leaf in leaves or ())
    ]
    if not waiting:
        return "no leaf of any tree leads there", ()
    them = "it" if len(waiting) == 1 else "them"
    why = f"the leaves of {join_names(waiting)} that lead there need what never occurs in {them}"
    return why, list_tie_sentences(subject)


def find_states_never_left(subject: Subject) -> Iterator[Finding]:
    """Find states, other than flag states, that are entered and from which no leaf leads elsewhere."""
    level = subject.level
    users = subject.library.find_users(level.name)
    unless = f" unless {join_names(users)} stops {level.name}" if users else ""
    for index in sorted(level.entered):
        state = level.automaton.states[index]
        if state.flag is not None or level.exits[index]:
            continue
        assumptions: tuple[str, ...] = ()
        if state.name not in level.automaton.transitions:
            why = "nothing was shown in it" if level.taught.lesson is not None else "it has no tree"
        elif _leads_elsewhere(subject, index):
            why = "the leaves that lead elsewhere need what never occurs there"
            assumptions = list_tie_sentences(subject)
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


def _leads_elsewhere(subject: Subject, index: int) -> bool:
    return any(
        leaf.outcome not in (STAY, index) for leaf in subject.level.leaves[index] or () if leaf.node != STAY
    )


def find_flags_never_raised(subject: Subject) -> Iterator[Finding]:
    """Find states whose tree waits for a flag that their behavior cannot raise."""
    level = subject.level
    for index in sorted(level.entered):
        state, leaves = level.automaton.states[index], level.leaves[index]
        if state.flag is not None or leaves is None:
            continue
        child = level.children[index]
        raised = child.raised_flags if child is not None else frozenset[str]()
        domain = level.get_domain(index)
        for axis in level.axes:
            feature = axis.bound.feature
            if not isinstance(feature, FlagFeature) or feature.name in raised:
                continue
            up = axis.find_bit(YES)
            raising = (domain & ~axis.whole) | up
            lost = [
                leaf
                for leaf in leaves
                if leaf.node != STAY
                and leaf.outcome not in (STAY, index)
                and axis.whole in leaf.tested
                and not leaf.box & (axis.whole & ~up)
                and intersect(raising, leaf)
            ]
            if not lost or (level.automaton.stateless and _is_raised_elsewhere(subject, feature.name)):
                continue
            if child is None:
                runs = f"{state.behavior} is a basic behavior" if state.behavior else f"{state.name} idles"
                why = f"{runs}, and raises no flags"
            elif feature.name in child.automaton.flags:
                why = f"no series of switches in {child.name} leads to a state that raises it"
            else:
                why = f"{child.name} has no state that raises it"
            waits = join_names(dict.fromkeys(level.automaton.states[leaf.outcome].name for leaf in lost))
            stuck = not level.exits[index]
            numbers = sorted(
                {each.number for leaf in lost for each in subject.list_examples(state.name, leaf.node)}
            )
            yield Finding(
                FindingKind.FLAG_NEVER_RAISED,
                Severity.ERROR if stuck else Severity.WARNING,
                subject.label,
                f"State {state.name} waits for {feature.name} to go to {waits}, which is never raised there: {why}.",
                (state.name,),
                cells=subject.make_cells([leaf.box for leaf in lost]),
                examples=tuple(numbers),
                remedy=_flag_remedy(subject, index, feature.name, numbers),
            )


def _is_raised_elsewhere(subject: Subject, flag: str) -> bool:
    """Return whether another state of a stateless automaton, which shares its tree, runs what raises a flag."""
    return any(child is not None and flag in child.raised_flags for child in subject.level.children)


def _flag_remedy(subject: Subject, index: int, flag: str, numbers: list[int]) -> str:
    child, state = subject.level.children[index], subject.level.automaton.states[index]
    if child is not None:
        return f"Show {child.name} when to raise {flag}."
    behind = f", or delete {name_examples(numbers)}" if numbers else ""
    return f"Let {state.name} run an automaton that raises {flag}{behind}."


def find_missing_behaviors(subject: Subject) -> Iterator[Finding]:
    """Find states that run a behavior that the kit and the library do not have; only with a known kit."""
    library = subject.library
    if not subject.kit_known:
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
