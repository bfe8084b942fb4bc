"""What peers on other middleware wrote and understood, recorded, so that they are compiled only where sources changed.

The record holds a hash of the sources, ours that speak to peers and theirs, with which all tests of this folder
passed; and of each peer the bytes that it wrote, and how it read our commands, which are compared everywhere.

    python -m tests.peers.recorded_peers                 run all tests of this folder, and write the record
    python -m tests.peers.recorded_peers --list-missing  exit with 1 if sources changed since
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from tests.peers.building import HERE, cyclone, fast_dds, missing

ROOT = HERE.parents[1]
RECORD = HERE / "recorded_peers.json"
ROBOTS = "src/understudy/addons/robots"
SOURCES = (
    f"{ROBOTS}/ros/**/*.py", f"{ROBOTS}/robot.py", f"{ROBOTS}/robot_file.py", f"{ROBOTS}/inputs.py",
    f"{ROBOTS}/camera/image_decoding.py", "src/understudy/records/messages.py", "tests/peers/*.py",
    "tests/peers/*/*.*pp", "tests/peers/*/*.c", "tests/peers/*/*.idl",
)  # fmt: skip
PINNED = ("cyclonedds", "rosbags")
PEERS = {"fast_dds": (), "fast_dds humble": ("humble",), "cyclone": ()}
"""By name: the options of those whose bytes are kept."""
SPACE, DOMAIN = "/recorded", 49
SPEED_M_S, TURN_RAD_S = 0.4, -0.5
"""Of the command that peers are sent."""


def hash_sources() -> str:
    """Hash the sources of both sides, and the versions of the libraries that ours uses."""
    digest = sha256()
    for path in sorted({path for pattern in SOURCES for path in ROOT.glob(pattern)}):
        digest.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    lock = (ROOT / "requirements-dev.lock").read_text()
    for name in PINNED:
        digest.update(" ".join(re.findall(rf"(?m)^{name}==\S+", lock)).encode())
    return digest.hexdigest()[:20]


def read_record() -> dict[str, Any]:
    """Read the record; an empty one if there is none."""
    return json.loads(RECORD.read_text()) if RECORD.exists() else {"sources": "", "peers": {}}


def record_peer(name: str, folder: Path) -> dict[str, Any]:
    """Start a peer, command it once, and return what it sent by topic, and what it got."""
    from understudy.addons.robots.ros.dds import DdsTransport
    from understudy.records.messages import encode_twist

    twist = "geometry_msgs/msg/Twist"
    program = fast_dds(folder) if name.startswith("fast_dds") else cyclone(folder)
    command = [str(program), str(DOMAIN), SPACE, *PEERS[name]]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        transport = DdsTransport(DOMAIN)
        publish = transport.publisher(f"{SPACE}/cmd_vel", twist)
        while True:
            publish(encode_twist(twist, speed_m_s=SPEED_M_S, turn_rad_s=TURN_RAD_S))
            try:
                process.wait(0.05)
                break
            except subprocess.TimeoutExpired:
                continue
        lines = [line.split() for line in process.stdout]
        transport.close()
    sent = {words[1].removeprefix(SPACE): words[2] for words in lines if words[0] == "sent"}
    data, speed, turning = next(words[2:] for words in lines if words[0] == "got")
    return {"sent": sent, "got": {"bytes": data, "speed_m_s": float(speed), "turn_rad_s": float(turning)}}


def main() -> int:
    """Record the peers, or say whether sources changed."""
    if "--list-missing" in sys.argv:
        changed = read_record()["sources"] != hash_sources()
        sys.stdout.write(f"the sources of peers {'changed' if changed else 'are as recorded'}\n")
        return int(changed)
    if missing():
        sys.stdout.write(f"{missing()}\n")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        peers = {name: record_peer(name, Path(folder)) for name in PEERS}
    record = {"sources": hash_sources(), "peers": peers}
    before = RECORD.read_bytes() if RECORD.exists() else None
    RECORD.write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
    ended = pytest.main([str(HERE), f"--rootdir={ROOT}", "-q", "-m", "not soak"])
    if ended != pytest.ExitCode.OK:
        RECORD.unlink() if before is None else RECORD.write_bytes(before)
        sys.stdout.write("Nothing is recorded, since tests failed.\n")
    return int(ended)


def check_sources() -> None:
    """Skip or, in continuous integration, fail a test where sources changed and peers cannot be compiled."""
    if read_record()["sources"] == hash_sources() or not missing():
        return
    sentence = (
        f"sources changed since peers were recorded: {missing()}; or run python -m tests.peers.recorded_peers"
    )
    if os.environ.get("CI"):
        pytest.fail(sentence)
    pytest.skip(sentence)


if __name__ == "__main__":
    raise SystemExit(main())
