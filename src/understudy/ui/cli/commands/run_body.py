"""Mode `understudy run` with a body of the user's own: show its readings, or draw it if it has a method `render`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.live import Live
from rich.text import Text

from understudy.clock import REAL_TIME, Clock
from understudy.errors import SettingError
from understudy.model.features import format_reading_label
from understudy.records.header import RunInfo
from understudy.runtime.body import list_reading_keys
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.runtime.thinning_buffer import ThinningBuffer
from understudy.sim.body_world import BodyWorld
from understudy.storage.atomic_write import convert_os_errors
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import RunAssignment, assign_run, choose_kit
from understudy.ui.cli.output import make_console
from understudy.ui.cli.recorded_runs import (
    DRAWING,
    PICTURE_REMEDY,
    PICTURES,
    check_record_place,
    describe_body_run,
    is_recording,
    record_ticks,
)
from understudy.ui.terminal.body_readings import render_body_readings
from understudy.viz.picture_files import write_picture_gif, write_picture_png

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from understudy.addons.bridges.environments.body_maker import BodyMaker
    from understudy.ui.cli.run_options import SimulatedRunOptions

LIMIT_S = 60.0
"""How long a run lasts whose body has no end and for which no time was given, s."""
PICTURES_PER_S = 16.0
MOST_PICTURES = 300
REFRESHES_PER_S = 12.0


def run_on_body(options: SimulatedRunOptions, maker: BodyMaker) -> None:
    """Run a behavior on a body of the user's own; show its readings in the terminal, or draw it."""
    _check_options(options)
    kit = choose_kit(options.kit, maker)
    assigned = assign_run(maker, options.behavior, options.library, kit, options.bind)
    running = BodyRunSession(options, maker, assigned)
    record = options.record
    drawn = record is not None and not is_recording(record)
    try:
        with record_ticks(
            record, running.world, running.run.tick, lambda: running.paths, ran=running.make_run_info
        ) as running.tick:
            if drawn:
                _draw(running, options)
            elif record is None and not options.as_json and make_console().is_terminal:
                _watch(running, options.speed)
            else:
                while not running.is_over:
                    running.tick()
        result = running.result()
    finally:
        running.world.close()
    if options.as_json:
        print_json(result)
        return
    make_console().print(_format_ending(result), markup=False, soft_wrap=True)
    if record is not None:
        made = "Drawn" if drawn else "Recorded"
        make_console().print(f"{made} in {record}", markup=False, soft_wrap=True)


def _check_options(options: SimulatedRunOptions) -> None:
    """Refuse what needs to know where robots are."""
    where = "run"
    if options.trace is not None:
        problem = "is not written of a body of your own, which has no positions"
        remedy = "record it with --record FILE.mcap"
        raise SettingError(where=where, setting="--trace", problem=problem, remedy=remedy)
    record = options.record
    if record is not None and not is_recording(record) and record.suffix.lower() not in PICTURES:
        problem = f"is {str(record)!r}, neither a picture nor a recording"
        remedy = "name a file that ends in .gif (in motion), .png (the last picture) or .mcap (all readings)"
        raise SettingError(where=where, setting="--record", problem=problem, remedy=remedy)
    check_record_place(record)


@dataclass(frozen=True, slots=True)
class BodyRunResult:
    """Result of a run as `--json` prints it; `readings` has a value for each agent, None where it is absent."""

    behavior: str
    world: str
    seed: int
    robots: int
    seconds: float
    over: bool
    path: tuple[str, ...] | None
    doing: Mapping[str, int]
    readings: Mapping[str, Sequence[float | None]]
    record: str | None


class BodyRunSession:
    """The run of one behavior by all agents of a body."""

    def __init__(self, options: SimulatedRunOptions, maker: BodyMaker, assigned: RunAssignment) -> None:
        program = link(assigned.libraries[assigned.sort], assigned.behavior, assigned.binding)
        self.world: BodyWorld = BodyWorld(maker, options.seed, name=maker.name)
        self.run: Run = Run.from_program(self.world, program)
        self.tick: Callable[[], None] = self.run.tick
        """Advances it by one tick; it is recorded there."""
        self._program, self._assigned, self._maker = program, assigned, maker
        self.behavior, self._options, self._flags = assigned.behavior, options, assigned.flags
        self._limit_s = options.seconds or LIMIT_S

    def make_run_info(self) -> RunInfo:
        """Describe the run for the header of its recording, so that its decisions can be made again."""
        options = self._options
        return describe_body_run(
            self._program,
            self._assigned,
            world=self._maker.name,
            seed=options.seed,
            library=options.library,
            kit=options.kit,
        )

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """Active states of each agent, outermost first; of a basic behavior, its name."""
        return [self.run.path(agent) or (self.behavior,) for agent in range(self.world.agents)]

    @property
    def is_over(self) -> bool:
        """Whether the body's episode or the time is over, or all agents have raised a flag."""
        if self.world.is_over or self.world.time_s >= self._limit_s - 1e-9:
            return True
        return any(bool(self.run.find_raised(flag).all()) for flag in self._flags)

    def list_readings(self) -> dict[str, list[float | None]]:
        """Return the present value of all readings of each agent."""
        percept = self.world.sense(list_reading_keys(self.world))
        return {
            format_reading_label(key): [None if isnan(value) else value for value in column.tolist()]
            for key, column in percept.items()
        }

    def result(self) -> BodyRunResult:
        """Return the result of the run so far."""
        world, paths, record = self.world, self.paths, self._options.record
        return BodyRunResult(
            behavior=self.behavior,
            world=world.name,
            seed=self._options.seed,
            robots=world.agents,
            seconds=round(world.time_s, 6),
            over=world.is_over,
            path=paths[0] if world.agents == 1 else None,
            doing=dict(Counter(path[0] for path in paths).most_common()),
            readings=self.list_readings(),
            record=None if record is None else str(record),
        )


def _format_ending(result: BodyRunResult) -> str:
    """Describe how the run ended in a sentence."""
    if result.over:
        ended = "the episode is over"
    elif result.path is not None:
        ended = f"in {result.path[-1]}"
    else:
        ended = ", ".join(f"{name} {number}" for name, number in result.doing.items())
    total = result.readings.get("return")
    returned = f"; return {total[0]:g}" if total and len(total) == 1 and total[0] is not None else ""
    return (
        f"{result.behavior} in {result.world} {result.seed}: {ended} after {result.seconds:.1f} s{returned}"
    )


def _draw(running: BodyRunSession, options: SimulatedRunOptions) -> None:
    """Run to the end and draw the body into the file of --record."""
    if options.record is None or not running.world.has_picture:
        problem = f"needs pictures, and {running.world.name} makes a body without any"
        remedy = 'give it a method render that returns one, or an environment render_mode="rgb_array"'
        raise SettingError(where="run", setting="--record", problem=problem, remedy=remedy)
    moving, world = options.record.suffix.lower() == ".gif", running.world
    kept: ThinningBuffer[NDArray[np.uint8]] = ThinningBuffer(MOST_PICTURES)
    due = world.time_s
    while True:
        over = running.is_over
        if over or (moving and world.time_s >= due - 1e-9):
            picture = world.render()
            if picture is not None:
                kept.append(picture)
            due += options.speed / PICTURES_PER_S
        if over:
            break
        running.tick()
    with convert_os_errors(options.record, DRAWING, remedy=PICTURE_REMEDY):
        if moving:
            write_picture_gif(kept.items, options.record, per_s=PICTURES_PER_S)
        else:
            write_picture_png(kept.items[-1], options.record)


def _watch(running: BodyRunSession, speed: float, clock: Clock = REAL_TIME) -> None:
    """Show states and readings in the terminal while the run goes on; Ctrl-C ends it."""
    out, world, step = make_console(), running.world, speed / REFRESHES_PER_S
    with Live(console=out, auto_refresh=False, transient=False) as live:
        due = clock()
        while True:
            live.update(render_body_screen(running, lines=out.height - 4), refresh=True)
            if running.is_over:
                return
            until = world.time_s + step
            while world.time_s < until and not running.is_over:
                running.tick()
            due += 1.0 / REFRESHES_PER_S
            clock.sleep(due - clock())


def render_body_screen(running: BodyRunSession, *, lines: int) -> RenderableType:
    """Render the active states and the readings; of several agents, those of the first one."""
    world = running.world
    more = f"  the first of {world.agents} agents" if world.agents > 1 else ""
    return Group(
        Text(" > ".join(running.paths[0]), style="bold", no_wrap=True, overflow="ellipsis"),
        Text.assemble((f"{world.time_s:6.1f} s", "bold"), (more, "dim")),
        render_body_readings(world, 0, lines=lines),
        Text("Ctrl-C ends it", style="dim"),
    )
