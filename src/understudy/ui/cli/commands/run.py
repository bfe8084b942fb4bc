"""Command `understudy run`: run a behavior in a simulated world, and show, draw, record or trace it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rich import box
from rich.console import Group, RenderableType
from rich.live import Live
from rich.markup import escape
from rich.panel import Panel
from rich.text import Text

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.clock import REAL_TIME, Clock
from understudy.errors import SettingError
from understudy.judging.run_header import trace_entry
from understudy.records.trace_writer import (
    TraceWriter,
    add_team_tick,
    check_trace_path,
    describe_trace_columns,
    write_trace,
)
from understudy.sim.catalog import locate_scenario
from understudy.sim.scenario.schema import Goal, Scenario
from understudy.sim.team.libraries import make_team
from understudy.sim.view import RunFrame, WorldView
from understudy.sim.world import World
from understudy.storage.atomic_write import convert_os_errors
from understudy.ui.cli.commands.run_body import run_on_body
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, choose_kit
from understudy.ui.cli.output import make_console
from understudy.ui.cli.recorded_runs import (
    DRAWING,
    PICTURE_REMEDY,
    PICTURES,
    check_record_place,
    is_recording,
    make_run_info,
    record_team_ticks,
)
from understudy.ui.cli.run_options import SimulatedRunOptions
from understudy.ui.terminal.world_view import describe_followed_robot, fit_arena, render_world
from understudy.viz.path_png import draw_path_png
from understudy.viz.run_gif import FrameBuffer, draw_run_gif

if TYPE_CHECKING:
    from understudy.records.header import RunInfo
    from understudy.runtime.team.team import Team

FRAMES_PER_S = 12.0
IDLES = "idles"


def run_behavior(options: SimulatedRunOptions) -> None:
    """Run a behavior in a scenario's world, on all robots that have it, and show, draw or record the run."""
    opened = find_world(options.world_name)
    if isinstance(opened, Scenario):
        run_in_scenario(options, opened)
    else:
        run_on_body(options, opened)


def run_in_scenario(options: SimulatedRunOptions, world: Scenario) -> None:
    """Run a behavior in a simulated world; show it in the terminal, or draw, record or trace it."""
    record = options.record
    _check_record(record)
    if options.trace is not None:
        check_trace_path(options.trace)
    running = RunSession.from_options(options, world)
    shown = record is None and not options.as_json and make_console().is_terminal
    with (
        record_team_ticks(record, running.team, ran=running.make_run_info) as running.tick_team,
        running.open_trace(options.trace) as trace,
    ):
        frames = _watch(running, options.speed, trace) if shown else _record(running, trace)
    if record is not None and not is_recording(record):
        title = f"{running.behavior} in {running.body.scenario.name}, seed {options.seed}"
        _draw(frames, record, title=title, speed=options.speed)
    if options.as_json:
        print_json(running.result())
        return
    make_console().print(_ending(running.result()))
    if record is not None:
        made = "Recorded" if is_recording(record) else "Drawn"
        make_console().print(f"{made} in {record}", markup=False, soft_wrap=True)
    if options.trace is not None:
        make_console().print(f"Traced in {options.trace}", markup=False, soft_wrap=True)


def _check_record(record: Path | None) -> None:
    """Refuse a file that is neither a picture nor a recording, or that cannot be written."""
    if record is not None and not is_recording(record) and record.suffix.lower() not in PICTURES:
        remedy = "name a file that ends in .gif (in motion), .png (its path) or .mcap (all readings)"
        raise SettingError(
            where="--record",
            setting=repr(str(record)),
            problem="is neither a picture nor a recording",
            remedy=remedy,
        )
    check_record_place(record)


@dataclass(frozen=True, slots=True)
class SimulatedRunResult:
    """Result of a simulated run as `--json` prints it; None where a value does not apply."""

    behavior: str
    world: str
    seed: int
    robots: int
    seconds: float
    goal: str | None
    success: bool | None
    delivered: int
    total: int
    gathered: int
    path: tuple[str, ...] | None
    doing: dict[str, int]
    record: str | None


class RunSession:
    """Run of one behavior in a simulated world, by the robots or by the coordinators of a squad."""

    def __init__(self, options: SimulatedRunOptions, team: Team, assigned: RunAssignment) -> None:
        if not isinstance(team.ground, World):
            raise TypeError("a team of real robots")
        self.team, self.body, self.behavior = team, team.ground, assigned.behavior
        self.tick_team = team.tick
        self._options, self._assigned = options, assigned
        self._limit_s = options.seconds or self.body.scenario.limit_s
        sorts = list(assigned.roots)
        self._sort = sorts[0]
        alone = [name for name in sorts if name in team.tree.types]
        kinds = [team.tree.types[kind] for kind in team.tree.type_of]
        self._rests = [self.behavior if kind in alone else IDLES for kind in kinds]
        self._flags = assigned.flags

    @classmethod
    def from_options(cls, options: SimulatedRunOptions, where: Scenario) -> RunSession:
        """Make the run that the options describe in a scenario, before its first tick."""
        kit = choose_kit(options.kit, where)
        assigned = assign_run(where, options.behavior, options.library, kit, options.bind)
        team = make_team(where, [options.seed], assigned.libraries, assigned.roots)
        return cls(options, team, assigned)

    def make_run_info(self) -> RunInfo:
        """Describe the run for the header of its trace or recording, so that it can be repeated."""
        options = self._options
        return make_run_info(
            self.team.programs,
            self._assigned,
            options.library,
            scenario=locate_scenario(options.world_name),
            seed=options.seed,
            kit=options.kit,
        )

    def open_trace(self, path: Path | None) -> AbstractContextManager[TraceWriter | None]:
        """Open the writer of its trace, or a null context if `path` is None."""
        if path is None:
            return nullcontext()
        body, seed = self.body, self._options.seed
        ran = trace_entry(self.make_run_info(), body.scenario)
        return write_trace(
            path,
            scenario=body.scenario.name,
            seed=seed,
            tick_s=body.tick_s,
            robots=body.robots,
            run=ran,
            columns=describe_trace_columns(self.team),
        )

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """Active states of each robot, outermost first; without an automaton, the basic behavior or 'idles'."""
        return [path or (rests,) for path, rests in zip(self.team.paths, self._rests, strict=True)]

    @property
    def frame(self) -> RunFrame:
        """Current state of the world and the robots, for drawing."""
        return RunFrame(self.body.view(), [path[0] for path in self.paths])

    @property
    def finished(self) -> bool:
        """Whether the scenario's goal was reached."""
        return bool(self.body.finished_s[0] >= 0)

    @property
    def is_over(self) -> bool:
        """Whether the goal is reached, the time is over, or all robots of the behavior have raised a flag."""
        if self.finished or self.body.time_s >= self._limit_s - 1e-9:
            return True
        return bool(self._flags) and bool(self.team.find_raised(self._sort, self._flags).all())

    def tick(self, trace: TraceWriter | None) -> None:
        """Advance by one tick, and add it to the trace if there is one."""
        self.tick_team()
        if trace is not None:
            view = self.body.view()
            add_team_tick(trace, self.team, view.time_s, view.pose, self.paths)

    def result(self) -> SimulatedRunResult:
        """Return the result of the run so far."""
        body, paths, record = self.body, self.paths, self._options.record
        goal = body.scenario.goal
        return SimulatedRunResult(
            behavior=self.behavior,
            world=body.scenario.name,
            seed=self._options.seed,
            robots=body.robots,
            seconds=round(body.time_s, 6),
            goal=None if goal is None else _goal(goal),
            success=None if goal is None else self.finished,
            delivered=int(body.delivered[0]),
            total=int(body.total[0]),
            gathered=int(body.gathered[0]),
            path=paths[0] if body.robots == 1 else None,
            doing=dict(Counter(path[0] for path in paths).most_common()),
            record=None if record is None else str(record),
        )


def _goal(goal: Goal) -> str | None:
    """Return the kind of goal in a word: delivered, gathered, or the name of the target."""
    return "delivered" if goal.delivered else "gathered" if goal.gathered else goal.target


def _ending(result: SimulatedRunResult) -> str:
    """Describe how the run ended in a sentence."""
    if result.success:
        homes = {"delivered": "all food is home", "gathered": "enough boxes are home"}
        ended = f"[green]{homes.get(result.goal or '', 'goal reached')}[/]"
    elif result.path:
        ended = f"[yellow]in {escape(result.path[-1])}[/]"
    else:
        doing = ", ".join(f"{name} {number}" for name, number in result.doing.items())
        ended = f"[yellow]{result.robots} robots: {escape(doing)}[/]"
    brought = f"; brought {result.delivered} of {result.total} units home" if result.total else ""
    if result.gathered:
        brought += f"; gathered {result.gathered} box{'es' * (result.gathered > 1)}"
    where = "world" if result.world == "forage" else f"{result.world} world"
    return f"{result.behavior} in {where} {result.seed}: {ended} after {result.seconds:.1f} s{brought}"


def _record(running: RunSession, trace: TraceWriter | None) -> list[RunFrame]:
    recording = FrameBuffer()
    recording.append(running.frame)
    while not running.is_over:
        running.tick(trace)
        recording.append(running.frame)
    return recording.frames


def _watch(
    running: RunSession, speed: float, trace: TraceWriter | None, clock: Clock = REAL_TIME
) -> list[RunFrame]:
    """Show the run in the terminal while it runs; Ctrl-C ends it."""
    out, body = make_console(), running.body
    step = speed / FRAMES_PER_S
    with Live(console=out, auto_refresh=False, transient=False) as live:
        due = clock()
        while True:
            view = body.view()
            live.update(
                render_run_screen(view, running.paths, wide=out.width, tall=out.height - 6), refresh=True
            )
            if running.is_over:
                return []
            until = body.time_s + step
            while body.time_s < until and not running.is_over:
                running.tick(trace)
            due += 1.0 / FRAMES_PER_S
            clock.sleep(due - clock())


def _draw(frames: list[RunFrame], path: Path, *, title: str, speed: float) -> None:
    with convert_os_errors(path, DRAWING, remedy=PICTURE_REMEDY):
        if path.suffix.lower() == ".gif":
            draw_run_gif(frames, path, speed=speed)
        else:
            draw_path_png(frames, path, title=title)


def render_run_screen(
    view: WorldView, paths: Sequence[Sequence[str]], *, wide: int, tall: int
) -> RenderableType:
    """Render the world, the active states of its robot (of several: counts per state), and its readings."""
    columns, lines = fit_arena(view, wide - 2, max(tall - 2, 6))
    drawn = render_world(view, columns=columns, lines=lines, robot=0 if len(paths) == 1 else None)
    known = Text.assemble((f"{view.time_s:6.1f} s", "bold"), "   ", describe_followed_robot(view, wide))
    return Group(
        Panel(drawn, box=box.ROUNDED, width=columns + 2, padding=0, border_style="dim"),
        Text(_doing(paths), style="bold", no_wrap=True, overflow="ellipsis"),
        known,
        Text("Ctrl-C ends it", style="dim"),
    )


def _doing(paths: Sequence[Sequence[str]]) -> str:
    if len(paths) == 1:
        return " > ".join(paths[0]) or "idle"
    counts = Counter(path[0] if path else "idle" for path in paths)
    return "   ".join(f"{name} {count}" for name, count in sorted(counts.items()))
