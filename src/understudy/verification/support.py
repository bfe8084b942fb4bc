"""Find what rests on few examples: cells that one example decides, and readings that no example of a state had."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.errors import join_names
from understudy.model.features import Feature
from understudy.model.tree import STAY
from understudy.verification.cells import intersect
from understudy.verification.finding import Finding, FindingKind, Severity
from understudy.verification.subject import Subject, join_conditions, list_tie_sentences

ABSENT = "the reading can be absent: whether it ever is, is not decided here"


def _list_states(subject: Subject) -> list[int]:
    """List the states with a tree that can be entered; of a stateless automaton, whose states share it, the first."""
    level = subject.level
    found = [index for index in sorted(level.reachable_states) if level.leaves[index] is not None]
    return found[:1] if level.automaton.stateless else found


def _in_state(subject: Subject, index: int) -> str:
    return "" if subject.level.automaton.stateless else f"In {subject.level.automaton.states[index].name}, "


def find_cells_of_one_example(subject: Subject) -> Iterator[Finding]:
    """Find leaves on whose answer a single press-made example agrees, in trees that test something.

    Watched examples do not count, since they decide nothing, and neither do defaults that a directive outvotes.
    """
    level = subject.level
    if level.taught.lesson is None:
        return
    for index in _list_states(subject):
        state = level.automaton.states[index].name
        domain = _get_domain(subject, index)
        for leaf in level.leaves[index] or ():
            box = intersect(domain, leaf)
            if leaf.node == STAY or not leaf.tested or not box:
                continue
            answers = level.automaton.states[index if leaf.outcome == STAY else leaf.outcome].name
            agreeing = [
                each
                for each in subject.list_examples(state, leaf.node)
                if each.is_from_press and each.next == answers
            ]
            if len(agreeing) != 1:
                continue
            (example,) = agreeing
            does = (
                "stays"
                if leaf.outcome in (STAY, index)
                else f"goes to {level.automaton.states[leaf.outcome].name}"
            )
            cells = subject.make_cells([box], domain)
            yield Finding(
                FindingKind.ONE_EXAMPLE,
                Severity.NOTE,
                subject.label,
                _sentence(
                    subject,
                    index,
                    f"it {does} when {join_conditions(cells)}: only example {example.number} says so",
                ),
                (state,),
                cells=cells,
                examples=(example.number,),
                remedy=f"Show once more what to do{f' in {state}' if not level.automaton.stateless else ''} there.",
            )


def find_branches_never_shown(subject: Subject) -> Iterator[Finding]:
    """Find present values, such as a label, that reach no leaf, so that the state stays for want of examples."""
    level = subject.level
    for index in _list_states(subject):
        state = level.automaton.states[index].name
        boxes, domain = [], _get_domain(subject, index)
        for leaf in level.leaves[index] or ():
            box = intersect(domain, leaf)
            present = box & ~sum(axis.absence for axis in level.axes if axis.whole in leaf.tested)
            is_open = leaf.node == STAY and box and all(present & bits for bits in leaf.tested)
            if is_open and level.space.possibility.narrow(present):
                boxes.append(present)
        if not boxes:
            continue
        cells = subject.make_cells(boxes, domain)
        yield Finding(
            FindingKind.NEVER_SHOWN,
            Severity.WARNING,
            subject.label,
            _sentence(
                subject, index, f"it stays when {join_conditions(cells)} only because nothing was shown there"
            ),
            (state,),
            list_tie_sentences(subject),
            cells,
            remedy="Show what to do there.",
        )


def find_absence_never_shown(subject: Subject) -> Iterator[Finding]:
    """Find features whose absence no example of a state covers, one finding for each feature."""
    level = subject.level
    found: dict[int, list[tuple[int, int]]] = {}
    for index in _list_states(subject):
        domain = _get_domain(subject, index)
        for leaf in level.leaves[index] or ():
            if leaf.node != STAY:
                continue
            for position, axis in enumerate(level.axes):
                if not (isinstance(axis.bound.feature, Feature) and axis.whole in leaf.tested):
                    continue
                box = intersect((domain & ~axis.whole) | (domain & axis.absence), leaf)
                if box and box & axis.whole and level.space.possibility.narrow(box):
                    found.setdefault(position, []).append((index, box))
    for position, places in found.items():
        bound = level.axes[position].bound
        names = tuple(dict.fromkeys(level.automaton.states[index].name for index, _ in places))
        stays = "" if level.automaton.stateless else f" in {join_names(names)}"
        yield Finding(
            FindingKind.ABSENT_NEVER_SHOWN,
            Severity.NOTE,
            subject.label,
            f"While {bound} is absent, it stays{stays} only because no example there had it absent.",
            names,
            (ABSENT,),
            subject.make_cells([box for _, box in places]),
            remedy=f"Show what to do while {bound} is absent{stays}, if that can happen.",
        )


def _get_domain(subject: Subject, index: int) -> int:
    """Return the box of a state; of a stateless automaton, what any of its states can read."""
    level = subject.level
    if not level.automaton.stateless:
        return level.get_domain(index)
    box = 0
    for each in sorted(level.reachable_states):
        box |= level.get_domain(each)
    return box


def _sentence(subject: Subject, index: int, said: str) -> str:
    text = f"{_in_state(subject, index)}{said}."
    return text[0].upper() + text[1:]
