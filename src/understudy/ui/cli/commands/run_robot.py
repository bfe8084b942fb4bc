"""Command `understudy robots run`: run a behavior on real robots; a person arms them, any key stops them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.live import Live as Screen

from understudy.addons.robots.diagnostics import diagnose_connection
from understudy.addons.robots.twin import DigitalTwin
from understudy.clock import REAL_TIME
from understudy.errors import SettingError, join_names
from understudy.runtime.agents.local_team import LocalTeam
from understudy.runtime.agents.network import LocalNetwork, make_fate
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, choose_kit
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.recorded_runs import make_run_info
from understudy.ui.cli.robot_connection import connect_twin, split_robots_file
from understudy.ui.cli.run_options import RobotRunOptions

if TYPE_CHECKING:
    from understudy.addons.robots.fleet import Fleet


LISTEN_S = 2.0
SHOWN_S = 0.1
BY = "the terminal"
NO_RECORDING = "none"
"""What `--record` is given in place of a file."""
LOOK_S, LOOKS = 0.005, 40
"""The time between two looks at a simulation's clock, s, and how many there are before keys are looked at."""


@dataclass(frozen=True, slots=True)
class RobotRunResult:
    """Result of a run on real robots, as `--json` prints it."""

    behavior: str
    robots: list[str]
    seconds: float
    ticks: int
    late_ticks: int
    ended: str
    doing: list[tuple[str, ...]]


def run_on_robots(options: RobotRunOptions) -> None:
    """Run a behavior on real robots. A person arms them in the terminal, and any key stops them."""
    recorded = options.record != NO_RECORDING
    record = Path(options.record) if options.record is not None and recorded else None
    with connect_twin(*split_robots_file(options.file), record=record, recorded=recorded) as twin:
        run_on_twin(twin, options)


def run_on_twin(twin: DigitalTwin, options: RobotRunOptions) -> None:
    """Run a behavior on connected robots until it is done, the time is over, or a key stops it."""
    result = _run(twin, options)
    if options.as_json:
        print_json(result)
        return
    late = f", {result.late_ticks} of them late" if result.late_ticks else ""
    said = f"{result.behavior}: {result.ended} after {result.ticks} ticks{late}. Stopped."
    make_console().print(said, markup=False)


def _run(twin: DigitalTwin, options: RobotRunOptions) -> RobotRunResult:
    fleet = twin.fleet
    _see_person(fleet)
    kit = choose_kit(options.kit, twin.scenario)
    assigned = assign_run(twin.scenario, options.behavior, options.library, kit, options.bind)
    live = LiveRun(twin, assigned.libraries, assigned.roots)
    twin.follow(lambda: live.team.paths)
    _looked_over(live)
    _armed_by_a_person(fleet, assigned.behavior)
    live.restart()
    began_s = twin.time_s
    twin.record(
        make_run_info(live.team.programs, assigned, options.library, scenario=None, seed=0, kit=options.kit)
    )
    ended = _go(live, assigned, options.seconds)
    fleet.disarm(f"the run ended: {ended}")
    return RobotRunResult(
        behavior=assigned.behavior,
        robots=[robot.file.name for robot in fleet],
        seconds=round(twin.time_s - began_s, 3),
        ticks=live.ticks,
        late_ticks=live.late,
        ended=ended,
        doing=list(live.team.paths),
    )


def _see_person(fleet: Fleet) -> None:
    """Refuse to run without a terminal, or on robots that need a held key: a person has to arm and stop them."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise SettingError(
            where="understudy robots run",
            setting="its input or output",
            problem="is not a terminal, so a robot could not be armed or stopped",
            remedy="run it in one (ssh -t HOST for another machine), or arm it from Python with Robot.arm",
        )
    if fleet.needs_hold_to_run:
        raise SettingError(
            where=fleet.name,
            setting="safety.hold_to_run",
            problem="needs a key that is held, and a terminal does not report released keys",
            remedy="let it go in the studio: understudy robots studio FILE",
        )


def _looked_over(live: LiveRun) -> None:
    """Decide for 2 s without moving any robot, then print the problems of each robot.

    The person decides whether to continue. What takes longer the first time is done by then.
    """
    fleet = live.twin.fleet
    typer.echo(f"Listening to {', '.join(robot.file.name for robot in fleet)} ...", err=True)
    until = REAL_TIME() + LISTEN_S
    while REAL_TIME() < until:
        live.tick()
    for robot in fleet:
        for problem in diagnose_connection(robot, seconds=0.0).problems:
            typer.echo(f"{robot.file.name}: {problem}", err=True)


def _armed_by_a_person(fleet: Fleet, behavior: str) -> None:
    for robot in fleet:
        if drives := [name for name, skill in robot.file.skills.items() if skill.moves]:
            typer.echo(
                f"{robot.file.name}: the limits of speed do not hold while {join_names(drives)} drives it.",
                err=True,
            )
    typer.echo(
        f"{fleet.name} will run {behavior}. Any key stops it. Type arm and Enter to let it move:", err=True
    )
    if sys.stdin.readline().strip().lower() != "arm":
        raise SettingError(
            where=fleet.name, setting="arming", problem="was not confirmed; nothing moved",
            remedy="type arm to let it move",
        )  # fmt: skip
    fleet.arm(BY)


def _go(live: LiveRun, assigned: RunAssignment, seconds: float | None) -> str:
    """Tick until the run ends, and return why it ended."""
    twin, until, flags = live.twin, inf, assigned.flags
    with (
        _keys() as pressed,
        Screen(console=make_console(err=True), auto_refresh=False, transient=True) as display,
    ):
        shown = -SHOWN_S
        while True:
            live.tick()
            if seconds is not None and until == inf:
                until = twin.time_s + seconds
            if pressed():
                twin.fleet.emergency_stop("a key was pressed in the terminal")
                return "stopped by a key"
            if not twin.fleet.armed:
                return "; ".join(
                    f"{robot.file.name}: {robot.stop_cause}" for robot in twin.fleet if robot.stop_cause
                )
            if flags and live.team.find_raised(assigned.sort, flags).all():
                return "done"
            if twin.time_s >= until:
                return "its time is over"
            if twin.time_s - shown >= SHOWN_S:
                shown = twin.time_s
                display.update(_told(twin, live, assigned.behavior), refresh=True)


def _told(twin: DigitalTwin, live: LiveRun, rests: str) -> Any:
    made = make_table("robot", "doing", "~")
    for robot, path in zip(twin.fleet, live.team.paths, strict=True):
        doing = " > ".join(path) or rests
        made.add_row(robot.file.name, doing, robot.stop_cause and f"stands: {robot.stop_cause}")
    return made


@contextmanager
def _keys() -> Iterator[Any]:
    """Yield a function that returns whether a key was pressed, without Enter where the system supports it."""
    import select

    old = None
    with suppress(ImportError):
        import termios
        import tty

        old = termios.tcgetattr(sys.stdin)
        tty.setcbreak(sys.stdin)
    try:
        yield lambda: bool(select.select([sys.stdin], [], [], 0)[0])
    finally:
        if old is not None:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, old)


class LiveRun:
    """Agents on the robots of a digital twin, in real time; late ticks are not made up for.

    All agents are in this program and tick together. `libraries` holds the library of each sort of agents, `roots` the
    behavior that each sort outside squads runs.
    """

    def __init__(
        self,
        twin: DigitalTwin,
        libraries: Libraries,
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        clock: Callable[[], float] | None = None,
        sleep: Callable[[float], None] = REAL_TIME.sleep,
    ) -> None:
        self.twin = twin
        tree, radio = assign_team_members(twin.scenario), twin.scenario.radio
        plan = TeamPlan(
            tree,
            libraries,
            roots,
            readings=dict.fromkeys(tree.types, twin.readings),
            targets=twin.targets,
            only_led=True,
        )
        network = LocalNetwork(make_fate(round(radio.delay_s / twin.tick_s), radio.loss))
        self.team = LocalTeam(twin, plan, network)
        self._clock, self._sleep = clock or twin.fleet.simulation_clock or REAL_TIME, sleep
        self._due = self._clock()
        self.ticks = self.late = 0

    def tick(self) -> None:
        """Wait until the next tick is due, and run it; return without it if a simulation's clock stands still."""
        now = self._clock()
        if now < self._due:
            if not self._wait(now):
                return
        elif self.ticks and now > self._due + self.twin.tick_s:
            self.late += 1
            self._due = now
        self.team.tick()
        self.ticks += 1
        self._due += self.twin.tick_s

    def _wait(self, now: float) -> bool:
        """Wait for the next tick; return whether it is due."""
        if self.twin.fleet.simulation_clock is None:
            self._sleep(self._due - now)
            return True
        for _ in range(LOOKS):
            self._sleep(LOOK_S)
            if self._clock() >= self._due:
                return True
        return False

    def restart(self) -> None:
        """Restart all automata and the tick counts, for example after robots were armed."""
        self.team.clear()
        self._due = self._clock()
        self.ticks = self.late = 0
