"""Simulate the robots of the patrol as ROS 2 robots behind a Unix socket, and record where everything is.

    python -m understudy_lab.lossy_networks.simulated_robots FOLDER --seed 1

writes the robots' files and the team's file to the folder, and a line of JSON for each tick to `world.jsonl`. A Unix
socket reaches into all network namespaces of a machine.
"""

from __future__ import annotations

import json
import signal
import time
from argparse import ArgumentParser
from pathlib import Path
from threading import Event
from typing import Any, TextIO

from msgspec.structs import replace

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.robot_files import format_robot_file, format_team_file, list_robot_names
from understudy.addons.bridges.mujoco.ros_robots import Simulation, drop_derived_readings, tick_in_real_time
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy_lab.patrol import practice

WORLD, RATE_HZ = "world.jsonl", 10.0
DOMAIN = 64
TEAM = "team.toml"


def write_files(folder: Path) -> None:
    """Write the files of all robots and of their team."""
    scenario = practice.scenario()
    router = find_router(folder)
    for number, name in enumerate(list_robot_names(scenario)):
        text = format_robot_file(
            scenario, number, world=scenario.name, domain=DOMAIN, rate_hz=RATE_HZ, router=router
        )
        (folder / f"{name}.toml").write_text(text)
    (folder / TEAM).write_text(format_team_file(scenario))


def find_router(folder: Path) -> str:
    """Return the address of the robots' router."""
    return f"unixsock-stream/{folder / 'robots.sock'}"


def open_router(folder: Path) -> Any:
    """Open the router through which robots and their programs reach each other."""
    import zenoh

    config = zenoh.Config()
    settings = {
        "mode": "router",
        "listen/endpoints": [find_router(folder)],
        "scouting/multicast/enabled": False,
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


class RecordedWorld:
    """The simulation, and a file with the places and commands of robots, and the places of objects, in each tick."""

    def __init__(self, folder: Path, seed: int, file: TextIO) -> None:
        scenario = drop_derived_readings(replace(practice.scenario(), tick_s=1.0 / RATE_HZ))
        self._body, self._file = MujocoBody(scenario, [seed]), file
        self.transport = ZenohTransport(DOMAIN, find_router(folder))
        self._simulation = Simulation(self._body, self.transport)
        world = self._body.world
        first = world.rules.classes["first"]
        self._slots = {name: int(first[index]) for index, name in enumerate(world.names.classes)}

    def tick(self, now_s: float) -> None:
        """Simulate one tick, and record it."""
        state = self._body.world.state
        commands = [robot.command(now_s, deadline_s=DEADLINE_S) for robot in self._simulation.robots]
        things = {
            name: (float(thing["x"]), float(thing["y"]), bool(thing["present"]))
            for name, slot in self._slots.items()
            for thing in [state.objects[0, slot]]
        }
        line = {
            "at_s": now_s,
            "robots": [(float(each["x"]), float(each["y"])) for each in state.robots],
            "commands": [(float(drive), float(turn)) for drive, turn in commands],
            "objects": things,
        }
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()
        self._simulation.tick(now_s)


DEADLINE_S = 0.35
"""The time after the last command at which a robot stops, s; agents may be late, since all share this computer."""


def main() -> None:
    """Simulate until the program is told to end."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=0, help="of the world")
    arguments = parser.parse_args()
    ends = Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ends.set())
    router = open_router(arguments.folder)
    with (arguments.folder / WORLD).open("w") as file:
        world = RecordedWorld(arguments.folder, arguments.seed, file)
        write_files(arguments.folder)
        tick_in_real_time(world.tick, 1.0 / RATE_HZ, seconds=float("inf"), stopped=ends.is_set)
        world.transport.close()
    time.sleep(0.2)
    router.close()


if __name__ == "__main__":
    main()
