"""Command `understudy robots simulate`: simulate robots with physics as ROS 2 robots, without hardware."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from types import FrameType
from typing import TYPE_CHECKING, Any

import typer
from msgspec.structs import replace

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.model import check_physics
from understudy.addons.bridges.mujoco.processes import REFEREE, ObjectServer, RobotProcess
from understudy.addons.bridges.mujoco.robot_files import (
    check_ros,
    format_robot_file,
    format_team_file,
    list_robot_names,
)
from understudy.addons.bridges.mujoco.ros_robots import Simulation, drop_derived_readings
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.errors import UnknownName
from understudy.sim.catalog import find_scenario
from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console
from understudy.ui.cli.robots_options import SimulateOptions

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.addons.robots.ros.transport import Transport
    from understudy.sim.scenario.schema import Scenario

RATE_HZ = 20.0
GRACE_S = 1.0
"""Time (s) that robots in processes of their own have to end before they get SIGTERM."""
LEAVING_S = 10.0
"""Time (s) after SIGTERM before they are killed."""


def simulate_robots(options: SimulateOptions) -> None:
    """Simulate the robots of a world with physics (MuJoCo), each as a ROS 2 robot in its own namespace."""
    out = make_console(err=options.as_json)
    scenario = find_scenario(options.world)
    check_physics(scenario)
    check_ros(scenario)
    names = list_robot_names(scenario)
    with _leaving_orderly() as left:
        if options.write_files is not None and options.only is None:
            known = str(Path(options.world).resolve()) if Path(options.world).is_file() else options.world
            _write(
                options.write_files,
                scenario,
                out,
                world=known,
                domain=options.domain,
                rate_hz=options.rate,
                router=options.router,
            )
        if options.only is None:
            facts = {
                "world": scenario.name,
                "seed": options.seed,
                "domain": options.domain,
                "rate_hz": options.rate,
                "router": options.router,
            }
            _announce({**facts, "robots": names}, out, as_json=options.as_json)
        if options.apart and options.only is None:
            _apart([*names, REFEREE], left, seconds=options.seconds)
            return
        # One of several ends with the process that began all of them, however that ends.
        late = _simulate(
            drop_derived_readings(replace(scenario, tick_s=1.0 / options.rate)),
            options.seed,
            DdsTransport(options.domain)
            if options.router is None
            else ZenohTransport(options.domain, options.router),
            options.only,
            seconds=options.seconds,
            stopped=lambda: left.is_set() or (options.parent != 0 and os.getppid() != options.parent),
        )
    if late:
        out.print(
            f"{late} ticks came late: this machine is too slow for {options.rate:g} Hz with as many robots."
        )


def _announce(facts: Mapping[str, Any], out: Console, *, as_json: bool) -> None:
    """Print what is simulated, before it begins."""
    if as_json:
        print_json(facts)
        return
    said = ", ".join(f"/{name}" for name in facts["robots"])
    out.print(
        f"{facts['world']} (seed {facts['seed']}): {said} on domain {facts['domain']}, {facts['rate_hz']:g} Hz. "
        "Ctrl-C stops it."
    )


def _write(
    folder: Path,
    scenario: Scenario,
    out: Console,
    *,
    world: str,
    domain: int,
    rate_hz: float,
    router: str | None,
) -> None:
    """Write the files of all robots and of the team; keep and report existing files with other contents."""
    names = list_robot_names(scenario)
    files = {
        f"{name}.toml": format_robot_file(
            scenario, number, world=world, domain=domain, rate_hz=rate_hz, router=router
        )
        for number, name in enumerate(names)
    }
    for name, content in files.items():
        parse_robot(content, folder / name)
    if len(names) > 1:
        files["team.toml"] = format_team_file(scenario)
    with convert_os_errors(folder, "writing the robots' files"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            path, said = folder / name, "Wrote {}"
            if path.exists() and path.read_bytes() != content.encode():
                said = (
                    "{} exists with other content and was left as it is; remove it to have it written again"
                )
            else:
                write_atomically(path, content.encode())
            out.print(said.format(path), soft_wrap=True, markup=False)


@contextmanager
def _leaving_orderly() -> Iterator[Event]:
    """Handle SIGTERM like Ctrl-C while the block runs, and yield an event that is set by either.

    The event is needed because an interrupt is lost if it arrives in a callback that cannot raise.
    """
    left = Event()

    def leave(number: int, frame: FrameType | None) -> None:
        left.set()
        signal.default_int_handler(number, frame)

    numbers = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        numbers.append(signal.SIGINT)
    before = {number: signal.signal(number, leave) for number in numbers}
    try:
        yield left
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _simulate(
    scenario: Scenario,
    seed: int,
    transport: Transport,
    only: str | None,
    *,
    seconds: float,
    stopped: Callable[[], bool],
) -> int:
    """Simulate until the time is over or `stopped` returns True; return the number of late ticks."""
    try:
        return _what(scenario, seed, transport, only).run(seconds=seconds, stopped=stopped)
    except KeyboardInterrupt:
        return 0
    finally:
        transport.close()


def _what(
    scenario: Scenario, seed: int, transport: Transport, only: str | None
) -> Simulation | RobotProcess | ObjectServer:
    """Make the simulation of all robots, or of one robot or the referee if the others run in other processes."""
    if only == REFEREE:
        return ObjectServer(scenario, seed, transport)
    body, names = MujocoBody(scenario, [seed]), list_robot_names(scenario)
    if only is None:
        return Simulation(body, transport)
    if only not in names:
        raise UnknownName(
            what="robot", name=only, where=f"scenario {scenario.name!r}", known=[*names, REFEREE]
        )
    return RobotProcess(body, names.index(only), transport)


def _apart(names: list[str], left: Event, *, seconds: float) -> None:
    """Run this command again for each name, each in its own process; end all of them with this one."""
    began = time.monotonic()
    arguments = [each for each in sys.argv[1:] if each != "--apart"]
    command = [sys.executable, "-m", "understudy.ui.cli", *arguments, "--parent", str(os.getpid()), "--only"]
    processes = [subprocess.Popen([*command, name]) for name in names]
    try:
        while time.monotonic() - began < seconds and all(each.poll() is None for each in processes):
            if left.wait(0.1):
                break
    except KeyboardInterrupt:
        pass
    finally:
        ends = time.monotonic() + GRACE_S  # a terminal's Ctrl-C came to all of them
        while time.monotonic() < ends and any(each.poll() is None for each in processes):
            time.sleep(0.05)
        failed = max(each.poll() or 0 for each in processes)  # it has said why
        for each in processes:
            each.terminate()
        for each in processes:
            try:
                each.wait(LEAVING_S)
            except subprocess.TimeoutExpired:
                each.kill()
                each.wait()
    if failed > 0:
        raise typer.Exit(failed)
