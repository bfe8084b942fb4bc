"""The nodes of an export to BehaviorTree.CPP: a C++ header, the models that Groot2 reads, and functions in Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element, SubElement

from understudy.addons.export.condition_text import INDENT
from understudy.addons.export.hierarchy import ComputedValue, GroundBasic, Hierarchy
from understudy.addons.export.target_files import FileByHand
from understudy.addons.export.targets.btcpp_tree import clean
from understudy.addons.export.targets.c99_source import (
    CSource,
    describe_slot,
    quote_for_c,
    write_comment,
    write_error,
)
from understudy.addons.export.targets.cpp_names import TreeNames
from understudy.model.value_kinds import Categorical

SHARED = {
    "IsAbsent": ("Condition", ("value",)),
    "IsBelow": ("Condition", ("value", "limit")),
    "IsAtLeast": ("Condition", ("value", "limit")),
    "IsInArc": ("Condition", ("value", "low", "high")),
    "IsOffArc": ("Condition", ("value", "low", "high")),
    "MeasureElapsed": ("Action", ("now", "since")),
}
"""The nodes of every export, with the ports that they read."""


class NodeWriter:
    """A writer of the nodes of an export."""

    def __init__(self, hierarchy: Hierarchy, names: TreeNames) -> None:
        self.hierarchy, self.names = hierarchy, names
        self.source = CSource(hierarchy, names.c, single_precision=False)

    # What Groot2 reads

    def write_models(self) -> Element:
        """Write the models of the nodes, from which editors know their ports."""
        models = Element("TreeNodesModel")
        for called, (kind, ports) in SHARED.items():
            model = SubElement(models, kind, ID=called)
            for port in ports:
                SubElement(model, "input_port", name=port, type="double")
            if called == "MeasureElapsed":
                SubElement(model, "output_port", name="elapsed", type="double")
        for index, node in self.names.nodes.items():
            value = self.hierarchy.computed[index]
            model = SubElement(models, "Action", ID=node)
            self._read_ports(model, value.slots)
            kind = "int" if isinstance(value.kind, Categorical) else "double"
            SubElement(model, "output_port", name="value", type=kind).text = clean(value.name)
        for basic in self.hierarchy.basics:
            model = SubElement(models, "Action", ID=self.names.c.basics[basic.name])
            if self.hierarchy.is_coordinator:
                for port in ("order", "since", "now"):
                    SubElement(model, "input_port", name=port, type="double")
            elif basic.is_function:
                self._read_ports(model, basic.slots)
            else:
                for channel in self.hierarchy.channels:
                    called = self.names.c.channels[channel.name]
                    at = repr(float(basic.command.get(channel.name, channel.rest)))
                    input_port = SubElement(model, "input_port", name=called, type="double", default=at)
                    input_port.text = (
                        clean(f"{channel.doc} {channel.unit}") if channel.doc or channel.unit else None
                    )
        return models

    def _read_ports(self, model: Element, slots: Sequence[int]) -> None:
        for slot in slots:
            reading = self.hierarchy.readings[slot]
            kind = "int" if isinstance(reading.kind, Categorical) else "double"
            called = self.names.c.readings[str(reading)]
            SubElement(model, "input_port", name=called, type=kind).text = clean(f"{reading} {reading.unit}")

    # What a C++ program includes

    def write_types(self) -> Iterator[str]:
        """Write the structures of readings and commands, and the function that puts readings on the blackboard."""
        hierarchy, names = self.hierarchy, self.names.c
        yield "/* What the robot's sensors answered; everything is absent to begin with. */"
        yield from ("struct readings", "{")
        for slot in hierarchy.readings:
            is_label = isinstance(slot.kind, Categorical)
            kind, absent = ("int", "-1") if is_label else ("double", "understudy::ABSENT")
            yield f"{INDENT}{kind} {names.readings[str(slot)]} = {absent}; /* {describe_slot(slot)} */"
        yield from ("};", "", "/* What the basic behavior that runs commands. */", "struct commands", "{")
        for channel in hierarchy.channels:
            rest = self.source.write_real(channel.rest)
            comment = write_comment(channel.unit or "no unit")
            yield f"{INDENT}double {names.channels[channel.name]} = {rest}; /* {comment} */"
        yield f"{INDENT}int behavior = 0; /* the index of the basic behavior in manifest.json */"
        yield from (
            "};",
            "",
            "/* Put one snapshot on the blackboard, before every tick. `now` is in s; what is infinite is absent. */",
        )
        yield "inline void write_readings(BT::Blackboard &board, const readings &r, double now)"
        yield from ("{", f'{INDENT}(void)r;\n{INDENT}board.set("now", now);')
        for slot in hierarchy.readings:
            called = names.readings[str(slot)]
            value = f"r.{called}" if isinstance(slot.kind, Categorical) else f"finite_or_absent(r.{called})"
            yield f'{INDENT}board.set("{called}", {value});'
        yield "}"

    def write_classes(self) -> Iterator[str]:
        """Write the classes of the nodes, and the function that registers them."""
        hierarchy, names = self.hierarchy, self.names.c
        for index, node in self.names.nodes.items():
            yield from self._computed(node, hierarchy.computed[index])
        for index, basic in enumerate(hierarchy.basics):
            yield from self._basic(index, basic)
        yield "/* `commands` is written at every tick, and must outlive the tree. */"
        yield "inline void register_nodes(BT::BehaviorTreeFactory &factory, commands &commands)"
        yield from ("{", f"{INDENT}understudy::register_nodes(factory);")
        for node in self.names.nodes.values():
            yield f'{INDENT}factory.registerNodeType<{node}>("{node}");'
        for basic in hierarchy.basics:
            called = names.basics[basic.name]
            yield f'{INDENT}factory.registerNodeType<{called}>("{called}", &commands);'
        yield "}"

    def _computed(self, node: str, value: ComputedValue) -> Iterator[str]:
        is_label = isinstance(value.kind, Categorical)
        kind = "int" if is_label else "double"
        yield f"/* {write_comment(value.name)} */"
        yield from (f"class {node} : public BT::SyncActionNode", "{", "public:")
        yield from (f"{INDENT}using BT::SyncActionNode::SyncActionNode;", "")
        yield from self._ports(value.slots, f'BT::OutputPort<{kind}>("value")')
        yield from (f"{INDENT}BT::NodeStatus tick() override", f"{INDENT}{{")
        if value.expression is None:
            called = self.names.c.functions[f"feature {value.name}"]
            text = f"{called}({', '.join(self._take(value.slots))})"
        else:
            yield from self._gather(value.slots)
            text = self.source.write_value(value.kind, value.expression)
        yield f'{INDENT * 2}setOutput<{kind}>("value", {text});'
        yield from (f"{INDENT * 2}return BT::NodeStatus::SUCCESS;", f"{INDENT}}}", "};", "")

    def _basic(self, index: int, basic: GroundBasic) -> Iterator[str]:
        hierarchy, names = self.hierarchy, self.names.c
        called, assigned = names.basics[basic.name], f"{INDENT * 2}commands_->"
        yield f"/* {write_comment(basic.name)} */"
        yield from (f"class {called} : public Behavior", "{", "public:")
        yield from (f"{INDENT}using Behavior::Behavior;", "")
        constant = not (hierarchy.is_coordinator or basic.is_function)
        if hierarchy.is_coordinator:
            ports = ", ".join(f'BT::InputPort<double>("{each}")' for each in ("order", "since", "now"))
            yield from self._ports((), ports)
        elif constant:
            ports = ", ".join(
                f'BT::InputPort<double>("{names.channels[each.name]}", '
                f"{self.source.write_real(basic.command.get(each.name, each.rest))}, "
                f'"{quote_for_c(each.unit)}")'
                for each in hierarchy.channels
            )
            yield from self._ports((), ports)
        else:
            yield from self._ports(basic.slots, "")
        yield from ("protected:", f"{INDENT}void command() override", f"{INDENT}{{")
        yield f"{assigned}behavior = {index};"
        if hierarchy.is_coordinator:
            order, issued = (names.channels[channel.name] for channel in hierarchy.channels)
            yield f'{assigned}{order} = read_number(*this, "order");'
            is_new = 'read_number(*this, "since") == read_number(*this, "now")'
            yield f"{assigned}{issued} = {is_new} ? 1.0 : 0.0;"
        elif constant:
            for channel in hierarchy.channels:
                port = names.channels[channel.name]
                yield f'{assigned}{port} = read_number(*this, "{port}");'
        else:
            yield from self._function(called, basic)
        yield from (f"{INDENT}}}", "};", "")

    def _function(self, called: str, basic: GroundBasic) -> Iterator[str]:
        for channel in self.hierarchy.channels:
            yield (
                f"{INDENT * 2}commands_->{self.names.c.channels[channel.name]} = "
                f"{self.source.write_real(channel.rest)};"
            )
        if basic.problem:
            arguments = ["*commands_", *self._take(basic.slots)]
            function = self.names.c.functions[f"behavior {basic.name}"]
            yield f"{INDENT * 2}{function}({', '.join(arguments)});"
            return
        yield from self._gather(basic.slots)
        for channel in self.hierarchy.channels:
            if channel.name in basic.computed:
                expression = self.hierarchy.computed[basic.computed[channel.name]].expression
                if expression is not None:
                    rest = self.source.write_real(channel.rest)
                    text = f"or_rest({self.source.write_expression(expression)}, {rest})"
                    yield f"{INDENT * 2}commands_->{self.names.c.channels[channel.name]} = {text};"

    def _ports(self, slots: Sequence[int], more: str) -> Iterator[str]:
        ports = [
            f'BT::InputPort<{"int" if is_label else "double"}>("{key}")'
            for key, is_label in self._keys(slots)
        ]
        ports += [more] if more else []
        yield from (f"{INDENT}static BT::PortsList providedPorts()", f"{INDENT}{{")
        yield from (f"{INDENT * 2}return {{{', '.join(ports)}}};", f"{INDENT}}}", "")

    def _keys(self, slots: Sequence[int]) -> list[tuple[str, bool]]:
        readings = [self.hierarchy.readings[slot] for slot in slots]
        return [(self.names.c.readings[str(each)], isinstance(each.kind, Categorical)) for each in readings]

    def _take(self, slots: Sequence[int]) -> list[str]:
        return [
            f'{"read_label" if is_label else "read_number"}(*this, "{key}")'
            for key, is_label in self._keys(slots)
        ]

    def _gather(self, slots: Sequence[int]) -> Iterator[str]:
        """Write the readings of a node as a structure `r`, for expressions as those of the C target."""
        if slots:
            yield from (f"{INDENT * 2}readings taken;", f"{INDENT * 2}const readings *const r = &taken;")
        for (key, _), text in zip(self._keys(slots), self._take(slots), strict=True):
            yield f"{INDENT * 2}taken.{key} = {text};"

    # Functions to fill in

    def write_functions(self) -> FileByHand | None:
        """Write the header of the functions that could not be translated; None if there are none."""
        stubs: dict[str, str] = {}
        kinds = {f"feature {each.name}": each.kind for each in self.hierarchy.computed}
        for function in self.hierarchy.functions_to_write:
            called, takes = self.names.c.functions[function.name], self._declare(function.slots)
            kind = "int" if isinstance(kinds.get(function.name), Categorical) else "double"
            if function.name.startswith("behavior "):
                kind, takes = "void", ["commands &commands", *takes]
            declared = f"inline {kind} {called}({', '.join(takes)})"
            error = write_error(function)
            stubs[called] = f"namespace {self.names.c.prefix}\n{{\n{declared}\n{{\n{error}\n}}\n}}\n"
        return self.source.keep_by_hand(stubs)

    def _declare(self, slots: Sequence[int]) -> list[str]:
        return [f"{'int' if is_label else 'double'} {key}" for key, is_label in self._keys(slots)]
