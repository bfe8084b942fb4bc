"""Trials of stopping, with real processes over DDS: a program killed or frozen, a sensor dead, a link cut.

    python -m tests.robots.trials --times 50

prints for each how long the robot went on, in the middle and at worst, and each trial that failed. The robot has a
deadline of its own only where the link is cut: nobody else can stop it then.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path
from queue import Empty, Queue
from statistics import median
from tempfile import TemporaryDirectory
from threading import Thread

from tests.processes import end_with_tests
from tests.robots.domains import own_domain
from tests.robots.rovers import ROVER

from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.safety.stop_log import read_stops

ROOT = Path(__file__).parents[2]
DOMAIN = own_domain()
STOP_S = 0.2
SENSOR_S = FORGOTTEN_S = parse_robot(ROVER).readings["sonar_ahead"].stale_s + 0.1
ROBOT_DEADLINE_S = 0.15
PATIENCE_S = 60.0
AFTER_S = 1.3
"""For so long it must not move again: longer than the watchdog goes on."""
TWITCH_S = 0.05
"""Moving once more for longer than this is no twitch."""
GET_FLAGS, SET_FLAGS, IS_UP = 0x8913, 0x8914, 1
IFREQ = struct.Struct("16sH22x")
"""What Linux takes to ask for the flags of an interface, and to set them."""
NUMBERS = count()


@dataclass(frozen=True)
class Outcome:
    """How long the robot went on, s, and what was wrong; empty where nothing was.

    `twitch_s` is for how long it moved once more when the program went on: what a transport had accepted, but not yet
    sent when that was frozen, comes out then, until the next stop.
    """

    took_s: float
    problem: str = ""
    twitch_s: float = 0.0
    pauses: int = 0
    """How often it had stopped before anything happened, since the machine was too busy."""


class Process:
    """A process of ours that tells line by line."""

    def __init__(
        self, *command: str, env: Mapping[str, str] | None = None, prefix: Sequence[str] = ()
    ) -> None:
        self.lines: Queue[str] = Queue()
        self.process = subprocess.Popen(
            end_with_tests([*prefix, sys.executable, "-m", *command]),
            cwd=ROOT,
            env={**os.environ, **(env or {})},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if env else None,  # Cyclone complains of a cut link all the while
            text=True,
        )
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        for line in self.process.stdout or ():
            self.lines.put(line.strip())

    def line(self, wait_s: float = PATIENCE_S) -> str:
        """The next line; empty where none comes."""
        try:
            return self.lines.get(timeout=wait_s)
        except Empty:
            return ""

    def ask(self, line: str) -> str:
        """What it answers."""
        if self.process.stdin is None:
            raise TypeError("a process without input")
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()
        return self.line()

    def send(self, number: int) -> float:
        """Send it a signal; when, s."""
        now = time.monotonic()
        os.kill(self.process.pid, number)
        return now

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        self._reader.join()
        for end in (self.process.stdin, self.process.stdout):
            if end is not None:
                end.close()


@dataclass
class Scene:
    """A robot, and a program that decides for it."""

    robot: Process
    decider: Process
    log: Path
    pauses: int = 0

    def drive(self) -> str:
        """Arm it, and wait until it has moved for a while that is never the same; what was wrong.

        On a busy machine it may stop meanwhile, for a tick or until it is armed again: `pauses` counts that.
        """
        self.pauses = 0
        until, goes_on_s = time.monotonic() + PATIENCE_S, random.uniform(0.2, 0.5)
        said, moves = "", False
        while time.monotonic() < until:
            if (said := self.decider.ask("arm")) == "armed":
                while line := self.robot.line(goes_on_s):
                    moves = line.startswith("moves")
                    self.pauses += not moves
                if moves:
                    return ""
            time.sleep(0.05)
        return f"it never moved: {said}"

    def measure_stop(self, since_s: float, *, limit_s: float, why: str = "command") -> Outcome:
        """How long after that the robot stopped for good."""
        lines = [self.robot.line(limit_s + AFTER_S)]
        while line := self.robot.line(AFTER_S):
            lines.append(line)
        if not lines[-1].startswith("stops"):
            return Outcome(limit_s + AFTER_S, "it went on")
        _, at, reason = lines[-1].split()
        took_s, problem = float(at) - since_s, ""
        if took_s > limit_s:
            problem = f"stopped after {1000 * took_s:.0f} ms, by {reason}: {self.causes()}"
        elif reason != why:
            problem = f"stopped by its {reason}, not by a {why}"
        return Outcome(took_s, problem, pauses=self.pauses)

    def causes(self) -> str:
        """Of the last stops."""
        return "; ".join(f"{stop.time:%S.%f} {stop.by}: {stop.cause}" for stop in read_stops(self.log)[-3:])

    def check_disarmed(self, outcome: Outcome, after: str) -> Outcome:
        """What was wrong, or that it is not disarmed after something, or moves."""
        if outcome.problem:
            return outcome
        lines = []
        while line := self.robot.line(AFTER_S):
            lines.append(line)
        if len(lines) % 2:
            return replace(outcome, problem=f"{after}, and {lines[-1]}")
        times = [float(line.split()[1]) for line in lines]
        twitch_s = sum(times[1::2]) - sum(times[::2])
        said, problem = self.decider.ask("state"), ""
        if twitch_s > TWITCH_S:
            problem = f"{after}, and moved for {1000 * twitch_s:.0f} ms"
        elif not said.startswith("disarmed"):
            problem = f"{after}, and is {said}"
        return replace(outcome, problem=problem, twitch_s=twitch_s)


@contextmanager
def scene(
    *,
    deadline: bool = False,
    only: str | None = None,
    zenoh: bool = False,
    env: Mapping[str, str] | None = None,
    prefix: Sequence[str] = (),
) -> Iterator[tuple[Scene, str]]:
    """A robot that nobody else talks to, and its namespace."""
    namespace = f"/trial_{os.getpid()}_{next(NUMBERS)}"
    with TemporaryDirectory() as folder, ExitStack() as ending:
        file = Path(folder) / "rover.toml"
        text = ROVER.replace("/rover", namespace).replace("domain = 43", f"domain = {DOMAIN}")
        options = ["--deadline", str(ROBOT_DEADLINE_S)] if deadline else []
        if zenoh:
            endpoint = f"tcp/localhost:{free_port()}"
            text = text.replace("[limits]", f'transport = "zenoh"\nrouter = "{endpoint}"\n[limits]')
            options += ["--listen", endpoint]
        file.write_text(text)
        options += [] if only is None else ["--only", only]
        robot = Process("tests.robots.trial_robot", str(DOMAIN), namespace, *options, env=env, prefix=prefix)
        ending.callback(robot.end)
        decider = Process("tests.robots.trial_decider", str(file), env=env)
        ending.callback(decider.end)
        robot.line()
        yield Scene(robot, decider, file.with_suffix(".stops.jsonl")), namespace


def free_port() -> int:
    with socket.socket() as any_port:
        any_port.bind(("localhost", 0))
        number: int = any_port.getsockname()[1]
        return number


def kill_decider(times: int, *, zenoh: bool = False) -> Iterator[Outcome]:
    """The program that decides is killed (SIGKILL)."""
    for _ in range(times):
        with scene(zenoh=zenoh) as (here, _):
            if problem := here.drive():
                yield Outcome(0.0, problem)
            else:
                yield here.measure_stop(here.decider.send(signal.SIGKILL), limit_s=STOP_S)


def frozen(times: int, *, zenoh: bool = False) -> Iterator[Outcome]:
    """The program that decides is frozen (SIGSTOP), and goes on a while later, disarmed."""
    with scene(zenoh=zenoh) as (here, _):
        for _ in range(times):
            if problem := here.drive():
                yield Outcome(0.0, problem)
                continue
            outcome = here.measure_stop(here.decider.send(signal.SIGSTOP), limit_s=STOP_S)
            here.decider.send(signal.SIGCONT)
            yield here.check_disarmed(outcome, "it went on")


def deaf(times: int) -> Iterator[Outcome]:
    """A sensor's process dies, or falls silent, in turn."""
    with scene(only="base") as (here, namespace):
        for number in range(times):
            sensor = Process("tests.robots.trial_robot", str(DOMAIN), namespace, "--only", "sonar")
            try:
                if problem := here.drive():
                    yield Outcome(0.0, problem)
                    continue
                how = signal.SIGSTOP if number % 2 else signal.SIGKILL
                outcome = here.measure_stop(sensor.send(how), limit_s=SENSOR_S)
                sensor.send(signal.SIGCONT)
                yield here.check_disarmed(outcome, "it spoke again")
            finally:
                sensor.end()
                time.sleep(
                    FORGOTTEN_S
                )  # else its last word would arm the robot before the next sensor speaks


def break_robot_link(times: int) -> Iterator[Outcome]:
    """The link to the robot is cut, and later mended: its own deadline stops it, and nothing sets it off again."""
    with link() as (ours, inside, env), scene(deadline=True, env=env, prefix=inside) as (here, _):
        for _ in range(times):
            if problem := here.drive():
                yield Outcome(0.0, problem)
                continue
            cut_s = time.monotonic()
            turn(ours, up=False)
            outcome = here.measure_stop(cut_s, limit_s=STOP_S, why="deadline")
            turn(ours, up=True)
            yield here.check_disarmed(outcome, "it was mended")


def can_cut() -> bool:
    """Whether there may be a network of our own: needs root, and `ip`."""
    if shutil.which("ip") is None:
        return False
    name = f"try{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, check=False).returncode == 0
    if made:
        subprocess.run(["ip", "netns", "del", name], check=False)
    return made


def turn(interface: str, *, up: bool) -> None:
    """Take an interface up or down: at once, where starting `ip` takes a while on a busy machine."""
    import fcntl

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        name = interface.encode()
        flags: int = IFREQ.unpack(fcntl.ioctl(any_socket, GET_FLAGS, IFREQ.pack(name, 0)))[1]
        flags = flags | IS_UP if up else flags & ~IS_UP
        fcntl.ioctl(any_socket, SET_FLAGS, IFREQ.pack(name, flags))


@contextmanager
def link() -> Iterator[tuple[str, Sequence[str], Mapping[str, str]]]:
    """A network for the robot: our end of the cable, what runs a command in there, how DDS finds both."""
    name = f"us{os.getpid()}"
    ours, theirs = f"{name}a", f"{name}b"
    inside = ("ip", "netns", "exec", name)
    commands = [
        f"ip netns add {name}",
        f"ip link add {ours} type veth peer name {theirs} netns {name}",
        f"ip addr add 10.213.77.1/24 dev {ours}",
        f"ip link set {ours} up",
        f"{' '.join(inside)} ip addr add 10.213.77.2/24 dev {theirs}",
        f"{' '.join(inside)} ip link set {theirs} up",
    ]
    try:
        for command in commands:
            subprocess.run(command.split(), check=True, capture_output=True)
        interfaces = '<NetworkInterface address="10.213.77.0"/>'
        uri = f"<CycloneDDS><Domain><General><Interfaces>{interfaces}</Interfaces></General></Domain></CycloneDDS>"
        yield ours, inside, {"CYCLONEDDS_URI": uri}
    finally:
        subprocess.run(["ip", "netns", "del", name], check=False, capture_output=True)
        subprocess.run(["ip", "link", "del", ours], check=False, capture_output=True)


TRIALS: Mapping[str, tuple[Callable[[int], Iterator[Outcome]], float]] = {
    "killed": (kill_decider, STOP_S),
    "frozen": (frozen, STOP_S),
    "deaf": (deaf, SENSOR_S),
    "cut": (break_robot_link, STOP_S),
    "killed, Zenoh": (partial(kill_decider, zenoh=True), STOP_S),
    "frozen, Zenoh": (partial(frozen, zenoh=True), STOP_S),
}


def main() -> None:
    given = ArgumentParser(description=__doc__)
    given.add_argument("--times", type=int, default=50)
    given.add_argument("trials", nargs="*", metavar="TRIAL", help=f"{', '.join(TRIALS)}; all")
    asked = given.parse_args()
    for name in asked.trials or TRIALS:
        if name == "cut" and not can_cut():
            print(f"{name}: skipped, needs root and ip", flush=True)  # noqa: T201
            continue
        trial, limit_s = TRIALS[name]
        outcomes = list(trial(asked.times))
        took, failed = [1000 * each.took_s for each in outcomes], [each for each in outcomes if each.problem]
        print(  # noqa: T201
            f"{name}: {len(outcomes)} times, median {median(took):.0f} ms, worst {max(took):.0f} ms, "
            f"limit {1000 * limit_s:.0f} ms, failed {len(failed)}",
            flush=True,
        )
        if pauses := sum(each.pauses for each in outcomes):
            print(f"    {pauses} pauses before anything happened: this machine is busy")  # noqa: T201
        if twitched := [each.twitch_s for each in outcomes if each.twitch_s]:
            most = 1000 * max(twitched)
            print(f"    {len(twitched)} moved once more when the program went on, for {most:.0f} ms at most")  # noqa: T201
        for each in failed:
            print(f"    {each.problem}", flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
