"""The XML of an export to BehaviorTree.CPP: a tree for each automaton, which decides and then runs its state.

Scripts of BehaviorTree.CPP 4.8 answer yes to every comparison with NaN. So questions about values that can be absent
are condition nodes, and scripts are left those about states, labels, counters and the time in a state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import copysign, isinf
from xml.etree.ElementTree import Element, SubElement

from understudy.addons.export.condition_text import C_WORDS, Operand, Spelling, write_condition
from understudy.addons.export.decisions import (
    Answer,
    Branch,
    Continuation,
    Step,
    TreeRoutines,
    ValueCondition,
)
from understudy.addons.export.export_size import MOST_NESTED, MOST_RULES, measure_hierarchy, refuse_size
from understudy.addons.export.hierarchy import FeatureSource, Hierarchy
from understudy.addons.export.targets.cpp_names import TreeNames, is_measured
from understudy.model.tree import STAY
from understudy.model.value_kinds import Categorical

ABSENT = "0.0 / 0.0"
"""NaN, as a script can write it."""
MOST_CASES = 6
"""The largest number of cases of the Switch nodes of BehaviorTree.CPP."""
LARGEST = 1.7976931348623157e308
NODE_TYPES = {"below": "IsBelow", "from": "IsAtLeast", "inside": "IsInArc", "across": "IsInArc"}
NODE_TYPES |= {"outside": "IsOffArc", "between": "IsOffArc"}
"""The condition nodes that ask a question about a value that can be absent."""


def write_script_real(value: float) -> str:
    """Write a number as scripts read it; they have no infinite one."""
    text = repr(copysign(LARGEST, value) if isinf(value) else float(value))
    return text if "." in text else text.replace("e", ".0e")


WHAT = "a behavior tree"


def check_tree_size(hierarchy: Hierarchy) -> None:
    """Refuse a hierarchy of which the behavior tree would be too large, with DefinitionError.

    A file holds each tree once, but a program that loads it makes nodes of every use.
    """
    size = measure_hierarchy(hierarchy, lambda number, state, condition: 1)
    if size.rules > MOST_RULES:
        each = "since every use of an automaton, and the tree of every state in it, becomes nodes of its own"
        raise refuse_size(hierarchy.name, WHAT, f"{size.rules} ends of decisions, {each}", str(MOST_RULES))
    if size.nested > MOST_NESTED:
        has = f"{size.nested} questions in one another, such as those for each label of a reading"
        raise refuse_size(hierarchy.name, WHAT, has, str(MOST_NESTED))


SPELLING = Spelling(*C_WORDS[:3], "true", "false", write_script_real, str, str)


@dataclass(frozen=True, slots=True)
class StateTree:
    """A decision of an automaton, by its index, and the name of its tree."""

    number: int
    decision: TreeRoutines
    called: str


class TreeWriter:
    """A writer of the trees of an export."""

    def __init__(self, hierarchy: Hierarchy, names: TreeNames) -> None:
        self.hierarchy, self.names = hierarchy, names
        self.root = Element("root", BTCPP_format="4", main_tree_to_execute=f"{names.c.prefix}_main")

    def write(self) -> Element:
        """Write the trees: the one to execute first, then those of automata from the root down."""
        hierarchy, names = self.hierarchy, self.names
        begin = SubElement(self._tree(f"{names.c.prefix}_main"), "Sequence", name=clean(hierarchy.name))
        # Scripts read both sides of a question, so that the state of every automaton must be known from the start.
        code = [line for number in reversed(range(len(hierarchy.automata))) for line in self.start(number)]
        SubElement(begin, "Script", name="start", code="; ".join(code))
        every = begin
        if names.nodes:
            every = SubElement(begin, "ReactiveSequence", name="every tick")
            every.extend(self._compute(index, node) for index, node in names.nodes.items())
        every.append(self._subtree(names.c.automata[hierarchy.automata[hierarchy.root.index].name]))
        for number in reversed(range(len(hierarchy.automata))):
            self._automaton(number)
        return self.root

    def _tree(self, called: str) -> Element:
        return SubElement(self.root, "BehaviorTree", ID=called)

    @staticmethod
    def _subtree(called: str, name: str = "") -> Element:
        named = {"name": clean(name)} if name else {}
        return Element("SubTree", {"ID": called, "_autoremap": "true", **named})

    def _compute(self, index: int, node: str) -> Element:
        value = self.hierarchy.computed[index]
        ports = {"name": clean(value.name), **self._read(value.slots)}
        return Element(node, {**ports, "value": f"{{{self.names.computed[index]}}}"})

    def _read(self, slots: Sequence[int]) -> dict[str, str]:
        """Write ports that take in readings."""
        keys = [self.names.c.readings[str(self.hierarchy.readings[slot])] for slot in slots]
        return {key: f"{{{key}}}" for key in keys}

    # Automata

    def _automaton(self, number: int) -> None:
        automaton = self.hierarchy.automata[number]
        called = self.names.c.automata[automaton.name]
        both = SubElement(self._tree(called), "ReactiveSequence", name=clean(automaton.name))
        decide: dict[int, Element] = {}
        for each in automaton.decisions:
            tree = StateTree(number, each, f"{called}_in_{self.names.state(automaton, each.states[0])}")
            decide |= self._decide(tree)
        stay = Element("AlwaysSuccess", name="stay")
        both.append(self.switch(number, "decide", sorted(decide.items()), stay))
        run = [(index, self._run(number, index)) for index in range(len(automaton.states))]
        both.append(
            run[0][1]
            if len(run) == 1
            else self.switch(number, "run", run, Element("AlwaysFailure", name="unknown state"))
        )

    def switch(self, number: int, name: str, cases: Sequence[tuple[int, Element]], rest: Element) -> Element:
        """Write a choice by the state of an automaton; `rest` is for all states without a case."""
        automaton, key = self.hierarchy.automata[number], self.names.memory[number, "state", 0]
        if not cases:
            return rest
        if len(cases) == 1:
            state, child = cases[0]
            condition, described = self._is_in(number, state), clean(automaton.states[state].name)
            choice = Element("IfThenElse", name=name)
            SubElement(choice, "ScriptCondition", name=described, code=condition)
            choice.extend((child, rest))
            return choice
        if len(cases) > MOST_CASES:
            # The last switch needs two cases: an IfThenElse keeps to a running child.
            first = MOST_CASES - (len(cases) == MOST_CASES + 1)
            rest, cases = self.switch(number, name, cases[first:], rest), cases[:first]
        ports = {f"case_{at}": self.names.state(automaton, state) for at, (state, _) in enumerate(cases, 1)}
        choice = Element(f"Switch{len(cases)}", {"name": name, "variable": f"{{{key}}}", **ports})
        choice.extend((*(child for _, child in cases), rest))
        return choice

    def _run(self, number: int, index: int) -> Element:
        hierarchy = self.hierarchy
        child = hierarchy.automata[number].states[index].child
        if child.is_automaton:
            below = hierarchy.automata[child.index]
            return self._subtree(self.names.c.automata[below.name], below.name)
        basic = hierarchy.basics[child.index]
        ports: dict[str, str] = {}
        if hierarchy.is_coordinator:
            order = child.index if basic.order is not None else 0
            ports = {"order": str(order), "since": self._key(number, "entered"), "now": "{now}"}
        elif basic.is_function:
            ports = self._read(basic.slots)
        else:
            ports = {
                self.names.c.channels[channel.name]: repr(
                    float(basic.command.get(channel.name, channel.rest))
                )
                for channel in hierarchy.channels
            }
        return Element(self.names.c.basics[basic.name], {"name": clean(basic.name), **ports})

    def _key(self, number: int, sort: str, index: int = 0) -> str:
        return f"{{{self.names.memory[number, sort, index]}}}"

    # Scripts

    def start(self, number: int) -> list[str]:
        """Write what starts an automaton, as statements of a script."""
        automaton, memory = self.hierarchy.automata[number], self.names.memory
        return [
            f"{memory[number, 'state', 0]} := '{self.names.state(automaton, 0)}'",
            f"{memory[number, 'entered', 0]} := now",
            *(f"{memory[number, 'counter', index]} := 0.0" for index in range(len(automaton.counters))),
            *(f"{memory[number, 'timer', index]} := {ABSENT}" for index in range(len(automaton.timers))),
        ]

    def enter(self, number: int, index: int) -> list[str]:
        """Write what enters a state of an automaton, as statements of a script."""
        automaton, memory = self.hierarchy.automata[number], self.names.memory
        state = automaton.states[index]
        lines = [
            f"{memory[number, 'state', 0]} := '{self.names.state(automaton, index)}'",
            f"{memory[number, 'entered', 0]} := now",
        ]
        if state.child.is_automaton:
            lines += self.start(state.child.index)
        for effect in state.effects:
            key = memory[number, effect.of, automaton.find_memory(effect)]
            if effect.of == "counter":
                value = write_script_real(0.0 if effect.action == "reset" else effect.value)
                lines.append(f"{key} {'+=' if effect.action == 'increment' else ':='} {value}")
            else:
                lines.append(f"{key} := {'now' if effect.action == 'set' else ABSENT}")
        return lines

    # Trees of states

    def _decide(self, place: StateTree) -> Iterator[tuple[int, Element]]:
        """Write what decides in the states of a place: the tree itself, or one that they share."""
        routines = place.decision.routines
        features = {feature for each in routines for feature in _list_features(each)}
        steps = [*self._measure(place.number, sorted(features)), self.step(routines[0], place)]
        decision = steps[0]
        if len(steps) > 1:
            decision = Element("Sequence", name="measure and decide")
            decision.extend(steps)
        for index, routine in enumerate(routines[1:], 1):
            self._tree(f"{place.called}_{index}").append(self.step(routine, place))
        if place.decision.state is not None:
            yield place.decision.state, decision
            return
        self._tree(place.called).append(decision)
        for state in place.decision.states:
            yield state, self._subtree(place.called)

    def _measure(self, number: int, features: Sequence[int]) -> Iterator[Element]:
        """Write what measures the values of features before they are asked about."""
        automaton = self.hierarchy.automata[number]
        entered = self._key(number, "entered")
        for index in features:
            source = automaton.features[index]
            if not is_measured(source):
                continue
            key = self.names.memory[number, "measured", index]
            if source.fresh is None:
                since = (
                    entered if source.sort == "time in state" else self._key(number, "timer", source.index)
                )
                ports = {"now": "{now}", "since": since, "elapsed": f"{{{key}}}"}
                yield Element("MeasureElapsed", {"name": clean(source.name), **ports})
            else:
                is_label = isinstance(source.kind, Categorical)
                fresh = str(int(source.fresh)) if is_label else write_script_real(source.fresh)
                code = f"{key} := {entered[1:-1]} == now ? {fresh} : {self._value(source)}"
                yield Element("Script", name=clean(source.name), code=code)

    def _value(self, source: FeatureSource) -> str:
        """Return the key of a reading or a computed value."""
        if source.sort == "computed":
            return self.names.computed[source.index]
        return self.names.c.readings[str(self.hierarchy.readings[source.index])]

    def step(self, step: Step, place: StateTree) -> Element:
        """Write what follows at a place of a tree."""
        if isinstance(step, Continuation):
            return self._subtree(f"{place.called}_{step.routine}", "continued")
        if isinstance(step, Answer):
            return self._answer(step, place)
        condition = self._condition(step.condition, place)
        if isinstance(condition, bool):
            return self.step(step.yes if condition else step.no, place)
        choice = Element("IfThenElse")
        choice.extend((condition, self.step(step.yes, place), self.step(step.no, place)))
        return choice

    def _answer(self, answer: Answer, place: StateTree) -> Element:
        automaton = self.hierarchy.automata[place.number]
        leaf = f"{self.names.memory[place.number, 'leaf', 0]} := {answer.leaf}"
        if answer.outcome in (STAY, place.decision.state):
            return Element("Script", name="stay", code=leaf)
        called = clean(automaton.states[answer.outcome].name)
        entering = self.enter(place.number, answer.outcome)
        if place.decision.state is not None:
            return Element("Script", name=f"to {called}", code="; ".join([leaf, *entering]))
        both = Element("Sequence", name=called)
        SubElement(both, "Script", name="leaf", code=leaf)
        there = self._is_in(place.number, answer.outcome)
        SubElement(both, "Script", name=f"to {called}", code="; ".join(entering), _skipIf=there)
        return both

    # Questions

    def _condition(self, condition: ValueCondition, place: StateTree) -> Element | bool:
        """Write a question, or its answer if it is always the same."""
        source = self.hierarchy.automata[place.number].features[condition.feature]
        is_label, described = isinstance(source.kind, Categorical), describe_condition(condition, source)
        if source.sort == "flag":
            raised = self._flag(place, source.index)
            code = write_condition(condition, Operand("flag", raised), SPELLING)
            return code == "true" if code in ("true", "false") else _ask(described, code)
        key = self._value(source) if source.sort in ("reading", "computed") and source.fresh is None else ""
        if source.sort == "counter":
            key = self.names.memory[place.number, "counter", source.index]
        key = key or self.names.memory[place.number, "measured", condition.feature]
        if is_label:
            return _ask(described, write_condition(condition, Operand("label", key, f"{key} < 0"), SPELLING))
        if not source.can_be_absent:
            return _ask(described, write_condition(condition, Operand("real", key), SPELLING))
        ports = {"name": described, "value": f"{{{key}}}"}
        if condition.comparison == "absent":
            return Element("IsAbsent", ports)
        if condition.comparison in ("below", "from"):
            limit = condition.high if condition.comparison == "below" else condition.low
            return Element(NODE_TYPES[condition.comparison], {**ports, "limit": repr(float(limit))})
        ends = {"low": repr(float(condition.low)), "high": repr(float(condition.high))}
        return Element(NODE_TYPES[condition.comparison], {**ports, **ends})

    def _flag(self, place: StateTree, flag: int) -> str:
        """Write whether the automaton that the current state runs has raised a flag, as a script."""
        paths = []
        for state in place.decision.states:
            raising = [self._is_in(*each) for each in self.hierarchy.find_raising(place.number, state, flag)]
            here = f"{self._is_in(place.number, state)} && "
            paths += [each if place.decision.state is not None else f"({here}{each})" for each in raising]
        return " || ".join(paths) or "false"

    def _is_in(self, number: int, state: int) -> str:
        """Write whether an automaton is in a state, as a script."""
        automaton, key = self.hierarchy.automata[number], self.names.memory[number, "state", 0]
        return f"{key} == '{self.names.state(automaton, state)}'"


def _ask(described: str, code: str) -> Element:
    return Element("ScriptCondition", name=described, code=code)


def _list_features(step: Step) -> set[int]:
    if not isinstance(step, Branch):
        return set()
    return {step.condition.feature} | _list_features(step.yes) | _list_features(step.no)


def describe_condition(condition: ValueCondition, source: FeatureSource) -> str:
    """Describe a question for people, as the name of its node."""
    name, comparison = clean(source.name), condition.comparison
    if comparison == "absent":
        return f"{name} is absent"
    if comparison == "label" and isinstance(source.kind, Categorical):
        return f"{name} is {clean(source.kind.labels[int(condition.low)])}"
    low, high = f"{condition.low:g}", f"{condition.high:g}"
    return {
        "below": f"{name} is below {high}",
        "from": f"{name} is {low} or more",
        "inside": f"{name} is from {low} to {high}",
        "across": f"{name} is from {low} on to {high}",
        "outside": f"{name} is not from {low} to {high}",
        "between": f"{name} is not from {low} on to {high}",
    }[comparison]


def clean(text: str) -> str:
    """Make a text fit for the name of a node: on one line, with characters that XML allows."""
    allowed = "".join(each if each.isprintable() and ord(each) < 0x110000 else " " for each in text)
    return " ".join(allowed.split()) or "unnamed"
