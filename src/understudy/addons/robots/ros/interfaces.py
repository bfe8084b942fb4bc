"""Types of actions, services and messages that the files of a robot define: .action, .srv and .msg in a folder.

The folder is laid out as ROS 2 packages are: `PACKAGE/action/NAME.action`, `PACKAGE/srv/NAME.srv` and
`PACKAGE/msg/NAME.msg`. Messages of ROS 2's common interfaces need no files.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from understudy.addons.robots.ros.transport import WireType
from understudy.errors import FileError
from understudy.records.messages import (
    ARRAY,
    BASE,
    LONGEST,
    NAMED,
    SEQUENCE,
    MessageRefused,
    load_typestore,
    make_hashable,
    make_message_of,
)

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

SEPARATOR = "---"
"""The line between the parts of an .action or .srv file."""
PARTS = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
"""The parts of each kind of interface, in the order of the file."""
ID, TIME = (NAMED, "unique_identifier_msgs/msg/UUID"), (NAMED, "builtin_interfaces/msg/Time")
CANCEL = "action_msgs/srv/CancelGoal"
"""The type of the service that cancels goals, which is the same for all actions."""
EMPTY = [("structure_needs_at_least_one_member", (BASE, ("uint8", 0)))]
"""The field of types that have none."""


class ServiceTypes(NamedTuple):
    """The types of a service: on the wire, and of its request and response."""

    wire: WireType
    request: str
    response: str


class ActionTypes(NamedTuple):
    """The types of an action: of its three services, of its feedback messages, and of goal and feedback."""

    send_goal: ServiceTypes
    get_result: ServiceTypes
    feedback_message: WireType
    goal: str
    feedback: str


class Interfaces:
    """The types that a folder defines, besides those of ROS 2's common interfaces.

    FileError is raised if a file cannot be read, or has a type that no file defines.
    """

    def __init__(self, folder: Path | str | None = None) -> None:
        from rosbags.typesys import get_types_from_msg
        from rosbags.typesys.store import Typestore

        self.folder = None if folder is None else Path(folder)
        self.typestore: Typestore = Typestore()
        self.typestore.fielddefs = dict(load_typestore().fielddefs)
        self.typestore.types = dict(load_typestore().types)
        definitions: dict[str, Any] = {}
        self._files: dict[str, Path] = {}
        for interface, name, text, path in (*_read(self.folder), *_built_in()):
            texts = [text] if interface == "msg" else _split(text)
            suffixes = [""] if interface == "msg" else [f"_{part}" for part in PARTS[interface]]
            if len(texts) != len(suffixes):
                problem = f"has {len(texts)} parts instead of {len(suffixes)}"
                raise FileError(
                    path=path, place="", problem=problem, remedy=f"separate them by lines with {SEPARATOR}"
                )
            for suffix, part in zip(suffixes, texts, strict=True):
                package, base = name.split("/")
                try:
                    # Types without a package are messages of the same one, in actions and services, too.
                    parsed = get_types_from_msg(part, f"{package}/msg/{base}{suffix}")
                except Exception as error:
                    problem = f"cannot be read ({str(error).splitlines()[0]})"
                    raise FileError(
                        path=path, place="", problem=problem, remedy="give a definition of ROS 2"
                    ) from None
                type_name = f"{package}/{interface}/{base}{suffix}"
                constants, fields = next(iter(parsed.values()))
                definitions[type_name] = (constants, fields or EMPTY)
                self._files[type_name] = path
        for name in {each.rpartition("_")[0] for each in definitions if "/action/" in each}:
            definitions |= _list_parts_of_action(name)
        for name in {each.rpartition("_")[0] for each in definitions if each.endswith("_Request")}:
            definitions |= _list_parts_of_service(name)
        self._check(definitions)
        try:
            self.typestore.register(definitions)
        except Exception as error:
            problem = f"contradict each other ({str(error).splitlines()[0]})"
            remedy = "leave out types of ROS 2's common interfaces"
            raise FileError(path=folder or "", place="definitions", problem=problem, remedy=remedy) from None

    def knows(self, type: str) -> bool:
        """Return whether a type is defined: pkg/msg/Name, pkg/srv/Name or pkg/action/Name."""
        return (
            type if "/msg/" in type else f"{type}_{PARTS[type.split('/')[1]][0]}"
        ) in self.typestore.fielddefs

    def list_fields(self, type: str) -> Mapping[str, tuple[int, Any]]:
        """Return the fields of a message, or of a part of a service or action, by name."""
        fields = {name: (int(node_type), of) for name, (node_type, of) in self.typestore.fielddefs[type][1]}
        return {name: of for name, of in fields.items() if name != EMPTY[0][0]}

    def find_service(self, type: str) -> ServiceTypes:
        """Return the types of a service."""
        return ServiceTypes(self._wire(type), f"{type}_Request", f"{type}_Response")

    def find_action(self, type: str) -> ActionTypes:
        """Return the types of an action."""
        return ActionTypes(
            self.find_service(f"{type}_SendGoal"),
            self.find_service(f"{type}_GetResult"),
            self._wire(f"{type}_FeedbackMessage"),
            f"{type}_Goal",
            f"{type}_Feedback",
        )

    def make(self, type: str, **values: Any) -> Any:
        """Make a message; fields that are left out are 0, empty or false."""
        return make_message_of(self.typestore, type, values)

    def encode(self, type: str, message: Any) -> bytes:
        """Encode a message as bytes; any error of the encoder is passed on."""
        return bytes(self.typestore.serialize_cdr(message, type))

    def decode(self, type: str, data: bytes) -> Any:
        """Decode a message; raise MessageRefused if the bytes are none of this type."""
        try:
            if len(data) > LONGEST:
                raise ValueError(f"it is {len(data)} bytes long")
            return self.typestore.deserialize_cdr(data, type)
        except Exception as error:  # a decoder may raise any error on forged bytes
            raise MessageRefused(type=type, problem=f"{error.__class__.__name__}: {error}") from None

    @cached_property
    def _hashable(self) -> Typestore:
        return make_hashable(self.typestore)

    def _wire(self, type: str) -> WireType:
        return WireType(type, str(self._hashable.hash_rihs01(type)))

    def _check(self, definitions: Mapping[str, Any]) -> None:
        """Refuse types that are used and not defined."""
        for name, (_, fields) in definitions.items():
            for field, of in fields:
                used = _find_named(of)
                if used is not None and used not in definitions and used not in self.typestore.fielddefs:
                    package, interface, base = used.split("/")
                    raise FileError(
                        path=self._files.get(name, self.folder or ""), place=field,
                        problem=f"is of type {used}, which no file defines",
                        remedy=f"put {package}/{interface}/{base}.{interface} into the folder of definitions",
                    )  # fmt: skip


def _read(folder: Path | None) -> Iterator[tuple[str, str, str, Path]]:
    """Yield the kind of interface, the name (package/name), the text and the path of each definition in a folder."""
    if folder is None:
        return
    if not folder.is_dir():
        raise FileError(
            path=folder, place="", problem="is no folder", remedy="give the folder with the definitions"
        )
    for interface in ("msg", "srv", "action"):
        for path in sorted(folder.glob(f"*/{interface}/*.{interface}")):
            try:
                yield interface, f"{path.parent.parent.name}/{path.stem}", path.read_text("utf-8-sig"), path
            except (OSError, ValueError) as error:
                problem = f"cannot be read ({error})"
                raise FileError(path=path, place="", problem=problem, remedy="give a text in UTF-8") from None


def _built_in() -> Iterator[tuple[str, str, str, Path]]:
    """Yield the definition of the service that cancels goals; only its fields matter, not its constants."""
    goal = "action_msgs/GoalInfo"
    text = f"{goal} goal_info\n{SEPARATOR}\nint8 return_code\n{goal}[] goals_canceling\n"
    yield "srv", "action_msgs/CancelGoal", text, Path("CancelGoal.srv")


def _split(text: str) -> Sequence[str]:
    parts: list[list[str]] = [[]]
    for line in text.splitlines():
        if line.strip() == SEPARATOR:
            parts.append([])
        else:
            parts[-1].append(line)
    return ["\n".join(lines) for lines in parts]


def _list_parts_of_action(name: str) -> dict[str, Any]:
    """Make the types that ROS 2 derives from an action: two services and the message with feedback."""

    def part(suffix: str) -> tuple[int, str]:
        return NAMED, f"{name}_{suffix}"

    return {
        f"{name}_SendGoal_Request": ([], [("goal_id", ID), ("goal", part("Goal"))]),
        f"{name}_SendGoal_Response": ([], [("accepted", (BASE, ("bool", 0))), ("stamp", TIME)]),
        f"{name}_GetResult_Request": ([], [("goal_id", ID)]),
        f"{name}_GetResult_Response": ([], [("status", (BASE, ("int8", 0))), ("result", part("Result"))]),
        f"{name}_FeedbackMessage": ([], [("goal_id", ID), ("feedback", part("Feedback"))]),
    }


def _list_parts_of_service(name: str) -> dict[str, Any]:
    """Make the types that ROS 2 derives from a service: the event, and the whole, whose hash names the service."""
    parts = {part: (NAMED, f"{name}_{part}") for part in ("Request", "Response", "Event")}
    return {
        f"{name}_Event": (
            [],
            [
                ("info", (NAMED, "service_msgs/msg/ServiceEventInfo")),
                ("request", (SEQUENCE, (parts["Request"], 1))),
                ("response", (SEQUENCE, (parts["Response"], 1))),
            ],
        ),
        name: ([], [(f"{part.lower()}_message", of) for part, of in parts.items()]),
    }


def _find_named(of: Any) -> str | None:
    sort, inner = of
    if sort in (ARRAY, SEQUENCE):
        return _find_named(inner[0])
    return inner if sort == NAMED else None
