"""`understudy run`: watch robots do what they were taught, or draw what they did."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.ui.cli.options import (
    LIBRARY,
    BehaviorName,
    Bind,
    Json,
    KitName,
    Library,
    SameWorld,
    ScenarioName,
)
from understudy.ui.cli.robot_options import NoRecording, RobotFile, TeamFile, twin_of
from understudy.ui.cli.robot_options import named as real

if TYPE_CHECKING:
    from rich.console import RenderableType

    from understudy.analysis.run_trace import TraceWriter
    from understudy.model.library import Library as Opened
    from understudy.runtime.team.team import Team
    from understudy.sim.scenario.schema import Goal
    from understudy.sim.team.libraries import Libraries
    from understudy.sim.view import Frame, WorldView


PICTURES = (".gif", ".png")
FRAMES_PER_S = 12.0
IDLES = "idles"


def run(
    context: typer.Context,
    scenario: ScenarioName = None,
    behavior: BehaviorName = None,
    library: Library = LIBRARY,
    world: SameWorld = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Which world.")] = 0,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record", "-r", metavar="OUT.gif|png|mcap", help="Draw it, or record it, instead of showing it."
        ),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option("--trace", metavar="OUT.jsonl|OUT.parquet", help="Keep where robots were, doing what."),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            min=0.1,
            max=86_400,
            help="End after so much simulated time, not at the scenario's limit.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", min=0.1, max=1000, help="Times as fast as in life.")
    ] = 8.0,
    replay: Annotated[
        Path | None,
        typer.Option(
            "--replay",
            metavar="FILE.mcap",
            help="Decide again over a recording, and show where decisions differ.",
            show_default=False,
        ),
    ] = None,
    bind: Bind = None,
    robot: RobotFile = None,
    team: TeamFile = None,
    no_record: NoRecording = False,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Run a behavior in a scenario's world, on all robots that know it: watch it in the terminal, or draw a GIF or PNG.

    Behaviors are those of the library, and the basic ones of the scenario's robots.

    [dim]understudy run --library demo/library --behavior forage --seed 7[/]

    [dim]understudy run --behavior goto --bind A=station --record goto.gif[/]

    [dim]understudy run patrol --behavior forwards --seconds 20[/]

    [dim]understudy run --record run.mcap[/], then [dim]understudy run --replay run.mcap --library corrected[/]

    [dim]understudy run --robot rover.toml --behavior servo[/]

    What a squad was taught (in a folder of the squad's name) is run by its coordinators. Where types of robots differ,
    each has a folder of its name, too; SORT/BEHAVIOR says whose behavior is meant.
    """
    if replay is not None:
        _only_replayed(context)
        from understudy.ui.cli.commands.run_replay import replay as again

        again(
            replay,
            library=library if _given(context, "library") else None,
            behavior=behavior,
            bind=bind,
            kit=kit,
            as_json=as_json,
        )
        return
    from understudy.analysis.run_trace import write_trace
    from understudy.errors import SettingError
    from understudy.runtime.program import link
    from understudy.sim.team.libraries import runners, sort_of, team_of
    from understudy.ui.cli.options import (
        behavior_of,
        bindings,
        chosen_world,
        find_kit,
        find_world,
        team_for,
    )
    from understudy.ui.cli.output import compile_once, console, print_json
    from understudy.ui.cli.recordings import is_recording, recording

    if real(robot, team, world=scenario or world) is not None:
        from understudy.ui.cli.commands.run_robot import run_live

        _refuse(
            context,
            ("seed", "speed", "trace"),
            "means nothing to real robots, which are recorded as they are",
        )
        with twin_of(robot, team, record=record, recorded=not no_record) as twin:
            run_live(twin, behavior, library, kit=kit, bind=bind, seconds=seconds, as_json=as_json)
        return
    if record is not None and not is_recording(record) and record.suffix.lower() not in PICTURES:
        remedy = "name a file that ends in .gif (in motion), .png (its path) or .mcap (all readings)"
        raise SettingError(
            where="--record", setting=repr(str(record)), problem="is no picture or recording", remedy=remedy
        )
    named = chosen_world(scenario, world)
    where, parts = find_world(named), find_kit(kit, named)
    bound, limit_s = bindings(bind), seconds or where.limit_s
    known = team_for(where, behavior, library, parts)
    sort = sort_of(known, behavior)
    behavior = behavior_of(known[sort], behavior and behavior.removeprefix(f"{sort}/"), library)
    link(known[sort], behavior, bound)  # mistakes are told at once, not when all is compiled
    compile_once(world=where, quiet=as_json)
    roots = dict.fromkeys(runners(known, sort, behavior), (behavior, bound))
    running = Running(team_of(where, [seed], known, roots), known[sort], list(roots), behavior, limit_s)
    shown = record is None and not as_json and console().is_terminal
    watch = _watch if shown else _record
    body = running.body

    def how() -> dict[str, Any]:
        return _how(named, kit, library, running.team, known, roots)

    with recording(record, running.team, how=how, seed=seed) as running.tick_team:
        if trace is None:
            frames = watch(running, speed, None)
        else:
            with write_trace(
                trace, scenario=where.name, seed=seed, tick_s=body.tick_s, robots=body.robots, run=how()
            ) as writer:
                frames = watch(running, speed, writer)
    if record is not None and not is_recording(record):
        _draw(frames, record, title=f"{behavior} in {where.name}, seed {seed}", speed=speed)
    facts = running.facts(seed=seed, record=record)
    if as_json:
        print_json(facts)
    else:
        console().print(_told(facts))
        if record is not None:
            made = "Recorded" if is_recording(record) else "Drawn"
            console().print(f"{made} in {record}", markup=False, soft_wrap=True)
        if trace is not None:
            console().print(f"Traced in {trace}", markup=False, soft_wrap=True)


def _given(context: typer.Context, option: str) -> bool:
    """Whether somebody gave an option, be it what it is otherwise."""
    source = context.get_parameter_source(option)
    return source is not None and source.name == "COMMANDLINE"


def _only_replayed(context: typer.Context) -> None:
    """Refuse what means nothing where readings are those of a recording."""
    options = "scenario", "world", "seed", "seconds", "speed", "record", "trace", "robot", "team", "no_record"
    _refuse(context, options, "means nothing to --replay: all is as it was recorded")


def _refuse(context: typer.Context, options: Sequence[str], problem: str) -> None:
    """Refuse the first of these options that was given."""
    from understudy.errors import SettingError

    for option in options:
        if _given(context, option):
            named = "SCENARIO" if option == "scenario" else f"--{option.replace('_', '-')}"
            raise SettingError(where="run", setting=named, problem=problem, remedy="leave it out")


def _how(
    named: str,
    kit: str | None,
    library: Path,
    team: Team,
    known: Libraries,
    roots: dict[str, tuple[str, dict[str, str]]],
) -> dict[str, Any]:
    """What it takes to run it again, for the header of its trace."""
    import msgspec

    from understudy.analysis.run_header import How, marks, world_mark
    from understudy.sim.catalog import find_world
    from understudy.sim.scenario.files import builtin_scenarios

    behavior, bound = next(iter(roots.values()))
    how = How(
        scenario=named if named in builtin_scenarios() else str(Path(named).resolve()),
        world=world_mark(find_world(named)),
        kit=kit,
        library=str(library.resolve()),
        sorts=list(roots),
        behavior=behavior,
        binding=dict(bound),
        automata=marks(team, known),
    )
    return dict(msgspec.to_builtins(how))


class Running:
    """One world in which all agents of some sorts run a behavior: the robots, or coordinators who order them about."""

    def __init__(self, team: Team, library: Opened, sorts: list[str], behavior: str, limit_s: float) -> None:
        from understudy.model.automaton import Automaton
        from understudy.sim.world import World

        if not isinstance(team.ground, World):
            raise TypeError("a team of robots that are no simulation")
        self.team, self.body, self.behavior, self._limit_s = team, team.ground, behavior, limit_s
        self.tick_team = team.tick
        self._sort = sorts[0]
        alone = [name for name in sorts if name in team.tree.types]
        kinds = [team.tree.types[kind] for kind in team.tree.type_of]
        self._rests = [behavior if kind in alone else IDLES for kind in kinds]
        root = library.behavior(behavior)
        states = root.states if isinstance(root, Automaton) else ()
        self._flags = {state.name for state in states if state.flag is not None}

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """What each robot is doing, outermost first; a basic behavior is all there is of itself, and others idle."""
        return [path or (rests,) for path, rests in zip(self.team.paths, self._rests, strict=True)]

    @property
    def frame(self) -> Frame:
        """This moment, for drawing."""
        from understudy.sim.view import Frame

        return Frame(self.body.view(), [path[0] for path in self.paths])

    @property
    def finished(self) -> bool:
        """Whether the scenario's goal was reached."""
        return bool(self.body.finished_s[0] >= 0)

    @property
    def ended(self) -> bool:
        """Whether all is done: the goal is reached, the time is over, or every robot rests with its flag up."""
        if self.finished or self.body.time_s >= self._limit_s - 1e-9:
            return True
        return bool(self._flags) and bool(self.team.raised(self._sort, self._flags).all())

    def tick(self, trace: TraceWriter | None) -> None:
        """One tick."""
        self.tick_team()
        if trace is not None:
            trace.add(self.body.view(), self.paths)

    def facts(self, *, seed: int, record: Path | None) -> dict[str, Any]:
        """How it ended, as plain data."""
        body, paths = self.body, self.paths
        goal = body.scenario.goal
        return {
            "behavior": self.behavior,
            "world": body.scenario.name,
            "seed": seed,
            "robots": body.robots,
            "seconds": round(body.time_s, 6),
            "goal": None if goal is None else _goal(goal),
            "success": None if goal is None else self.finished,
            "delivered": int(body.delivered[0]),
            "total": int(body.total[0]),
            "gathered": int(body.gathered[0]),
            "path": list(paths[0]) if body.robots == 1 else None,
            "doing": dict(Counter(path[0] for path in paths).most_common()),
            "record": None if record is None else str(record),
        }


def _goal(goal: Goal) -> str | None:
    """What is to be reached, in a word."""
    return "delivered" if goal.delivered else "gathered" if goal.gathered else goal.target


def _told(facts: dict[str, Any]) -> str:
    """How it ended, in a sentence."""
    from rich.markup import escape

    if facts["success"]:
        homes = {"delivered": "all food is home", "gathered": "enough boxes are home"}
        ended = f"[green]{homes.get(facts['goal'], 'goal reached')}[/]"
    elif facts["path"]:
        ended = f"[yellow]in {escape(facts['path'][-1])}[/]"
    else:
        doing = ", ".join(f"{name} {number}" for name, number in facts["doing"].items())
        ended = f"[yellow]{facts['robots']} robots: {escape(doing)}[/]"
    brought = f"; brought {facts['delivered']} of {facts['total']} units home" if facts["total"] else ""
    if facts["gathered"]:
        brought += f"; gathered {facts['gathered']} box{'es' * (facts['gathered'] > 1)}"
    where = "world" if facts["world"] == "forage" else f"{facts['world']} world"
    return f"{facts['behavior']} in {where} {facts['seed']}: {ended} after {facts['seconds']:.1f} s{brought}"


def _record(running: Running, speed: float, trace: TraceWriter | None) -> list[Frame]:
    from understudy.viz.run_gif import Recording

    recording = Recording()
    recording.see(running.frame)
    while not running.ended:
        running.tick(trace)
        recording.see(running.frame)
    return recording.frames


def _watch(running: Running, speed: float, trace: TraceWriter | None) -> list[Frame]:
    """Show the run in the terminal as it goes; Ctrl-C ends it."""
    from rich.live import Live

    from understudy.ui.cli.output import console

    out, body = console(), running.body
    step = speed / FRAMES_PER_S
    with Live(console=out, auto_refresh=False, transient=False) as live:
        due = monotonic()
        while True:
            view = body.view()
            live.update(screen(view, running.paths, wide=out.width, tall=out.height - 6), refresh=True)
            if running.ended:
                return []
            until = body.time_s + step
            while body.time_s < until and not running.ended:
                running.tick(trace)
            due += 1.0 / FRAMES_PER_S
            sleep(max(0.0, due - monotonic()))


def _draw(frames: list[Frame], path: Path, *, title: str, speed: float) -> None:
    from understudy.storage.atomic import failing
    from understudy.viz import path_png, run_gif

    with failing(
        path, "writing the picture", remedy="name a file in a folder that exists and that you may write to"
    ):
        if path.suffix.lower() == ".gif":
            run_gif(frames, path, speed=speed)
        else:
            path_png(frames, path, title=title)


def screen(view: WorldView, paths: Sequence[Sequence[str]], *, wide: int, tall: int) -> RenderableType:
    """The world, what its robot is doing on every level (of several: how many do what), and what there is."""
    from rich import box
    from rich.console import Group
    from rich.panel import Panel
    from rich.text import Text

    from understudy.ui.tui.world_view import facts, picture, size

    columns, lines = size(view, wide - 2, max(tall - 2, 6))
    drawn = picture(view, columns=columns, lines=lines, robot=0 if len(paths) == 1 else None)
    known = Text.assemble((f"{view.time_s:6.1f} s", "bold"), "   ", facts(view, wide))
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
