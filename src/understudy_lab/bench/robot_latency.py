"""The time from a sensor value to the resulting command on one machine: sent here, decided elsewhere, received here.

Ranges are sent at 50 Hz, far and near in turn, so that each causes a command unlike the one before. Ours is a robot in
its own process (`main`) with all parts of a run, over DDS and over Zenoh; for comparison, a program in C
does nothing but answer on Cyclone DDS.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from socket import socket
from threading import Event, Thread
from typing import Any

import numpy as np

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.transport import Received, Transport, TransportWrapper
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.addons.robots.safety.stop_log import find_stop_log
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.extras import ExtraMissing
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Continuous
from understudy.records.messages import encode_message, make_message
from understudy.runtime.link import Program, link
from understudy.runtime.run_loop import Run
from understudy_lab.bench.harness import BenchGoal, Row, result
from understudy_lab.tree_builder import build_automaton, split_below

PEER = "Cyclone DDS in C (cyclonedds-dev, cyclonedds-tools and gcc on Debian)"
"""The packages that the compared program needs."""


def build_program(folder: Path) -> Path | None:
    """Build the C program in a folder, and return its path; None if it cannot be built here."""
    here = Path(__file__).parent
    compiler, generator = shutil.which("gcc"), shutil.which("idlc")
    if compiler is None or generator is None:
        return None
    program = folder / "echo"
    commands = (
        [generator, "-o", str(folder), str(here / "echo.idl")],
        [compiler, "-O2", f"-I{folder}", str(here / "echo.c"), str(folder / "echo.c"), "-o", str(program)],
    )
    for command in (commands[0], [*commands[1], "-lddsc"]):
        if subprocess.run(command, capture_output=True, check=False).returncode:
            return None
    return program


RATE_HZ, MESSAGES, FIRST = 50, 1000, 50
"""The message rate, the number of messages, and the number of first ones that are not counted."""
DOMAIN, SPACE = 77, "/bench"
RANGE, TWIST = "sensor_msgs/msg/Range", "geometry_msgs/msg/Twist"
FAR_M, NEAR_M = 2.0, 0.5
ANSWER_S, READY_S = 1.0, 30.0
DDS_ROW, ZENOH_ROW, ECHO_ROW = "ours, DDS", "ours, Zenoh", "answered in C, Cyclone DDS"

FILE = """
format = "understudy-robot/1"
name = "bench"
namespace = "{space}"
domain = {domain}
transport = "{transport}"
{router}tick_s = 0.02
limits = {{ speed_m_s = 0.5, turn_rad_s = 1.0 }}
commands = {{ drive_m_s = 0.4, turn_rad_s = 1.0 }}

[readings.sonar_ahead]
topic = "sonar"
type = "sensor_msgs/msg/Range"
required = true
"""


def run(messages: int = MESSAGES) -> dict[str, Any]:
    """Return a row per program in ms: median, 99 % quantile, maximum, and the number of missing answers."""
    try:
        rows = list(_rows(messages))
    except ExtraMissing as error:
        return {**result([], goals()), "missing": [str(error)]}
    found = {row["what"] for row in rows}
    return {**result(rows, goals()), "missing": [] if ECHO_ROW in found else [PEER]}


def goals() -> Sequence[BenchGoal]:
    """Return the goals: 2 ms in the median, 10 ms for 99 %, and no missing answer."""
    return [
        BenchGoal(f"{what}: {key}", _value(what, key), most=most)
        for what in (DDS_ROW, ZENOH_ROW)
        for key, most in (("p50_ms", 2.0), ("p99_ms", 10.0), ("lost", 0.5))
    ]


def _value(what: str, key: str) -> Callable[[Sequence[Row]], float]:
    return lambda rows: next((float(row[key]) for row in rows if row["what"] == what), float("nan"))


def _rows(messages: int) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        yield _dds(DDS_ROW, _decider(Path(folder), "dds"), messages)
        with socket() as free:
            free.bind(("127.0.0.1", 0))
            endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
        joined = ZenohTransport(DOMAIN, listen=endpoint)
        yield measure_latency(ZENOH_ROW, joined, _decider(Path(folder), "zenoh", endpoint), messages)
        program = build_program(Path(folder))
        if program is not None:
            yield _dds(ECHO_ROW, [str(program), str(DOMAIN), SPACE], messages)


def _dds(what: str, command: Sequence[str], messages: int) -> Row:
    return measure_latency(what, DdsTransport(DOMAIN), command, messages)


def _decider(folder: Path, transport: str, endpoint: str = "") -> Sequence[str]:
    path = folder / f"{transport}.toml"
    router = f'router = "{endpoint}"\n' if endpoint else ""
    text = FILE.format(space=SPACE, domain=DOMAIN, transport=transport, router=router)
    path.write_text(text, encoding="utf-8")
    return [sys.executable, "-m", "understudy_lab.bench.robot_latency", str(path)]


def measure_latency(what: str, transport: Transport, command: Sequence[str], messages: int) -> Row:
    """Start a program and measure how long it takes to answer ranges sent over a transport."""
    try:
        with _LatencyProbe(transport) as prober, _running(command) as ready:
            until = time.monotonic() + READY_S
            while not ready.is_set():
                if time.monotonic() > until:
                    raise RuntimeError(f"{what} is not ready after {READY_S:g} s")
                prober.ask(far=False)
                time.sleep(1 / RATE_HZ)
            taken = [prober.time(far=number % 2 == 0) for number in range(FIRST + messages)][FIRST:]
    finally:
        transport.close()
    answered_ms = np.array([seconds * 1e3 for seconds in taken if seconds is not None] or [np.nan])
    return {
        "what": what,
        "messages": messages,
        "rate_hz": RATE_HZ,
        "p50_ms": float(np.median(answered_ms)),
        "p99_ms": float(np.quantile(answered_ms, 0.99)),
        "max_ms": float(answered_ms.max()),
        "lost": sum(seconds is None for seconds in taken),
    }


class _LatencyProbe:
    """A sender of ranges that waits for the commands that answer them."""

    def __init__(self, transport: Transport) -> None:
        self._ranges = {
            far: encode_message(
                RANGE, make_message(RANGE, min_range=0.1, max_range=3.0, range=FAR_M if far else NEAR_M)
            )
            for far in (True, False)
        }
        self._wanted, self._came_s, self._answered = True, 0.0, Event()
        self._due_s = 0.0
        self._publish = transport.publisher(f"{SPACE}/sonar", RANGE)
        transport.subscribe(f"{SPACE}/cmd_vel", TWIST, self._command)

    def __enter__(self) -> _LatencyProbe:
        return self

    def __exit__(self, *_: object) -> None:
        self._answered.set()

    def ask(self, *, far: bool) -> None:
        """Send one range."""
        self._publish(self._ranges[far])

    def time(self, *, far: bool) -> float | None:
        """Send a range when it is due, and return the time of the answer in s, or None without one."""
        now = time.monotonic()
        self._due_s = max(self._due_s + 1 / RATE_HZ, now)
        time.sleep(self._due_s - now)
        self._answered.clear()
        self._wanted = far
        sent_s = time.monotonic()
        self.ask(far=far)
        return self._came_s - sent_s if self._answered.wait(ANSWER_S) else None

    def _command(self, data: bytes, at_s: float) -> None:
        ahead, *_, turning = struct.unpack_from("<6d", data, 4)
        if (ahead > 0, turning > 0) == (self._wanted, not self._wanted) and not self._answered.is_set():
            self._came_s = at_s
            self._answered.set()


@contextmanager
def _running(command: Sequence[str]) -> Iterator[Event]:
    """Run a program, and yield an event that is set when it reports that it is ready."""
    ready = Event()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:

        def listen() -> None:
            if process.stdout is not None and process.stdout.readline() == "ready\n":
                ready.set()

        Thread(target=listen, daemon=True).start()
        try:
            yield ready
        finally:
            process.terminate()


NAME, AVOID_NEAR_M = "avoid", 1.0


class WakingTransport(TransportWrapper):
    """A transport that signals when a message has arrived."""

    def __init__(self, transport: Transport) -> None:
        super().__init__(transport)
        self.came = Event()

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Subscribe as the wrapped transport does, and signal each message."""

        def woken(data: bytes, at_s: float) -> None:
            received(data, at_s)
            self.came.set()

        self._transport.subscribe(topic, type, woken, kept=kept)


def program() -> Program:
    """Return a program that drives ahead, and turns if something is near."""
    sonar = BoundFeature(Feature("sonar", Continuous(), "sonar_ahead"))
    decide = split_below("sonar", AVOID_NEAR_M, "left", "forward")
    basics = {"forward": Command(drive=1.0), "left": Command(turn=1.0)}
    made = build_automaton(
        NAME, dict.fromkeys(("start", *basics), decide), readings={"sonar": sonar}, basics=basics
    )
    kit = Kit.from_parts(sonar.feature, *(Behavior(name, command) for name, command in basics.items()))
    return link(Library.from_automata(kit, made), NAME)


def main(path: str) -> None:
    """Decide on each arriving range until none has arrived for a second."""
    file = load_robot(path)
    waking = WakingTransport(open_transport(file))
    with Robot(
        file, waking, path=path, watchdog=WatchdogClient(file, log=find_stop_log(file, Path(path)))
    ) as robot:
        while robot.senses.find_missing(robot.now_s) is not None:
            waking.came.wait()
        robot.arm("a measurement")
        run = Run.from_program(robot, program())
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        while waking.came.wait(1.0):  # no message for this time: it is over
            waking.came.clear()
            run.tick()


if __name__ == "__main__":
    main(*sys.argv[1:])
