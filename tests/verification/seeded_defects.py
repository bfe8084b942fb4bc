"""Seeded defects: taught robots and coordinators with one defect each, and whether the check names it.

    python -m tests.verification.seeded_defects 2001 2061 [--write]

A seed decides which library gets which defect where. A defect counts as named if the check of the changed library has
a finding of the expected kind about the changed place that the check of the library before it has not.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import nan
from pathlib import Path
from types import MappingProxyType

from tests.verification.automata import list_unused

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.coordinators import SquadMembers
from understudy.addons.checks.verification.finding import Finding, FindingKind
from understudy.errors import UnderstudyError
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, FlagFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Categorical
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy.sim.team.assignment import assign_team_members
from understudy_lab.forage.teach import teach as teach_forager
from understudy_lab.patrol.practice import ROBOT, SQUAD, scenario
from understudy_lab.patrol.practice import teach as teach_patrol

CYCLES = (FindingKind.CHATTER, FindingKind.CYCLE, FindingKind.REPEATED_ORDER)


@dataclass(frozen=True)
class Taught:
    """A library, and the squad that its automata coordinate (None for robots)."""

    library: Library
    members: SquadMembers | None = None

    def check(self) -> list[Finding]:
        """The findings, without a scenario's ties."""
        return list(check_library(self.library, kit_known=True, members=self.members).findings)

    def with_automaton(self, taught: TrainedAutomaton) -> Taught:
        """The same with an automaton replaced."""
        return replace(self, library=self.library.with_automaton(taught))


@dataclass(frozen=True)
class Defect:
    """A changed automaton, and what a finding about the change must say.

    These are its kinds, its automaton, states, words of it, an example, and a feature that decides nothing.
    """

    what: str
    taught: TrainedAutomaton
    kinds: tuple[FindingKind, ...]
    automaton: str
    states: frozenset[str] = frozenset()
    word: str = ""
    examples: frozenset[int] = frozenset()
    unused: str = ""

    def is_named_by(self, finding: Finding) -> bool:
        """Whether a finding is about the defect."""
        return (
            finding.kind in self.kinds
            and finding.automaton == self.automaton
            and self.states <= set(finding.states)
            and self.word in finding.sentence
            and self.examples <= set(finding.examples)
            and (not self.unused or self.unused in list_unused(finding))
        )


Make = Callable[[Taught, random.Random], Iterator[Defect]]


def with_tree(taught: TrainedAutomaton, state: str, tree: Tree) -> TrainedAutomaton:
    """An automaton with another tree in one state; the lesson stays, as if the document had been edited."""
    transitions = MappingProxyType({**taught.automaton.transitions, state: tree})
    return replace(taught, automaton=replace(taught.automaton, transitions=transitions))


def map_outcomes(tree: Tree, outcomes: Mapping[int, int]) -> Tree:
    """A tree whose leaves answer other states."""
    return Tree(
        tuple(
            make_leaf(outcomes.get(node.yes, node.yes)) if node.test == TestKind.LEAF else node
            for node in tree.nodes
        )
    )


def automata_of(taught: Taught, rng: random.Random) -> list[TrainedAutomaton]:
    """The automata of a library in random order."""
    found = list(taught.library.taught.values())
    rng.shuffle(found)
    return found


def trees_of(automaton: Automaton, rng: random.Random) -> list[tuple[int, str, Tree]]:
    """The states with trees in random order: index, name, tree."""
    found = [
        (automaton.index(name), name, tree)
        for name, tree in automaton.transitions.items()
        if isinstance(tree, Tree)
    ]
    rng.shuffle(found)
    return found


def outcomes(tree: Tree) -> list[int]:
    return [node.yes for node in tree.nodes if node.test == TestKind.LEAF]


# Mutated trees


def never_entered(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    for each in automata_of(taught, rng):
        states = list(range(1, len(each.automaton.states)))
        rng.shuffle(states)
        for lost in states:
            changed = each
            for index, name, tree in trees_of(each.automaton, rng):
                changed = with_tree(changed, name, map_outcomes(tree, {lost: index}))
            name = each.automaton.states[lost].name
            yield Defect(
                f"no way to {name}",
                changed,
                (FindingKind.NEVER_ENTERED,),
                each.automaton.name,
                frozenset([name]),
            )


def never_left(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    for each in automata_of(taught, rng):
        for index, name, tree in trees_of(each.automaton, rng):
            changed = with_tree(each, name, map_outcomes(tree, dict.fromkeys(outcomes(tree), index)))
            yield Defect(
                f"no way out of {name}",
                changed,
                (FindingKind.NEVER_LEFT,),
                each.automaton.name,
                frozenset([name]),
            )


def chatter(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """One leaf of the state that follows leads straight back."""
    for each in automata_of(taught, rng):
        states = each.automaton.states
        for _, name, tree in trees_of(each.automaton, rng):
            for following in sorted(set(outcomes(tree))):
                back = each.automaton.transitions.get(states[following].name) if following >= 0 else None
                if following == each.automaton.index(name) or not isinstance(back, Tree):
                    continue
                other = states[following].name
                changed = with_tree(each, other, Tree((make_leaf(each.automaton.index(name)),)))
                if oscillates(taught.with_automaton(changed), each.automaton.name, (name, other), rng):
                    yield Defect(
                        f"{other} leads back to {name}",
                        changed,
                        CYCLES,
                        each.automaton.name,
                        frozenset([name, other]),
                    )


def swapped(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """The two answers of a state that stays or leaves are swapped, where the next state comes back on its own."""
    for each in automata_of(taught, rng):
        names = each.automaton.state_names
        for index, name, tree in trees_of(each.automaton, rng):
            for following in sorted(set(outcomes(tree)) - {index, STAY}):
                back = each.automaton.transitions.get(names[following])
                if isinstance(back, Tree) and index in outcomes(back):
                    changed = with_tree(each, name, map_outcomes(tree, {index: following, following: index}))
                    if oscillates(
                        taught.with_automaton(changed), each.automaton.name, (name, names[following]), rng
                    ):
                        yield Defect(
                            f"answers of {name} swapped",
                            changed,
                            CYCLES,
                            each.automaton.name,
                            frozenset([name, names[following]]),
                        )


ROWS, TICKS, PERIOD = 400, 60, 8


def oscillates(taught: Taught, name: str, states: tuple[str, str], rng: random.Random) -> bool:
    """Whether the interpreter, with random readings that stay as they are, keeps going between two states.

    It must enter both again and again, at least every `PERIOD` ticks, without waiting for a clock. Statistics of flags
    are at the value to which an order resets them.
    """
    library = taught.library
    targets = list(library.kit.targets)
    program = link(library, name, dict.fromkeys(library.automaton(name).parameters, targets[0]))
    choices = [reset_or_values(bound, library) for bound in program.features]
    for _ in range(ROWS):
        row = [rng.choice(values) for values in choices]
        agent = Interpreter(program)
        agent.root.switch(library.automaton(name).index(states[0]), 0.0)  # type: ignore[union-attr]
        path = []
        for tick in range(1, TICKS):
            agent.pulse(row, 0.1 * tick)
            path.append(agent.path[0])
        late = path[TICKS // 2 :]
        gaps = [len(list(group)) for _, group in groupby(late)]
        if set(states) <= set(late) and max(gaps) <= PERIOD:
            return True
    return False


def reset_or_values(bound: BoundFeature, library: Library) -> list[float]:
    """The values of a feature to try: beside every threshold of any tree, every label, and absence."""
    if isinstance(bound.feature, Feature) and bound.feature.fresh is not None:
        return [bound.feature.fresh]
    if isinstance(bound.kind, Categorical):
        return [float(label) for label in range(len(bound.kind.labels))]
    cuts = [
        cut
        for taught in library.taught.values()
        for tree in taught.automaton.transitions.values()
        for node in (tree.nodes if isinstance(tree, Tree) else ())
        if node.feature >= 0 and taught.automaton.features[node.feature].feature == bound.feature
        for cut in (node.low, node.high)
        if cut == cut
    ]
    return [value for cut in cuts or [0.0] for value in (cut - 1e-3, cut + 1e-3)] + [nan]


def unshown_branch(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """A branch of a label test, other than of a flag, is cut off."""
    for each in automata_of(taught, rng):
        for _, name, tree in trees_of(each.automaton, rng):
            for at, node in enumerate(tree.nodes):
                feature = each.automaton.features[node.feature].feature if node.feature >= 0 else None
                if node.test != TestKind.LABEL or isinstance(feature, FlagFeature):
                    continue
                lost = rng.randrange(len(node.branches))
                branches = tuple(
                    STAY if place == lost else child for place, child in enumerate(node.branches)
                )
                nodes = (*tree.nodes[:at], node._replace(branches=branches), *tree.nodes[at + 1 :])
                bound = each.automaton.features[node.feature]
                yield Defect(
                    f"a branch of {bound} in {name} cut off",
                    with_tree(each, name, Tree(nodes)),
                    (FindingKind.NEVER_SHOWN,),
                    each.automaton.name,
                    frozenset([name]),
                    str(bound),
                )


def unused_feature(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """All tests of a feature are replaced by one of their sides."""
    for each in automata_of(taught, rng):
        features = list(range(len(each.automaton.features)))
        rng.shuffle(features)
        for feature in features:
            changed = each
            for _, name, tree in trees_of(each.automaton, rng):
                changed = with_tree(changed, name, without_tests(tree, feature))
            bound = str(each.automaton.features[feature])
            yield Defect(
                f"tests of {bound} removed",
                changed,
                (FindingKind.UNUSED_FEATURE,),
                each.automaton.name,
                unused=bound,
            )


def without_tests(tree: Tree, feature: int) -> Tree:
    """A tree that goes one way wherever it tested a feature."""
    nodes: list[Node] = []

    def copy(index: int) -> int:
        if index == STAY:
            return STAY
        node = tree.nodes[index]
        if node.test != TestKind.LEAF and node.feature == feature:
            sides = [each for each in (*node.branches, node.no, node.yes) if each != STAY]
            return copy(sides[0])
        at = len(nodes)
        nodes.append(node)
        if node.test != TestKind.LEAF:
            absent = {
                each: copy(each) for each in dict.fromkeys((node.yes, node.no, *node.branches, node.absent))
            }
            nodes[at] = node._replace(
                yes=absent[node.yes],
                no=absent[node.no],
                absent=absent[node.absent],
                branches=tuple(absent[each] for each in node.branches),
            )
        return at

    copy(0)
    return Tree(tuple(nodes))


# Missing flags


def missing_flag(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """An automaton no longer enters the state that raises a flag for which another automaton waits."""
    for user in automata_of(taught, rng):
        for index, _, tree in trees_of(user.automaton, rng):
            runs = taught.library.taught.get(user.automaton.states[index].behavior or "")
            tested = {
                user.automaton.features[node.feature].feature for node in tree.nodes if node.feature >= 0
            }
            for feature in tested if runs is not None else ():
                if not isinstance(feature, FlagFeature) or feature.name not in runs.automaton.flags:  # type: ignore[union-attr]
                    continue
                changed = runs
                for lost, state in enumerate(runs.automaton.states):  # type: ignore[union-attr]
                    if state.flag == feature.name:
                        for at, other, its in trees_of(changed.automaton, rng):  # type: ignore[union-attr]
                            changed = with_tree(changed, other, map_outcomes(its, {lost: at}))  # type: ignore[arg-type]
                yield Defect(
                    f"{changed.automaton.name} never raises {feature.name}",  # type: ignore[union-attr]
                    changed,  # type: ignore[arg-type]
                    (FindingKind.FLAG_NEVER_RAISED,),
                    user.automaton.name,
                    word=feature.name,
                )


# Removed examples


def removed_examples(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """Of the examples of one switch all but one are removed, and the automaton is learned again."""
    for each in automata_of(taught, rng):
        lesson = each.lesson
        if lesson is None:
            continue
        switches = sorted(
            {(one.state, one.next) for one in lesson.examples if one.state != one.next and one.is_shown}
        )
        rng.shuffle(switches)
        for state, following in switches:
            those = [one for one in lesson.examples if (one.state, one.next) == (state, following)]
            kept = rng.choice([one for one in those if one.is_shown])
            rest = tuple(one for one in lesson.examples if one not in those or one is kept)
            less = replace(lesson, examples=rest)
            automaton = learn_automaton(less)
            tree = automaton.transitions.get(state)
            if (
                not isinstance(tree, Tree)
                or tree.decide(kept.values) != automaton.index(following)
                or not tree.depth
            ):
                continue
            yield Defect(
                f"one example of {state} to {following} left",
                TrainedAutomaton(automaton, less),
                (FindingKind.ONE_EXAMPLE,),
                each.automaton.name,
                frozenset([state]),
                examples=frozenset([kept.number]),
            )


def unshown_absence(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """Absence of a reading loses its examples: nodes that test it keep only the side of present values."""
    for each in automata_of(taught, rng):
        for _, name, tree in trees_of(each.automaton, rng):
            for feature in sorted({node.feature for node in tree.nodes if node.test == TestKind.BELOW}):
                nodes = tuple(
                    node._replace(absent=STAY)
                    if node.feature == feature and node.test == TestKind.BELOW
                    else node
                    for node in tree.nodes
                )
                if nodes == tree.nodes or any(
                    node.test == TestKind.ABSENT and node.feature == feature for node in tree.nodes
                ):
                    continue
                bound = str(each.automaton.features[feature])
                yield Defect(
                    f"absence of {bound} in {name} without examples",
                    with_tree(each, name, Tree(nodes)),
                    (FindingKind.ABSENT_NEVER_SHOWN,),
                    each.automaton.name,
                    frozenset([name]),
                    bound,
                )


# Wrong parameters


def wrong_parameter(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """An automaton asks about a fixed target wherever it should ask about its parameter."""
    targets = list(taught.library.kit.targets)
    for each in automata_of(taught, rng):
        for parameter in each.automaton.parameters:
            other = rng.choice(targets)

            def bind(binding: Mapping[str, str], parameter: str = parameter, other: str = other) -> Binding:
                return Binding({key: other if name == parameter else name for key, name in binding.items()})

            features = tuple(BoundFeature(one.feature, bind(one.binding)) for one in each.automaton.features)
            states = tuple(replace(state, binding=bind(state.binding)) for state in each.automaton.states)
            if len(set(features)) == len(features):
                yield Defect(
                    f"{other} instead of {parameter}",
                    TrainedAutomaton(replace(each.automaton, features=features, states=states)),
                    (FindingKind.UNUSED_PARAMETER,),
                    each.automaton.name,
                    word=f"Parameter {parameter} ",
                )


def unknown_order(taught: Taught, rng: random.Random) -> Iterator[Defect]:
    """A state runs, or orders, what is nowhere."""
    for each in automata_of(taught, rng):
        busy = [index for index, state in enumerate(each.automaton.states) if state.behavior is not None]
        index = rng.choice(busy)
        state = replace(each.automaton.states[index], behavior="vanish", binding=Binding())
        states = (*each.automaton.states[:index], state, *each.automaton.states[index + 1 :])
        yield Defect(
            f"{state.name} runs what is nowhere",
            TrainedAutomaton(replace(each.automaton, states=states)),
            (FindingKind.MISSING_BEHAVIOR,),
            each.automaton.name,
            frozenset([state.name]),
        )


ROBOT_DEFECTS: Sequence[Make] = (
    never_entered,
    never_left,
    chatter,
    swapped,
    missing_flag,
    unshown_branch,
    unused_feature,
    removed_examples,
    unshown_absence,
    wrong_parameter,
    unknown_order,
)
COORDINATOR_DEFECTS: Sequence[Make] = (
    never_entered,
    never_left,
    chatter,
    swapped,
    unused_feature,
    removed_examples,
    unknown_order,
)


@dataclass(frozen=True)
class Trial:
    """One seeded defect: where, what, and the finding that names it (None: missed)."""

    seed: int
    where: str
    sort: str
    what: str
    finding: Finding | None


def run_trial(seed: int, robots: Sequence[Taught], coordinators: Sequence[Taught]) -> Trial:
    """Make the defect of a seed, the first possible one in an order that the seed draws, and check for it."""
    rng = random.Random(seed)
    of_team = rng.random() < 0.3
    taught = rng.choice(coordinators if of_team else robots)
    before = taught.check()
    sorts = list(COORDINATOR_DEFECTS if of_team else ROBOT_DEFECTS)
    rng.shuffle(sorts)
    for make in sorts:
        for defect in make(taught, rng):
            if any(defect.is_named_by(each) for each in before):
                continue  # it is there already
            try:
                changed = taught.with_automaton(defect.taught)
            except UnderstudyError:
                continue
            found = next((each for each in changed.check() if defect.is_named_by(each)), None)
            where = f"{'coordinator ' if of_team else ''}{defect.automaton}"
            return Trial(seed, where, make.__name__.replace("_", " "), defect.what, found)
    raise AssertionError(f"no defect fits the library of seed {seed}")


def teach_all() -> tuple[list[Taught], list[Taught]]:
    """Teach two foragers and a patrol, which get the defects."""
    robots = [Taught(teach_forager(seed).library) for seed in (901, 902)]
    patrol = teach_patrol(903).libraries
    robots.append(Taught(patrol[ROBOT]))
    (squad, _), *_ = assign_team_members(scenario()).squads
    members = SquadMembers(squad, {role.name: patrol[ROBOT] for role in squad.roles})
    return robots, [Taught(patrol[SQUAD], members)]


PAGE = Path(__file__).parents[2] / "docs" / "checking.md"
BEGIN, END = "<!-- seeded defects: generated -->\n", "<!-- end of seeded defects -->\n"


def format_table(trials: Sequence[Trial]) -> str:
    """The trials as a table in Markdown, with their number before it."""
    found = sum(each.finding is not None for each in trials)
    rows = [f"{found} of {len(trials)} defects are named.", "", "| seed | where | defect | named |"]
    rows.append("|---|---|---|---|")
    for each in trials:
        named = "**missed**" if each.finding is None else f"{each.finding.severity}: {each.finding.kind}"
        rows.append(f"| {each.seed} | {each.where} | {each.sort}: {each.what} | {named} |")
    return "\n".join([*rows, ""])


def main(first: int, end: int, *, write: bool) -> None:
    """Print a table of the defects of a range of seeds, or write it into the page on checking."""
    robots, coordinators = teach_all()
    table = format_table([run_trial(seed, robots, coordinators) for seed in range(first, end)])
    if not write:
        sys.stdout.write(table)
        return
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), write="--write" in sys.argv)
