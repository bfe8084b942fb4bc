"""Run CollectivePatrol over DDS: four simulated robots, each in its own process, all controlled by this one.

python -m understudy_lab.sim_to_sim.multiprocess_patrol --seconds 600
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from understudy.addons.bridges.mujoco.processes import OBJECTS, POSES
from understudy.addons.bridges.mujoco.shapes import AWAY_M
from understudy.addons.robots.fleet import Fleet, connect_team
from understudy.addons.robots.robot_file import load_team
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import UnderstudyError
from understudy.records.messages import decode_message
from understudy_lab.lossy_networks.distributed_patrol import make_live_team, wait_for, wait_for_readings
from understudy_lab.patrol import practice
from understudy_lab.patrol.metrics import count_cycles
from understudy_lab.patrol.tracks import PatrolTracks, make_tracks


def patrol(
    seed: int, *, world: int, seconds: float, domain: int, together: bool = False, tick_s: float = 0.1
) -> dict[str, Any]:
    """Teach a patrol, run it for `seconds` in a simulated world, and return the measured cycles and timing.

    `together` runs all robots in one process; `tick_s` is the time between two decisions.
    """
    libraries = practice.teach(seed).libraries
    with TemporaryDirectory() as folder:
        options = ["--domain", str(domain), "--seed", str(world), "--write-files", folder]
        options += [] if together else ["--apart"]
        command = [sys.executable, "-m", "understudy.ui.cli", "robots", "simulate", "patrol", *options]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as simulated:
            try:
                with _joined(Path(folder) / "team.toml", tick_s) as fleet:
                    return _watched(
                        fleet, libraries, seconds=seconds, domain=domain, simulation=simulated.pid
                    )
            finally:
                simulated.terminate()
                simulated.wait(20.0)


def _joined(path: Path, tick_s: float) -> Fleet:
    """Connect to all robots and return the fleet once each sends all its sensor values."""
    wait_for(path)
    for each in load_team(path)[1]:
        each.write_text(each.read_text().replace("\ntick_s = 0.1\n", f"\ntick_s = {tick_s:g}\n"))
    fleet = connect_team(path)
    try:
        wait_for_readings(fleet)
    except TimeoutError:
        fleet.close()
        raise
    return fleet


def _watched(fleet: Fleet, libraries: Any, *, seconds: float, domain: int, simulation: int) -> dict[str, Any]:
    twin = DigitalTwin(fleet)
    team, ordered = make_live_team(twin, libraries)
    objects = ObjectPoses(domain)
    rows: list[tuple[Any, ...]] = []
    fleet.arm("an experiment")
    began, cpu_s = time.monotonic(), _spent_s(simulation)
    due, late, armed = began, 0, 1
    while time.monotonic() - began < seconds:
        team.tick()
        if not all(robot.armed for robot in fleet):  # as a person would, who looks after it
            armed += _armed_again(fleet)
        robots = twin.view().robots
        if things := objects.now():
            rows.append((ordered.now()[0].copy(), robots.x, robots.y, things))
        due += twin.tick_s
        if (left := due - time.monotonic()) > 0:
            time.sleep(left)
        else:
            late, due = late + 1, time.monotonic()
    spent, used_s = time.monotonic() - began, _spent_s(simulation) - cpu_s
    stops = [stop for robot in fleet for stop in robot.stops]
    objects.close()
    return {
        "seconds": round(spent, 1),
        **(count_cycles(_make_tracks(rows, twin.tick_s)) if rows else {}),
        "late_ticks": late,
        "armed": armed,
        "stops": [f"{each.robot}: {each.cause}" for each in stops],
        "cores": round(used_s / spent, 3),
    }


def _spent_s(simulation: int) -> float:
    """Return the CPU time in s of this process and its child processes except the simulation (Linux only)."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    spent = used.ru_utime + used.ru_stime
    for each in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            _, _, after = each.read_text().rpartition(")")
            parent, user, system = (int(after.split()[k]) for k in (1, 11, 12))
            if parent == os.getpid() and int(each.parent.name) != simulation:
                spent += (user + system) / os.sysconf("SC_CLK_TCK")
    return spent


def _armed_again(fleet: Fleet) -> bool:
    try:
        fleet.arm("an experiment")
    except UnderstudyError:
        return False
    return True


class ObjectPoses:
    """The latest positions of all objects, as published by the simulation."""

    def __init__(self, domain: int) -> None:
        self._last: list[tuple[float, float, bool]] = []
        self._transport = DdsTransport(domain)
        self._transport.subscribe(OBJECTS, POSES, self._heard)

    def _heard(self, data: bytes, _: float) -> None:
        self._last = [
            (each.position.x, each.position.y, each.position.z > AWAY_M / 2)
            for each in decode_message(POSES, data).poses
        ]

    def now(self) -> list[tuple[float, float, bool]]:
        """Return x, y (m) and presence of each object slot."""
        return self._last

    def close(self) -> None:
        """Leave the DDS domain."""
        self._transport.close()


def _make_tracks(rows: list[tuple[Any, ...]], tick_s: float) -> PatrolTracks:
    """Return recorded rows, of which each has positions of objects, as tracks."""
    doing, x, y, things = (np.array(column) for column in zip(*rows, strict=True))
    home, intruder, boss = things[:, :: practice.scenario().spare_objects + 1].transpose(1, 0, 2)[:3]
    places = np.stack([x, y], axis=-1)
    return make_tracks(tick_s, doing, places, intruder=intruder, boss=boss, home=home[-1, :2])


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    settings = vars(arguments)
    return {"tick_s": settings.pop("tick"), **settings}


def main() -> None:
    """Run from the command line and print one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1000, help="of the teaching")
    parser.add_argument("--world", type=int, default=1, help="seed of the simulated world")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--domain", type=int, default=92)
    parser.add_argument("--together", action="store_true", help="all robots in one process")
    parser.add_argument("--tick", type=float, default=0.1, help="seconds from one decision to the next")
    result = patrol(**_settings(parser.parse_args()))
    sys.stdout.write(json.dumps(result) + "\n")


if __name__ == "__main__":
    main()
