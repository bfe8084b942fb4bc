"""Confirm findings without the check's own means: by all values beside thresholds, by the lesson, or by a run.

The trees are asked with every combination of a value from each interval between two thresholds, every label and
absence. Cycles are run by the interpreter. Nothing of `understudy.addons.checks.verification` takes part but the
finding itself.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import isnan, nan

from tests.verification.automata import list_unused

from understudy.addons.checks.verification.coordinators import SquadMembers
from understudy.addons.checks.verification.finding import Finding, FindingCell, FindingKind
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, CounterFeature, Feature, FlagFeature, TimeInState
from understudy.model.library import Library
from understudy.model.tree import STAY, TestKind, Tree
from understudy.model.value_kinds import NO, YES, Categorical, Toroidal
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import Program, link

MOST_VECTORS = 300_000
"""So many feature vectors are tried for one tree; of more, so many are drawn at random."""
TICKS, RUNS = 400, 40

Vector = tuple[float, ...]


@dataclass
class Judge:
    """What a library's automata can do, by trial.

    `members` is the squad that the automata coordinate; None for robots.
    """

    library: Library
    members: SquadMembers | None = None
    _raised: dict[str, frozenset[str]] = field(default_factory=dict)
    _ways: dict[str, dict[int, set[int]]] = field(default_factory=dict)

    def confirm(self, finding: Finding) -> str:
        """Return how a finding was confirmed; an empty string if it was not."""
        name = finding.automaton.rpartition("/")[2]
        automaton = self.library.automaton(name)
        by_kind = {
            FindingKind.NEVER_ENTERED: self._is_never_entered,
            FindingKind.NEVER_LEFT: self._is_never_left,
            FindingKind.FLAG_NEVER_RAISED: self._is_never_raised,
            FindingKind.CHATTER: self._cycles,
            FindingKind.CYCLE: self._cycles,
            FindingKind.REPEATED_ORDER: self._cycles,
            FindingKind.NEVER_SHOWN: self._is_never_shown,
            FindingKind.ABSENT_NEVER_SHOWN: self._is_never_shown,
            FindingKind.ONE_EXAMPLE: self._rests_on_one,
            FindingKind.DEAD_END: self._waits,
            FindingKind.OUTLIER: self._lies_outside,
            FindingKind.UNUSED_FEATURE: self._decides_nothing,
            FindingKind.UNUSED_PARAMETER: self._makes_no_difference,
        }
        if finding.kind in (FindingKind.MISSING_BEHAVIOR, FindingKind.CONSTANT_TARGET):
            return "by the library"
        return by_kind[finding.kind](finding, automaton)

    # All values

    def list_ways(self, name: str) -> dict[int, set[int]]:
        """By state, the states that some feature vector leads to."""
        if name not in self._ways:
            automaton = self.library.automaton(name)
            self._ways[name] = {}
            for index, state in enumerate(automaton.states):
                tree = automaton.transitions.get(state.name)
                vectors = () if tree is None else self.list_vectors(automaton, index, tree)  # type: ignore[arg-type]
                found = {tree.decide(vector) for vector in vectors} if tree is not None else set()
                self._ways[name][index] = {index if each == STAY else each for each in found}
        return self._ways[name]

    def list_entered(self, name: str) -> set[int]:
        """The states that some series of feature vectors leads to."""
        found, waiting = {0}, [0]
        while waiting:
            new = self.list_ways(name)[waiting.pop()] - found
            found |= new
            waiting += new
        return found

    def list_raised(self, name: str) -> frozenset[str]:
        """The flags that an automaton can raise."""
        if name not in self._raised:
            states = self.library.automaton(name).states
            flags = (states[index].flag for index in self.list_entered(name))
            self._raised[name] = frozenset(flag for flag in flags if flag is not None)
        return self._raised[name]

    def list_choices(
        self, automaton: Automaton, state: int, bound: BoundFeature, trees: list[Tree]
    ) -> Vector:
        """A value of a feature in each part that thresholds of the trees divide, and absence."""
        feature, index = bound.feature, automaton.features.index(bound)
        if isinstance(feature, FlagFeature):
            runs = automaton.states[state].behavior or ""
            can = runs in self.library.taught and feature.name in self.list_raised(runs)
            return (NO, YES) if can else (NO,)
        if isinstance(feature, Feature) and self._stands_still(automaton, state, feature):
            return (feature.fresh,)  # type: ignore[return-value]
        if isinstance(bound.kind, Categorical):
            return (*(float(label) for label in range(len(bound.kind.labels))), nan)
        cuts = sorted(
            {
                cut
                for tree in trees
                for node in tree.nodes
                if node.feature == index and node.test in (TestKind.BELOW, TestKind.ARC)
                for cut in (node.low, node.high)
                if not isnan(cut)
            }
        )
        least = [0.0] if isinstance(bound.kind, Toroidal) else [cuts[0] - 1.0] if cuts else [0.0]
        if isinstance(feature, TimeInState):
            least = [0.0]
        absent = () if isinstance(feature, CounterFeature | TimeInState) else (nan,)
        return (*least, *cuts, *absent)

    def _stands_still(self, automaton: Automaton, state: int, feature: Feature) -> bool:
        """Whether no member that a state gives an order to can raise the flag of a statistic."""
        if self.members is None or feature.fresh is None:
            return False
        runs = automaton.states[state].behavior or ""
        if runs in self.library.taught:
            return False
        statistic = next(each for each in self.members.squad.statistics if each.name == feature.reading)
        order = self.library.kit.behaviors[runs].order if runs in self.library.kit.behaviors else None
        raising = [
            duty
            for duty in (() if order is None else order.duties)
            for role, library in self.members.libraries.items()
            if duty.role in (None, role) and statistic.role in (None, role)
            if duty.behavior in library.taught and statistic.flag in Judge(library).list_raised(duty.behavior)
        ]
        return not raising

    def list_vectors(self, automaton: Automaton, state: int, *trees: Tree) -> Iterator[Vector]:
        """Feature vectors that reach every part of the trees of a state; features that no tree tests are 0."""
        tested = {node.feature for tree in trees for node in tree.nodes if node.feature >= 0}
        choices = [
            self.list_choices(automaton, state, bound, list(trees)) if index in tested else (0.0,)
            for index, bound in enumerate(automaton.features)
        ]
        count = 1
        for each in choices:
            count *= len(each)
        if count <= MOST_VECTORS:
            yield from product(*choices)
            return
        rng = random.Random(0)
        for _ in range(MOST_VECTORS):
            yield tuple(rng.choice(each) for each in choices)

    def _is_never_entered(self, finding: Finding, automaton: Automaton) -> str:
        (state,) = finding.states
        never = automaton.index(state) not in self.list_entered(automaton.name)
        return "all values" if never else ""

    def _is_never_left(self, finding: Finding, automaton: Automaton) -> str:
        index = automaton.index(finding.states[0])
        never = self.list_ways(automaton.name)[index] <= {index}
        return "all values" if never else ""

    def _is_never_raised(self, finding: Finding, automaton: Automaton) -> str:
        index = automaton.index(finding.states[0])
        tree = automaton.transitions[finding.states[0]]
        for bound in automaton.features:
            if f" waits for {bound} to go to " in finding.sentence and isinstance(tree, Tree):
                return "all values" if len(self.list_choices(automaton, index, bound, [tree])) == 1 else ""
        return ""

    def _decides_nothing(self, finding: Finding, automaton: Automaton) -> str:
        names = list_unused(finding)
        unused = [index for index, bound in enumerate(automaton.features) if str(bound) in names]
        vain = len(unused) == len(names) and all(self._is_vain(automaton, index) for index in unused)
        return "all values" if vain else ""

    def _is_vain(self, automaton: Automaton, index: int) -> bool:
        for state in self.list_entered(automaton.name):
            tree = automaton.transitions.get(automaton.states[state].name)
            if not isinstance(tree, Tree):
                continue
            answers: dict[Vector, set[int]] = {}
            for vector in self.list_vectors(automaton, state, tree):
                rest = tuple(-1e9 if isnan(each) else each for each in vector)
                rest = (*rest[:index], *rest[index + 1 :])
                answer = tree.decide(vector)
                answers.setdefault(rest, set()).add(state if answer == STAY else answer)
            if any(len(each) > 1 for each in answers.values()):
                return False
        return True

    # The lesson

    def _is_never_shown(self, finding: Finding, automaton: Automaton) -> str:
        """Whether each cell reaches, in some state of the finding, a place that no example reaches."""
        for cell in finding.cells:
            if not any(self._reaches_nothing(automaton, state, cell) for state in finding.states):
                return ""
        return "all values" if finding.cells else ""

    def _reaches_nothing(self, automaton: Automaton, state: str, cell: FindingCell) -> bool:
        tree = automaton.transitions[state]
        known = dict(zip(cell.features, cell.at, strict=True))
        lesson = self.library.taught[automaton.name].lesson
        for vector in self.list_vectors(automaton, automaton.index(state), tree):  # type: ignore[arg-type]
            values = [
                known.get(bound, value) for bound, value in zip(automaton.features, vector, strict=True)
            ]
            if tree.path(values)[1] == STAY:
                examples = () if lesson is None else lesson.examples
                return all(
                    tree.path(each.values)[1] != STAY
                    for each in examples
                    if each.state == state and not each.quarantined
                )
        return False

    def _rests_on_one(self, finding: Finding, automaton: Automaton) -> str:
        pairs = zip(finding.states, finding.examples, strict=True)
        alone = all(self._is_alone(automaton, state, number) for state, number in pairs)
        return "the lesson" if alone else ""

    def _is_alone(self, automaton: Automaton, state: str, number: int) -> bool:
        lesson = self.library.taught[automaton.name].lesson
        tree = automaton.transitions[state]
        assert lesson is not None
        (one,) = (each for each in lesson.examples if each.number == number)
        answer = tree.decide(one.values)
        states = [state] if not automaton.stateless else list(automaton.transitions)
        agreeing = [
            each
            for each in lesson.examples
            if each.state in states and each.is_from_press and not each.quarantined
            if tree.path(each.values)[1] == tree.path(one.values)[1]
            if each.next == (each.state if answer == STAY else automaton.states[answer].name)
        ]
        return agreeing == [one]

    def _lies_outside(self, finding: Finding, automaton: Automaton) -> str:
        """Whether some number of the example is farther from all others than those are from each other."""
        lesson = self.library.taught[automaton.name].lesson
        assert lesson is not None
        used = [each for each in lesson.examples if not each.quarantined]
        for index in range(len(automaton.features)):
            mine = {each.values[index] for each in used if each.number in finding.examples}
            others = {each.values[index] for each in used if each.number not in finding.examples}
            known = [each for each in others if not isnan(each)]
            if len(mine) == 1 and len(known) >= 10:
                gap = min(abs(each - value) for value in mine for each in known)
                if gap > max(known) - min(known):
                    return "the lesson"
        return ""

    # Runs

    def _cycles(self, finding: Finding, automaton: Automaton) -> str:
        """Whether the interpreter, with readings of each cell held, comes back to the first state again and again."""
        if any("raise the flags" in each for each in finding.assumptions):
            return self._repeats(finding, automaton)
        rng = random.Random(0)
        program, targets = self.link_freely(automaton)
        for cell in finding.cells or (FindingCell((), (), (), "always"),):
            if not any(self._comes_back(finding, cell, program, targets, rng) for _ in range(RUNS)):
                return ""
        return "a run"

    def link_freely(self, automaton: Automaton) -> tuple[Program, Mapping[str, str]]:
        """Link an automaton with a target for each parameter, different ones as far as there are any."""
        used = {name for bound in automaton.features for name in bound.binding.values()}
        free = [name for name in self.library.kit.targets if name not in used] or list(
            self.library.kit.targets
        )
        targets = {name: free[at % len(free)] for at, name in enumerate(automaton.parameters)}
        return link(self.library, automaton.name, targets), targets

    def make_row(
        self, program: Program, known: Mapping[BoundFeature, float], rng: random.Random
    ) -> list[float]:
        """The values that are known, and random values beside thresholds for others."""
        cuts: dict[str, list[float]] = {}
        for taught in self.library.taught.values():
            for tree in taught.automaton.transitions.values():
                for node in tree.nodes if isinstance(tree, Tree) else ():
                    if node.feature >= 0:
                        name = taught.automaton.features[node.feature].feature.name
                        cuts.setdefault(name, []).extend(
                            cut + beside
                            for cut in (node.low, node.high)
                            for beside in (-1e-3, 1e-3)
                            if not isnan(cut)
                        )
        row = []
        for bound in program.features:
            fresh = bound.feature.fresh if isinstance(bound.feature, Feature) else None
            if fresh is not None:
                row.append(fresh)
            elif bound in known:
                row.append(known[bound])
            elif isinstance(bound.kind, Categorical):
                row.append(float(rng.randrange(len(bound.kind.labels))))
            else:
                row.append(rng.choice([*cuts.get(bound.feature.name, [0.0]), nan]))
        return row

    def _comes_back(
        self,
        finding: Finding,
        cell: FindingCell,
        program: Program,
        targets: Mapping[str, str],
        rng: random.Random,
    ) -> bool:
        row = self.make_row(program, bind_cell(cell, targets), rng)
        agent = Interpreter(program)
        agent.root.switch(program.root.automaton.index(finding.states[0]), 0.0)  # type: ignore[union-attr]
        path = []
        for tick in range(1, TICKS):
            agent.pulse(row, 0.1 * tick)
            path.append(agent.path[0])
        late = path[TICKS // 2 :]
        switches = [one for at, one in enumerate(late) if at == 0 or late[at - 1] != one]
        first = finding.states[0]
        if first not in switches[: len(finding.states) + 1]:
            return False
        begun = switches[switches.index(first) :]
        expected = [*finding.states] * (len(begun) // len(finding.states) + 1)
        if len(set(finding.states)) == 1:
            return set(late) == {first}
        return len(begun) >= 2 * len(finding.states) and begun == expected[: len(begun)]

    def _waits(self, finding: Finding, automaton: Automaton) -> str:
        """Whether, with readings of each cell held, what the state runs raises its flag, and the state stays."""
        rng = random.Random(0)
        program, targets = self.link_freely(automaton)
        index = automaton.index(finding.states[0])
        below = self.library.automaton(automaton.states[index].behavior or "")
        starts = [at for at, state in enumerate(below.states) if state.flag is None]
        for cell in finding.cells or (FindingCell((), (), (), "always"),):
            known = bind_cell(cell, targets)
            rows = (self.make_row(program, known, rng) for _ in range(RUNS))
            if not any(self._stays(program, index, at, row) for row in rows for at in starts):
                return ""
        return "a run"

    def _stays(self, program: Program, index: int, at: int, row: list[float]) -> bool:
        agent = Interpreter(program)
        agent.root.switch(index, 0.0)  # type: ignore[union-attr]
        agent.active[1].switch(at, 0.0)
        if at == 0:  # as in the tick in which the state is entered
            agent.active[1].pulse(row, 0.0)
        for tick in range(1, TICKS):
            agent.pulse(row, 0.1 * tick)
            if agent.active[0].state != index:
                return False
        return len(agent.active) > 1 and agent.active[1].flag is not None

    def _repeats(self, finding: Finding, automaton: Automaton) -> str:
        """Whether some flags of members lead from each state to the next, in every cell."""
        following = [*finding.states[1:], finding.states[0]]
        for cell in finding.cells or (FindingCell((), (), (), "always"),):
            known = {
                bound: value
                for bound, value in zip(cell.features, cell.at, strict=True)
                if isinstance(bound.feature, Feature) and bound.feature.fresh is None
            }
            for name, then in zip(finding.states, following, strict=True):
                tree, index = automaton.transitions[name], automaton.index(name)
                answers = {
                    tree.decide(
                        [
                            known.get(bound, value)
                            for bound, value in zip(automaton.features, vector, strict=True)
                        ]
                    )
                    for vector in self.list_vectors(automaton, index, tree)  # type: ignore[arg-type]
                }
                if automaton.index(then) not in answers:
                    return ""
        return "all values"

    def _makes_no_difference(self, finding: Finding, automaton: Automaton) -> str:
        """Whether other readings of a parameter's target change no state, and no basic behavior is bound to it."""
        parameter = finding.sentence.split()[1]
        program, targets = self.link_freely(automaton)
        rng = random.Random(0)
        mine = [
            bound
            for bound in automaton.features
            if parameter in bound.binding.values() and isinstance(bound.feature, Feature)
        ]
        there = {
            program.features.index(BoundFeature(bound.feature, bound.binding.substitute(Binding(targets))))
            for bound in mine
        }
        for _ in range(RUNS):
            agents, paths = (Interpreter(program), Interpreter(program)), ([], [])  # type: ignore[var-annotated]
            for tick in range(1, 60):
                row, other = self.make_row(program, {}, rng), self.make_row(program, {}, rng)
                changed = [other[at] if at in there else value for at, value in enumerate(row)]
                for agent, path, values in zip(agents, paths, (row, changed), strict=True):
                    agent.pulse(values, 0.1 * tick)
                    path.append(agent.path)
            if paths[0] != paths[1]:
                return ""
        passed = any(parameter in state.binding.values() for state in automaton.states)
        return "" if passed and not self._is_unused_below(automaton, parameter) else "runs"

    def _is_unused_below(self, automaton: Automaton, parameter: str) -> bool:
        """Whether all that states pass a parameter to are automata, which is as far as runs tell."""
        return all(
            state.behavior in self.library.taught
            for state in automaton.states
            if parameter in state.binding.values()
        )


def bind_cell(cell: FindingCell, targets: Mapping[str, str]) -> dict[BoundFeature, float]:
    """The body readings that represent a cell, with the targets of parameters."""
    return {
        BoundFeature(bound.feature, bound.binding.substitute(Binding(targets))): value
        for bound, value in zip(cell.features, cell.at, strict=True)
        if isinstance(bound.feature, Feature)
    }


def confirm_all(
    library: Library, findings: Sequence[Finding], members: SquadMembers | None = None
) -> Iterator[tuple[Finding, str]]:
    """Yield each finding of a library with how it was confirmed; an empty string if it was not."""
    judge = Judge(library, members)
    for finding in findings:
        yield finding, judge.confirm(finding)
