"""`understudy robots simulate`: robots of a scenario in physics, as ROS 2 robots, for who has no hardware."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import Annotated

import typer

RATE_HZ = 20.0


def simulate(
    world: Annotated[str, typer.Argument(metavar="WORLD", help="A built-in world, or a scenario's file.")],
    seed: Annotated[int, typer.Option(help="Where everything is at first.", min=0)] = 0,
    domain: Annotated[int, typer.Option(help="ROS_DOMAIN_ID.", min=0, max=232)] = 0,
    rate: Annotated[
        float, typer.Option(metavar="HZ", help="Messages per second.", min=5.0, max=100.0)
    ] = RATE_HZ,
    write_files: Annotated[
        Path | None, typer.Option("--write-files", metavar="DIR", help="Write the robots' files there first.")
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
    from understudy.physics.body import Physics
    from understudy.physics.robot_files import names_of_robots, robot_file, team_file
    from understudy.physics.ros import Simulation
    from understudy.robots.dds import DDS

    out = console()
    scenario = find_world(world)
    body = Physics(replace(scenario, tick_s=1.0 / rate), [seed])
    names = names_of_robots(scenario)
    if write_files is not None:
        known = str(Path(world).resolve()) if Path(world).is_file() else world
        files = {
            f"{name}.toml": robot_file(scenario, number, world=known, domain=domain, rate_hz=rate)
            for number, name in enumerate(names)
        }
        if len(names) > 1:
            files["team.toml"] = team_file(scenario)
        with failing(write_files, "writing the robots' files"):
            write_files.mkdir(parents=True, exist_ok=True)
            for name, content in files.items():
                write(write_files / name, content.encode())
                out.print(f"Wrote {write_files / name}", soft_wrap=True, markup=False)
    transport = DDS(domain)
    try:
        simulation = Simulation(body, transport)
        said = ", ".join(f"/{name}" for name in names)
        out.print(f"{scenario.name} (seed {seed}): {said} on domain {domain}, {rate:g} Hz. Ctrl-C ends it.")
        late = simulation.run(seconds=seconds)
    except KeyboardInterrupt:
        late = 0
    finally:
        transport.close()
    if late:
        out.print(f"{late} ticks came late: this machine is too slow for {rate:g} Hz with as many robots.")
