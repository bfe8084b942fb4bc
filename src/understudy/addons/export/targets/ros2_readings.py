"""The readings of a ROS 2 node in C++: from the messages and places of a robot's file, or computed from others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import radians

from understudy.addons.export.body_interface import RobotInterface
from understudy.addons.export.hierarchy import Hierarchy, ReadingSlot
from understudy.addons.export.identifiers import make_identifier
from understudy.addons.export.targets.c99_source import quote_for_c
from understudy.addons.export.targets.cpp_names import CNames
from understudy.addons.robots.inputs import PLACE, TopicInput
from understudy.addons.robots.robot_file import POSE, ReadingSpec
from understudy.addons.robots.ros.message_readings import BEARING, CLEAR_M, POSE_2D, RANGE, SCAN, WIDTH
from understudy.errors import SettingError, join_names
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import BOOLEAN, Categorical, Kind, Toroidal
from understudy.sim.sensing.sensor_table import LOCATIONS, STUCK

STEP = "  "
LOCATED = tuple(each.name for each in LOCATIONS)
SLOWEST_S = 60.0
"""The largest age of a message, s, that a robot's file may allow."""


@dataclass(frozen=True, slots=True)
class SourceCode:
    """A source of the robot's file in C++: its identifier, and an expression for each value of a message."""

    source: TopicInput
    identifier: str
    values: tuple[str, ...]


class NodeReadings:
    """The readings that an exported behavior uses, and the readings that these need; only these are subscribed to.

    `absent` are the readings that the robot does not have. SettingError is raised if the behavior or the robot's stops
    need images.
    """

    def __init__(self, robot: RobotInterface, hierarchy: Hierarchy, names: CNames) -> None:
        self.robot, self.file, self.hierarchy, self.names = robot, robot.file, hierarchy, names
        self._refuse_images()
        self._refuse_standard_topics()
        self.absent = tuple(
            str(slot) for slot in hierarchy.readings if not self._has(slot.reading, slot.target)
        )

    def _refuse_images(self) -> None:
        images = [str(slot) for slot in self.hierarchy.readings if slot.reading in self.robot.images]
        images += [
            f"{each.name}({slot.target})"
            for each in self.robot.derived.elapsed_sensors
            for slot in self.hierarchy.readings
            if each.of in self.robot.images and slot.reading == each.name
        ]
        if images:
            raise SettingError(
                where="target ros2",
                setting="reading",
                problem=f"{join_names(images)} comes from images, which the exported node cannot read",
                remedy="run it with understudy robots run, or read the blob from a topic of your own",
            )
        if self.file.camera is not None and self.file.camera.required:
            raise SettingError(
                where=self.file.name,
                setting="camera.required",
                problem="is true, but the exported node reads no images",
                remedy="leave it out of the file that you export for",
            )

    def _refuse_standard_topics(self) -> None:
        """Refuse what keeps a robot safe, or gives its pose, if the exported node does not read it."""
        stops = self.file.diagnostics is not None and self.file.diagnostics.stop
        for key, is_set in (("frames", self.file.frames is not None), ("diagnostics.stop", stops)):
            if is_set:
                raise SettingError(
                    where=self.file.name,
                    setting=key,
                    problem="is given, but the exported node does not read it",
                    remedy="leave it out of the file that you export for, and read a pose from odometry",
                )

    def _has(self, reading: str, target: str | None) -> bool:
        """Return whether the robot gives a reading, of itself or of a target; also places that come from topics."""
        of = None if target is None else self.file.targets.get(target)
        if target is not None and reading in PLACE:
            return of is not None and of.at is None
        if target is not None and reading in LOCATED:
            return of is not None
        return self.robot.has(reading, of_target=target is not None)

    def _kind_of(self, reading: str) -> Kind:
        return next(each.kind for each in self.robot.offered if each.name == reading)

    # What is needed

    @cached_property
    def keys(self) -> tuple[ReadingKey, ...]:
        """All readings and places that have to be read, each after those that it is computed of."""
        keys: dict[ReadingKey, None] = {}

        def need(reading: str, target: str | None) -> None:
            if (reading, target) in keys or not self._has(reading, target):
                return
            for each in self._list_parts(reading, target):
                need(*each)
            keys[reading, target] = None

        for slot in self.hierarchy.readings:
            need(slot.reading, slot.target)
        return tuple(keys)

    def _list_parts(self, reading: str, target: str | None) -> Iterator[ReadingKey]:
        """Yield what a reading is computed of."""
        if target is not None and reading in LOCATED and target in self.file.targets:
            of = self.file.targets[target]
            if of.at is None:
                yield from ((axis, target) for axis in PLACE)
            if not of.relative:
                yield from ((name, None) for name in POSE)
        if self._is_stall(reading, target):
            yield from ((axis, None) for axis in PLACE)
        for each in self.robot.derived.elapsed_sensors:
            if each.name == reading:
                yield each.of, target

    def _is_stall(self, reading: str, target: str | None) -> bool:
        return target is None and reading == STUCK[0].name and self.robot.derived.stall_sensor is not None

    @cached_property
    def sources(self) -> tuple[SourceCode, ...]:
        """The sources that have to be subscribed to: those of `keys`, of required readings and of the geofence."""
        needed = set(self.keys)
        if self.file.limits.geofence is not None:
            needed |= {(axis, None) for axis in PLACE}
        sources: list[SourceCode] = []
        for source in self.robot.sources:
            if source.required or any(key in needed for key in source.keys):
                identifier = make_identifier(source.name).upper()
                taken = {each.identifier for each in sources}
                identifier = f"FROM_{identifier}"
                if identifier in taken:
                    identifier += f"_{len(sources)}"
                sources.append(SourceCode(source, identifier, self._write_values(source)))
        return tuple(sources)

    def _write_values(self, source: TopicInput) -> tuple[str, ...]:
        if source.name in self.file.readings and (source.name, None) in source.keys:
            return (self._write_value(source.name, self.file.readings[source.name]),)
        place = self.file.targets[source.name.removeprefix("targets.")].field
        return tuple(f"understudy::finite(static_cast<double>(message.{place}.{axis}))" for axis in PLACE)

    def _write_value(self, name: str, reading: ReadingSpec) -> str:
        """Write the expression that takes a reading out of `message`, as `make_extractor` does."""
        offset = _number(reading.offset_m)
        if reading.type == SCAN:
            sector = f"{self._name_sector(name)}"
            if reading.field == BEARING:
                return f"{sector}.find_bearing(message)"
            if reading.field == WIDTH:
                clear = _number(CLEAR_M if reading.clear_m is None else reading.clear_m)
                return f"{sector}.measure_opening(message, {offset}, {clear})"
            return f"{sector}.find_nearest(message, {offset})"
        if reading.type == RANGE and reading.field in (None, "range"):
            return f"understudy::clear_range(message.range, message.min_range, message.max_range, {offset})"
        if (reading.type, reading.field) == POSE_2D:
            return f"understudy::wrap_angle(message.{reading.field})"
        if isinstance(self._kind_of(name), Toroidal):
            return f"understudy::compute_heading(message.{reading.field})"
        return f"understudy::finite(static_cast<double>(message.{reading.field}))"

    def _name_sector(self, name: str) -> str:
        return f"sector_{list(self.file.readings).index(name)}_"

    # The code

    @property
    def message_types(self) -> tuple[str, ...]:
        """The types of all messages that are subscribed to."""
        return tuple(dict.fromkeys(each.source.type for each in self.sources))

    def write_parameters(self) -> Iterator[str]:
        """Write how the constructor makes the sources, whose ages are parameters, and places of targets."""
        yield "sources_ = {"
        for each in self.sources:
            of = each.source
            flags = f"{_truth(of.required)}, {_truth(of.always)}"
            stale = f'read_number("stale_s.{of.name}", {_number(of.stale_s)}, {_number(SLOWEST_S)})'
            yield (
                f"{STEP}{{{_text(of.name)}, {_text(of.topic)}, {stale}, "
                f"{_number(of.rate_hz or 0.0)}, {flags}}},"
            )
        yield "};"
        for name, place in self._places.items():
            for axis, value in zip(PLACE, place, strict=True):
                yield f'{self._name_place(name, axis)} = read_place("targets.{name}.{axis}", {_number(value)});'
        if self.uses_random:
            yield 'const auto seed = static_cast<std::uint64_t>(declare_parameter<std::int64_t>("seed", 0));'
            for index, _ in self._random:
                constructor = (
                    f"std::make_unique<understudy::RandomNumber>(seed + {index}, {self._period(index)})"
                )
                yield f"random_{index}_ = {constructor};"

    @property
    def uses_random(self) -> bool:
        """True if random numbers are drawn."""
        return bool(self._random)

    @cached_property
    def _random(self) -> Sequence[tuple[int, str]]:
        return [
            (index, each.name)
            for index, each in enumerate(self.robot.derived.random_sensors)
            if (each.name, None) in self.keys
        ]

    def _period(self, index: int) -> str:
        return _number(self.robot.derived.random_sensors[index].every_s or 0.0)

    @cached_property
    def _places(self) -> dict[str, tuple[float, float]]:
        used = {target for reading, target in self.keys if reading in LOCATED}
        return {name: of.at for name, of in self.file.targets.items() if of.at is not None and name in used}

    def list_parameters(self) -> Iterator[tuple[str, object]]:
        """Yield the parameters that these readings have, with their defaults."""
        for each in self.sources:
            yield f"stale_s.{each.source.name}", each.source.stale_s
        for name, place in self._places.items():
            yield from ((f"targets.{name}.{axis}", value) for axis, value in zip(PLACE, place, strict=True))
        if self.uses_random:
            yield "seed", 0

    def _name_place(self, name: str, axis: str) -> str:
        return f"place_{list(self.file.targets).index(name)}_{axis}_"

    def write_members(self) -> Iterator[str]:
        """Write the members of the node's class that keep what readings are computed of."""
        for name, reading in self.file.readings.items():
            if reading.type == SCAN and reading.sector_deg is not None and self._is_used(name):
                edges = ", ".join(_number(radians(each)) for each in reading.sector_deg)
                yield f"const understudy::ScanSector {self._name_sector(name)}{{{edges}}};"
        for name in self._places:
            yield f"double {', '.join(f'{self._name_place(name, axis)} = 0.0' for axis in PLACE)};"
        for index, _ in self._random:
            yield f"std::unique_ptr<understudy::RandomNumber> random_{index}_;"
        stall = self.robot.derived.stall_sensor
        if stall is not None and (STUCK[0].name, None) in self.keys:
            yield f"understudy::StallDetector stall_{{{_number(stall.after_s)}}};"
        for index, (key, _) in enumerate(self.keys):
            if self._is_elapsed(key):
                yield f"understudy::ElapsedTime elapsed_{index}_;"

    def _is_used(self, name: str) -> bool:
        return any(each.source.name == name for each in self.sources)

    def _is_elapsed(self, reading: str) -> bool:
        return any(each.name == reading for each in self.robot.derived.elapsed_sensors)

    def write_subscriptions(self) -> Iterator[str]:
        """Write the subscriptions, one for each topic and type."""
        topics = dict.fromkeys((each.source.topic, each.source.type) for each in self.sources)
        for topic, type in topics:
            yield f"subscribe<{write_cpp_type(type)}>("
            yield f"{STEP}{_text(topic)}, [this](const {write_cpp_type(type)} & message, double now) {{"
            for each in self.sources:
                if (each.source.topic, each.source.type) != (topic, type):
                    continue
                if each.source.keys[0][0] in PLACE and each.source.keys[0][1] is not None:
                    x, y = each.values
                    yield f"{STEP * 2}const double x = {x}, y = {y};"
                    yield f"{STEP * 2}const bool known = !understudy::is_absent(x) && !understudy::is_absent(y);"
                    yield (
                        f"{STEP * 2}sources_[{each.identifier}].receive("
                        "now, {known ? x : ABSENT, known ? y : ABSENT});"
                    )
                else:
                    yield f"{STEP * 2}sources_[{each.identifier}].receive(now, {{{each.values[0]}}});"
            yield f"{STEP}}});"

    def write_readings(self) -> Iterator[str]:
        """Write how the readings of a tick at `now` are set in `r`."""
        variables: dict[ReadingKey, str] = {}
        located: dict[str, str] = {}
        for index, (reading, target) in enumerate(self.keys):
            name = f"value_{index}"
            variables[reading, target] = name
            if target is not None and reading in LOCATED:  # both readings of a target are computed together
                if target not in located:
                    located[target] = f"place_{index}"
                    yield f"const understudy::Polar place_{index} = {self._locate(target, variables)};"
                text = f"{located[target]}.{reading}"
            else:
                text = self._write_reading(index, reading, target, variables)
            yield f"const double {name} = {text};  // {format_reading_label((reading, target))}"
        for slot in self.hierarchy.readings:
            variable = variables.get((slot.reading, slot.target))
            if variable is not None:
                yield f"r->{self.names.readings[str(slot)]} = {self._convert(slot, variable)};"

    def _write_reading(
        self, index: int, reading: str, target: str | None, variables: dict[ReadingKey, str]
    ) -> str:
        for each in self.sources:
            if (reading, target) in each.source.keys:
                at = list(each.source.keys).index((reading, target))
                return f"sources_[{each.identifier}].read(now{f', {at}' if at else ''})"
        for number, name in self._random:
            if name == reading:
                return f"random_{number}_->compute(now - began_)"
        if self._is_stall(reading, target):
            x, y = (variables.get((axis, None), "ABSENT") for axis in PLACE)
            return f"stall_.compute(now - began_, {x}, {y}, guard_->get_speeds().drive)"
        of = next(each.of for each in self.robot.derived.elapsed_sensors if each.name == reading)
        is_yes = self._kind_of(of) == BOOLEAN
        value = variables.get((of, target), "ABSENT")
        return f"elapsed_{index}_.compute(now - began_, {value}, {_truth(is_yes)})"

    def _locate(self, target: str, variables: dict[ReadingKey, str]) -> str:
        of = self.file.targets[target]
        if of.at is None:
            x, y = (variables[axis, target] for axis in PLACE)
        else:
            x, y = (self._name_place(target, axis) for axis in PLACE)
        pose = ["0.0"] * 3 if of.relative else [variables.get((name, None), "ABSENT") for name in POSE]
        return f"understudy::locate({', '.join((x, y, *pose))})"

    def _convert(self, slot: ReadingSlot, variable: str) -> str:
        if not isinstance(slot.kind, Categorical):
            return variable
        label = f"{self.names.prefix}_label"
        return f"static_cast<{label}>(understudy::is_absent({variable}) ? -1 : static_cast<int>({variable}))"

    def write_fence(self) -> Iterator[str]:
        """Write the check that the robot is inside its geofence, at `now`."""
        fence = self.file.limits.geofence
        if fence is None:
            return
        of = {each.source.name: each.identifier for each in self.sources}
        x0, y0, x1, y1 = map(_number, fence)
        yield f"const double x = sources_[{of['x']}].read(now), y = sources_[{of['y']}].read(now);"
        yield f"if (!({x0} <= x && x <= {x1} && {y0} <= y && y <= {y1})) {{"
        yield f'{STEP}return {{"outside its geofence", true}};'
        yield "}"


def write_cpp_type(type: str) -> str:
    """Write a type of messages as in C++: sensor_msgs::msg::Range."""
    return type.replace("/", "::")


def _number(value: float) -> str:
    return repr(float(value))


def _truth(value: bool) -> str:
    return "true" if value else "false"


def _text(text: str) -> str:
    return f'"{quote_for_c(text)}"'
