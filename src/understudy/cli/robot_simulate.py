"""`understudy robots simulate`: robots of a scenario in physics, as ROS 2 robots, for who has no hardware."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from understudy.physics.apart import Alone, Referee
    from understudy.physics.ros import Simulation
    from understudy.robots.transport import Transport
    from understudy.worlds.scenario import Scenario

RATE_HZ = 20.0
GRACE_S = 1.0
"""For so long robots in processes of their own may take to leave, before they are told to."""


def simulate(
    world: Annotated[str, typer.Argument(metavar="WORLD", help="A built-in world, or a scenario's file.")],
    seed: Annotated[int, typer.Option(help="Where everything is at first.", min=0)] = 0,
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
    seconds: Annotated[float, typer.Option(help="End after so long; on Ctrl-C unless given.", min=0.1)] = inf,
) -> None:
    """Simulate the robots of a world in physics (MuJoCo), each as a ROS 2 robot in a namespace of its own.

    They publish Range, Odometry, Image and places of targets, and obey Twist; without a command for 0.15 s they stop.

    [dim]understudy robots simulate soccer --write-files .[/]
    """
    from msgspec.structs import replace

    from understudy.cli.output import console
    from understudy.cli.parts import find_world
    from understudy.model.atomic import failing, write
    from understudy.physics.apart import REFEREE
    from understudy.physics.robot_files import names_of_robots, robot_file, team_file
    from understudy.physics.ros import served

    out = console()
    scenario = find_world(world)
    names = names_of_robots(scenario)
    if write_files is not None and only is None:
        known = str(Path(world).resolve()) if Path(world).is_file() else world
        files = {
            f"{name}.toml": robot_file(
                scenario, number, world=known, domain=domain, rate_hz=rate, router=router
            )
            for number, name in enumerate(names)
        }
        if len(names) > 1:
            files["team.toml"] = team_file(scenario)
        with failing(write_files, "writing the robots' files"):
            write_files.mkdir(parents=True, exist_ok=True)
            for name, content in files.items():
                write(write_files / name, content.encode())
                out.print(f"Wrote {write_files / name}", soft_wrap=True, markup=False)
    signal.signal(
        signal.SIGTERM, signal.default_int_handler
    )  # all leave as on Ctrl-C, which some shells keep away
    said = ", ".join(f"/{name}" for name in names)
    if only is None:
        out.print(f"{scenario.name} (seed {seed}): {said} on domain {domain}, {rate:g} Hz. Ctrl-C ends it.")
    with _leaving_orderly():
        if apart and only is None:
            _apart([*names, REFEREE], seconds=seconds)
            return
        late = _simulate(served(replace(scenario, tick_s=1.0 / rate)), seed, domain, router, only, seconds)
    if late:
        out.print(f"{late} ticks came late: this machine is too slow for {rate:g} Hz with as many robots.")


@contextmanager
def _leaving_orderly() -> Iterator[None]:
    """SIGTERM is as Ctrl-C, which some shells keep away from what runs behind them."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _simulate(
    scenario: Scenario, seed: int, domain: int, router: str | None, only: str | None, seconds: float
) -> int:
    """Until the time is over or somebody ends it; how many ticks came late."""
    from understudy.robots.dds import DDS
    from understudy.robots.zenoh import Zenoh

    transport: Transport = DDS(domain) if router is None else Zenoh(domain, router)
    parent = os.getppid()
    try:
        simulated = _what(scenario, seed, transport, only)
        # One of several ends with the process that began all of them, however that ends.
        return simulated.run(seconds=seconds, stopped=lambda: only is not None and os.getppid() != parent)
    except KeyboardInterrupt:
        return 0
    finally:
        transport.close()


def _what(
    scenario: Scenario, seed: int, transport: Transport, only: str | None
) -> Simulation | Alone | Referee:
    """All robots; or one of them, or the referee, whose fellows are in processes of their own."""
    from understudy.errors import UnknownName
    from understudy.physics.apart import REFEREE, Alone, Referee
    from understudy.physics.body import Physics
    from understudy.physics.robot_files import names_of_robots
    from understudy.physics.ros import Simulation

    if only == REFEREE:
        return Referee(scenario, seed, transport)
    body, names = Physics(scenario, [seed]), names_of_robots(scenario)
    if only is None:
        return Simulation(body, transport)
    if only not in names:
        raise UnknownName(
            what="robot", name=only, where=f"scenario {scenario.name!r}", known=[*names, REFEREE]
        )
    return Alone(body, names.index(only), transport)


def _apart(names: list[str], *, seconds: float) -> None:
    """This same command once more for each of them, in processes of their own; all end with this one."""
    began = time.monotonic()
    arguments = [each for each in sys.argv[1:] if each != "--apart"]
    command = [sys.executable, "-m", "understudy.cli", *arguments, "--only"]
    processes = [subprocess.Popen([*command, name]) for name in names]
    try:
        while time.monotonic() - began < seconds and all(each.poll() is None for each in processes):
            time.sleep(0.1)
    except KeyboardInterrupt:
        pass
    finally:
        ends = time.monotonic() + GRACE_S  # a terminal's Ctrl-C came to all of them
        while time.monotonic() < ends and any(each.poll() is None for each in processes):
            time.sleep(0.05)
        for each in processes:
            each.terminate()
        for each in processes:
            each.wait(10.0)
