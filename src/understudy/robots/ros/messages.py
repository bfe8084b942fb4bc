"""Messages of ROS 2: their types and their bytes (CDR), from the definitions that rosbags ships."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from understudy.errors import UnderstudyError
from understudy.robots.ros.transport import ExtraMissing

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

BASE, NAMED, ARRAY, SEQUENCE = 1, 2, 3, 4
"""What rosbags calls the sorts of fields: a number or text, another message, so many of one, any number of one."""

LONGEST = 2**22
"""No message is longer, in bytes, that robots have use for, but for images."""
LONGEST_IMAGE = 2**26
JAZZY, HUMBLE = "jazzy", "humble"
"""Releases of ROS 2 whose definitions are not all the same."""


class MessageRefused(UnderstudyError, json_type="MessageRefused"):
    """Bytes that are no message of their type."""

    def __init__(self, *, type: str, problem: str) -> None:
        self.type, self.problem = type, problem
        super().__init__(f"a message is no {type}: {problem}; publish messages of this type there")


def types(release: str = JAZZY) -> Typestore:
    """The definitions of a release of ROS 2. Later ones than Jazzy's are the same, of what robots use here."""
    return _types(release)  # one for each, however it is asked for


@cache
def _types(release: str) -> Typestore:
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise ExtraMissing(what="a ROS 2 robot", extra="ros2") from None
    return get_typestore(Stores(f"ros2_{release}"))


def known(type: str) -> bool:
    """Whether there is a definition of this type."""
    return type in types().fielddefs


def fields(type: str, release: str = JAZZY) -> Mapping[str, tuple[int, Any]]:
    """The fields of a type: the sort of each, and of what it is."""
    return {name: (int(sort), of) for name, (sort, of) in types(release).fielddefs[type][1]}


@cache
def releases(type: str) -> Sequence[str]:
    """Those whose definitions of a type differ, newest first: a Range ended before its variance in Humble."""
    older = type in types(HUMBLE).fielddefs and fields(type, HUMBLE) != fields(type)
    return (JAZZY, HUMBLE) if older else (JAZZY,)


def dds_name(type: str) -> str:
    """`sensor_msgs::msg::dds_::Range_` for `sensor_msgs/msg/Range`."""
    *packages, name = type.split("/")
    return "::".join((*packages, "dds_", f"{name}_"))


def ros_name(type: str) -> str:
    """`sensor_msgs/msg/Range` for `sensor_msgs::msg::dds_::Range_`; another name stays as it is."""
    *packages, name = type.split("::")
    if packages[-1:] != ["dds_"]:
        return type
    return "/".join((*packages[:-1], name.removesuffix("_")))


def decode(type: str, data: bytes) -> Any:
    """The message that bytes hold, by the newest definition that fits; MessageRefused where none of this type does."""
    problem = ""
    if len(data) > (LONGEST_IMAGE if type.endswith("Image") else LONGEST):
        raise MessageRefused(type=type, problem=f"it is {len(data)} bytes long")
    for release in releases(type):
        try:
            return types(release).deserialize_cdr(data, type)
        except Exception as error:
            # Whatever a decoder does with bytes that somebody made up, it must not end more than this message.
            problem = problem or f"{error.__class__.__name__}: {error}"
    raise MessageRefused(type=type, problem=problem)


def encode(type: str, message: Any) -> bytes:
    """The bytes of a message."""
    return bytes(types().serialize_cdr(message, type))


def make(type: str, **values: Any) -> Any:
    """A message; what is left out is 0, empty or false."""
    given = {name: values.get(name, _blank(*of)) for name, of in fields(type).items()}
    return types().types[type](**given)


def _blank(sort: int, of: Any) -> Any:
    import numpy as np

    if sort == NAMED:
        return make(of)
    if sort == BASE:
        return "" if of[0] == "string" else False if of[0] == "bool" else 0.0 if "float" in of[0] else 0
    inner, length = of
    if inner[0] == BASE and inner[1][0] != "string":
        return np.zeros(length if sort == ARRAY else 0, inner[1][0].replace("byte", "uint8"))
    return [_blank(*inner) for _ in range(length if sort == ARRAY else 0)]


def twist(type: str, *, speed_m_s: float, turn_rad_s: float, frame: str = "", time_s: float = 0.0) -> bytes:
    """A Twist or TwistStamped: ahead along x, to the left about z (REP 103); stamped at a time since 1970, s."""
    vector = "geometry_msgs/msg/Vector3"
    moved = make(
        "geometry_msgs/msg/Twist",
        linear=make(vector, x=float(speed_m_s)),
        angular=make(vector, z=float(turn_rad_s)),
    )
    if type == "geometry_msgs/msg/Twist":
        return encode(type, moved)
    seconds = int(time_s)
    stamp = make("builtin_interfaces/msg/Time", sec=seconds, nanosec=int((time_s - seconds) * 1e9))
    header = make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)
    return encode(type, make(type, header=header, twist=moved))
