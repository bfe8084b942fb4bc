"""What ROS 2 calls topics on Zenoh, how publishers and subscribers make themselves known, what goes with messages.

After the design that its documentation describes: https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Literal, NamedTuple, TypeAlias

from understudy.robots.ros.messages import (
    convert_to_dds_name,
    convert_to_ros_name,
    list_type_releases,
    load_typestore,
)

EndpointKind: TypeAlias = Literal["MP", "MS"]
"""Who a token stands for: one that publishes messages, or one that subscribes to them."""

SPACE = "@ros2_lv"
"""Before all tokens of liveliness; no wildcard of another key matches it."""
UNHASHED = "TypeHashNotSupported"
"""What stands for the hash of every type in ROS 2 Humble, which has none."""
NAME = "understudy"
"""What our node is called, for `ros2 node list`."""
NOTHING = "%"
"""An empty enclave or namespace."""
PARTS = 13
"""Of a token of a publisher or subscriber."""
ATTACHED = struct.Struct("<qqB16s")
"""Sequence number, time (ns since 1970), how long the id is, id."""


class Endpoint(NamedTuple):
    """A publisher or subscriber: of which session, of what kind, on which topic, of which type and hash."""

    session: str
    kind: EndpointKind
    topic: str
    type: str
    hash: str


@dataclass(frozen=True, slots=True)
class ZenohSession:
    """One session: its domain, and its id as Zenoh prints it."""

    domain: int
    id: str

    def node(self) -> str:
        """The token of its one node."""
        return "/".join((SPACE, str(self.domain), self.id, "0", "0", "NN", NOTHING, NOTHING, NAME))

    def token(self, number: int, kind: EndpointKind, *, topic: str, type: str, depth: int) -> str:
        """The token of the publisher or subscriber with a number of its own; all but depth is ROS 2's default."""
        node = (SPACE, str(self.domain), self.id, "0", str(number), kind, NOTHING, NOTHING, NAME)
        return "/".join(
            (
                *node,
                mangle_name(topic),
                convert_to_dds_name(type),
                hash_type_definition(type),
                f"::,{depth}:,:,:,,",
            )
        )


def make_domain_key(domain: int) -> str:
    """The key of all tokens of a domain."""
    return f"{SPACE}/{domain}/**"


def make_topic_keys(domain: int, topic: str, type: str) -> Sequence[str]:
    """The keys of a topic: that of ROS 2 since Jazzy, then that of Humble."""
    before = f"{domain}/{topic.strip('/')}/{convert_to_dds_name(type)}"
    return tuple(f"{before}/{last}" for last in (hash_type_definition(type), UNHASHED))


def hash_type_definition(type: str) -> str:
    """The hash of a type's definition (REP 2016)."""
    text: str = load_typestore(list_type_releases(type)[0]).hash_rihs01(type)
    return text


def parse_liveliness_token(token: str) -> Endpoint | None:
    """Who a token stands for; None where it is no publisher or subscriber of messages."""
    parts = token.split("/")
    if len(parts) != PARTS or parts[0] != SPACE or parts[5] not in ("MP", "MS"):
        return None
    topic, type, last = (part.replace("%", "/") for part in parts[9:12])
    return Endpoint(parts[2], "MP" if parts[5] == "MP" else "MS", topic, convert_to_ros_name(type), last)


def mangle_name(name: str) -> str:
    """A name as one part of a key."""
    return name.replace("/", "%")


def make_attachment(number: int, time_ns: int, token: str) -> bytes:
    """What goes with the message of this number of the publisher of a token: ROS 2 does without none of it."""
    return ATTACHED.pack(number, time_ns, 16, blake2b(token.encode(), digest_size=16).digest())
