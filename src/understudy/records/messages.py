"""Messages of ROS 2: types, and encoding as bytes (CDR), from the definitions that rosbags ships."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from understudy.errors import UnderstudyError
from understudy.extras import ExtraMissing

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

BASE, NAMED, ARRAY, SEQUENCE = 1, 2, 3, 4
"""The node types of fields in rosbags: number or text; other message; array of fixed length; sequence of any length."""

LONGEST = 2**22
"""The largest size of messages other than images, in bytes."""
LONGEST_IMAGE = 2**26
"""The largest size of images, in bytes."""
JAZZY, HUMBLE = "jazzy", "humble"
"""The releases of ROS 2 whose definitions of some types differ."""
TWIST = "geometry_msgs/msg/Twist"
"""The type of messages with a speed and a turning rate."""

DEFAULTS: Mapping[str, Mapping[str, float]] = {"geometry_msgs/msg/Quaternion": {"w": 1.0}}
"""The values of fields that ROS 2's definitions give and rosbags leaves out: a zero quaternion is no orientation."""


class MessageRefused(UnderstudyError, json_type="MessageRefused"):
    """Bytes that are no valid message of their type."""

    def __init__(self, *, type: str, problem: str) -> None:
        self.type, self.problem = type, problem
        super().__init__(f"a message is no {type}: {problem}; publish messages of this type there")


def load_typestore(release: str = JAZZY) -> Typestore:
    """Load the message definitions of a release of ROS 2.

    Releases after Jazzy define the types that are used here in the same way.
    """
    return _types(release)  # one for each, however it is asked for


@cache
def _types(release: str) -> Typestore:
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise ExtraMissing(what="a ROS 2 robot", extra="ros2") from None
    return get_typestore(Stores(f"ros2_{release}"))


def make_hashable(typestore: Typestore) -> Typestore:
    """Copy definitions with `uint8` in place of `char`, which ROS 2 treats as the same.

    Without this rosbags hashes `char` as type 13, and the hash of ServiceEventInfo, and thereby of all services, is
    wrong.
    """
    from rosbags.typesys.store import Typestore

    def rename(field: Any) -> Any:
        node_type, of = field
        if node_type == BASE:
            return (node_type, ("uint8", of[1])) if of[0] == "char" else field
        return field if node_type == NAMED else (node_type, (rename(of[0]), of[1]))

    hashable = Typestore()
    hashable.fielddefs = {
        name: (constants, [(field, rename(each)) for field, each in fields])
        for name, (constants, fields) in typestore.fielddefs.items()
    }
    return hashable


def is_known_type(type: str) -> bool:
    """Return whether there is a definition of a message type."""
    return type in load_typestore().fielddefs


def list_message_fields(type: str, release: str = JAZZY) -> Mapping[str, tuple[int, Any]]:
    """Return the fields of a message type by name: the node type of each field and its element type."""
    return {
        name: (int(node_type), of) for name, (node_type, of) in load_typestore(release).fielddefs[type][1]
    }


@cache
def list_type_releases(type: str) -> Sequence[str]:
    """List the releases whose definitions of a type differ, newest first: Range has no variance in Humble."""
    older = type in load_typestore(HUMBLE).fielddefs and list_message_fields(
        type, HUMBLE
    ) != list_message_fields(type)
    return (JAZZY, HUMBLE) if older else (JAZZY,)


def convert_to_dds_name(type: str) -> str:
    """Convert the ROS 2 name `sensor_msgs/msg/Range` to the DDS name `sensor_msgs::msg::dds_::Range_`."""
    *packages, name = type.split("/")
    return "::".join((*packages, "dds_", f"{name}_"))


def convert_to_ros_name(type: str) -> str:
    """Convert the DDS name `sensor_msgs::msg::dds_::Range_` to `sensor_msgs/msg/Range`; other names stay unchanged."""
    *packages, name = type.split("::")
    if packages[-1:] != ["dds_"]:
        return type
    return "/".join((*packages[:-1], name.removesuffix("_")))


def decode_message(type: str, data: bytes) -> Any:
    """Decode a message by the newest definition that fits; raise MessageRefused if none does."""
    problem = ""
    if len(data) > (LONGEST_IMAGE if type.endswith("Image") else LONGEST):
        raise MessageRefused(type=type, problem=f"it is {len(data)} bytes long")
    for release in list_type_releases(type):
        try:
            return load_typestore(release).deserialize_cdr(data, type)
        except Exception as error:
            # A decoder may raise any error on forged bytes; only this message may be lost by that.
            problem = problem or f"{error.__class__.__name__}: {error}"
    raise MessageRefused(type=type, problem=problem)


def encode_message(type: str, message: Any) -> bytes:
    """Encode a message as bytes."""
    return bytes(load_typestore().serialize_cdr(message, type))


def make_message(type: str, **values: Any) -> Any:
    """Make a message; fields that are left out are 0, empty or false."""
    return make_message_of(load_typestore(), type, values)


def make_message_of(typestore: Typestore, type: str, values: Mapping[str, Any]) -> Any:
    """Make a message of a type that `typestore` defines; fields that are left out are 0, empty or false."""
    fields = {name: (int(node_type), of) for name, (node_type, of) in typestore.fielddefs[type][1]}
    defaults_and_values = {**DEFAULTS.get(type, {}), **values}
    arguments = {
        name: defaults_and_values[name] if name in defaults_and_values else _blank(typestore, *of)
        for name, of in fields.items()
    }
    return typestore.types[type](**arguments)


def _blank(typestore: Typestore, node_type: int, of: Any) -> Any:
    import numpy as np

    if node_type == NAMED:
        return make_message_of(typestore, of, {})
    if node_type == BASE:
        return "" if of[0] == "string" else False if of[0] == "bool" else 0.0 if "float" in of[0] else 0
    inner, length = of
    if inner[0] == BASE and inner[1][0] != "string":
        return np.zeros(length if node_type == ARRAY else 0, inner[1][0].replace("byte", "uint8"))
    return [_blank(typestore, *inner) for _ in range(length if node_type == ARRAY else 0)]


def encode_twist(
    type: str, *, speed_m_s: float, turn_rad_s: float, frame: str = "", time_s: float = 0.0
) -> bytes:
    """Encode a Twist or TwistStamped: speed along x (m/s), and turning to the left about z (rad/s), as in REP 103.

    `time_s` is the time of the stamp, in s since 1970.
    """
    if type == TWIST:
        return _encode_plain_twist(float(speed_m_s) + 0.0, float(turn_rad_s) + 0.0)  # -0.0 is sent as 0.0
    moved = _make_twist(float(speed_m_s), float(turn_rad_s))
    seconds = int(time_s)
    stamp = make_message("builtin_interfaces/msg/Time", sec=seconds, nanosec=int((time_s - seconds) * 1e9))
    header = make_message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)
    return encode_message(type, make_message(type, header=header, twist=moved))


@lru_cache(maxsize=256)
def _encode_plain_twist(speed_m_s: float, turn_rad_s: float) -> bytes:
    """Encode a Twist; the same one is sent many times a second."""
    return encode_message(TWIST, _make_twist(speed_m_s, turn_rad_s))


def _make_twist(speed_m_s: float, turn_rad_s: float) -> Any:
    types = load_typestore().types
    vector = types["geometry_msgs/msg/Vector3"]
    return types[TWIST](linear=vector(x=speed_m_s, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=turn_rad_s))
