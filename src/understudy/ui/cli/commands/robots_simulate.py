"""`understudy robots simulate`: robots of a scenario in physics, as ROS 2 robots, for who has no hardware."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from threading import Event
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.robots.ros.transport import Transport
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim_mujoco.processes import ObjectServer, RobotProcess
    from understudy.sim_mujoco.ros_robots import Simulation

RATE_HZ = 20.0
GRACE_S = 1.0
"""For so long robots in processes of their own may take to leave, before they are told to."""
LEAVING_S = 10.0
"""For so long they may take then, before they are killed."""


def simulate_robots(
    world: Annotated[str, typer.Argument(metavar="WORLD", help="A built-in world, or a scenario's file.")],
    seed: Annotated[int, typer.Option(help="Where everything is at first.", min=0, max=2**63 - 1)] = 0,
    domain: Annotated[int, typer.Option(help="ROS_DOMAIN_ID.", min=0, max=232)] = 0,
    rate: Annotated[
        float, typer.Option(metavar="HZ", help="Messages per second.", min=5.0, max=100.0)
    ] = RATE_HZ,
    router: Annotated[
        str | None, typer.Option(metavar="ENDPOINT", help="Over Zenoh, by this router, instead of DDS.")
    ] = None,
    write_files: Annotated[
        Path | None, typer.Option("--write-files", metavar="DIR", help="Write the robots' files there first.")
    ] = None,
    apart: Annotated[bool, typer.Option("--apart", help="Each robot in a process of its own.")] = False,
    only: Annotated[
        str | None,
        typer.Option("--only", metavar="NAME", help="One of them alone, or the referee.", hidden=True),
    ] = None,
    parent: Annotated[int, typer.Option("--parent", metavar="PID", help="Who began it.", hidden=True)] = 0,
    seconds: Annotated[float, typer.Option(help="End after so long; on Ctrl-C unless given.", min=0.1)] = inf,
    as_json: Json = False,
) -> None:
    """Simulate the robots of a world in physics (MuJoCo), each as a ROS 2 robot in a namespace of its own.

    They publish Range, LaserScan, Odometry, Image and places of targets, and obey Twist; without a command for 0.15 s
    they stop.

    [dim]understudy robots simulate soccer --write-files .[/]
    """
    from msgspec.structs import replace

    from understudy.robots.ros.dds import DdsTransport
    from understudy.robots.ros.zenoh import ZenohTransport
    from understudy.sim_mujoco.model import check_physics
    from understudy.sim_mujoco.processes import REFEREE
    from understudy.sim_mujoco.robot_files import check_ros, list_robot_names
    from understudy.sim_mujoco.ros_robots import drop_derived_readings
    from understudy.ui.cli.options import open_scenario
    from understudy.ui.cli.output import make_console, print_json

    out = make_console(err=as_json)
    scenario = open_scenario(world)
    check_physics(scenario)
    check_ros(scenario)
    names = list_robot_names(scenario)
    with _leaving_orderly() as left:
        if write_files is not None and only is None:
            known = str(Path(world).resolve()) if Path(world).is_file() else world
            _write(write_files, scenario, out, world=known, domain=domain, rate_hz=rate, router=router)
        if only is None and as_json:
            facts = {
                "world": scenario.name,
                "seed": seed,
                "domain": domain,
                "rate_hz": rate,
                "router": router,
            }
            print_json({**facts, "robots": names})
        elif only is None:
            said = ", ".join(f"/{name}" for name in names)
            out.print(
                f"{scenario.name} (seed {seed}): {said} on domain {domain}, {rate:g} Hz. Ctrl-C stops it."
            )
        if apart and only is None:
            _apart([*names, REFEREE], left, seconds=seconds)
            return
        # One of several ends with the process that began all of them, however that ends.
        late = _simulate(
            drop_derived_readings(replace(scenario, tick_s=1.0 / rate)),
            seed,
            DdsTransport(domain) if router is None else ZenohTransport(domain, router),
            only,
            seconds=seconds,
            stopped=lambda: left.is_set() or (parent != 0 and os.getppid() != parent),
        )
    if late:
        out.print(f"{late} ticks came late: this machine is too slow for {rate:g} Hz with as many robots.")


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
    """Write the files of all robots, and of the team; what is there and says something else is left, and told of."""
    from understudy.robots.robot_file import parse_robot
    from understudy.sim_mujoco.robot_files import format_robot_file, format_team_file, list_robot_names
    from understudy.storage.atomic_write import convert_os_errors, write_atomically

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
    """All leave on SIGTERM as on Ctrl-C, which some shells keep away from what runs behind them.

    The event is set, too: an interrupt is lost that comes while something is called back that cannot raise.
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
    """Until the time is over or somebody ends it; how many ticks came late."""
    try:
        return _what(scenario, seed, transport, only).run(seconds=seconds, stopped=stopped)
    except KeyboardInterrupt:
        return 0
    finally:
        transport.close()


def _what(
    scenario: Scenario, seed: int, transport: Transport, only: str | None
) -> Simulation | RobotProcess | ObjectServer:
    """All robots; or one of them, or the referee, whose fellows are in processes of their own."""
    from understudy.errors import UnknownName
    from understudy.sim_mujoco.body import MujocoBody
    from understudy.sim_mujoco.processes import REFEREE, ObjectServer, RobotProcess
    from understudy.sim_mujoco.robot_files import list_robot_names
    from understudy.sim_mujoco.ros_robots import Simulation

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
    """This same command once more for each of them, in processes of their own; all end with this one."""
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
