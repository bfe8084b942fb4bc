"""A robot that knows Zenoh and nothing of us: keys, tokens and bytes written by hand, as rmw_zenoh has them.

    python plain_zenoh.py ENDPOINT NAMESPACE [humble]

Publishes ranges (2 m) at 50 Hz in domain 3, and prints the first Twist that moves, and what was attached to it.
"""

import json
import struct
import sys
import threading
import time
from typing import Any

import zenoh

RANGE = "sensor_msgs::msg::dds_::Range_", "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a"
TWIST = "geometry_msgs::msg::dds_::Twist_", "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
# Encapsulation, time and frame ("eye"), sort, field of view, least, most and measured range; then the variance.
MESSAGE = struct.pack("<HH iI I4s B3x ffff", 0x0100, 0, 12, 34, 4, b"eye", 0, 0.25, 0.125, 3.0, 2.0)


def main(endpoint: str, namespace: str, release: str = "jazzy") -> None:
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    session: Any = zenoh.open(config)
    ranges, commands = (f"{type}/{_hash(digest, release)}" for type, digest in (RANGE, TWIST))
    mangled = namespace.replace("/", "%")
    before = f"@ros2_lv/3/{session.zid()}/0"
    tokens = [
        session.liveliness().declare_token(key)
        for key in (
            f"{before}/0/NN/%/{mangled}/driver",
            f"{before}/1/MP/%/{mangled}/driver/{mangled}%sonar/{ranges}/2::,5:,:,:,,",
            f"{before}/2/MS/%/{mangled}/driver/{mangled}%cmd_vel/{commands}/::,10:,:,:,,",
        )
    ]
    moving = threading.Event()

    def obey(sample: zenoh.Sample) -> None:
        data = bytes(sample.payload)
        if any(data[4:]) and not moving.is_set():
            attached = bytes(sample.attachment) if sample.attachment is not None else b""
            sys.stdout.write(f"{data.hex()} {attached.hex()}\n")
            sys.stdout.flush()
            moving.set()

    subscriber: Any = session.declare_subscriber(f"3{namespace}/cmd_vel/{commands}", obey)
    publisher = session.declare_publisher(f"3{namespace}/sonar/{ranges}")
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    message = MESSAGE + (struct.pack("<f", 0.5) if release == "jazzy" else b"")
    until = time.monotonic() + 300
    while not moving.wait(0.02) and time.monotonic() < until:
        publisher.put(message, attachment=struct.pack("<qqB16s", 1, time.time_ns(), 16, b"0123456789abcdef"))
    subscriber.undeclare()
    for token in tokens:
        token.undeclare()
    session.close()


def _hash(digest: str, release: str) -> str:
    return f"RIHS01_{digest}" if release == "jazzy" else "TypeHashNotSupported"


if __name__ == "__main__":
    main(*sys.argv[1:])
