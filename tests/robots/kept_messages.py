"""Publishers that keep their last message for who comes late, written with the libraries that robots use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from understudy.addons.robots.ros.dds import make_dds_type
from understudy.addons.robots.ros.zenoh import make_topic_keys


@contextmanager
def keep_over_dds(domain: int, _: str, topic: str, type: str, data: bytes) -> Iterator[None]:
    """Publish a message over DDS, and keep it."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    kept = Qos(
        Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
    )
    raw = make_dds_type(type)
    robot = DomainParticipant(domain)
    writer = DataWriter(robot, Topic(robot, f"rt{topic}", raw, qos=kept), qos=kept)
    message = raw.__new__(raw)
    message.data = data
    writer.write(message)
    yield


@contextmanager
def keep_over_zenoh(domain: int, endpoint: str, topic: str, type: str, data: bytes) -> Iterator[None]:
    """Publish a message over Zenoh, through a router, and keep it."""
    import zenoh
    from zenoh import ext

    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    config.insert_json5("timestamping/enabled", "true")
    with zenoh.open(config) as session:
        key = make_topic_keys(domain, topic, type)[0]
        writer = ext.declare_advanced_publisher(
            session, key, cache=ext.CacheConfig(max_samples=1), publisher_detection=True
        )
        writer.put(data)
        yield
