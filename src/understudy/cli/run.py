"""`understudy run`: watch a taught behavior, or draw what it did."""

from __future__ import annotations

from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.cli.parts import LIBRARY, WORLD, Bind, Json, KitName, Library, World

if TYPE_CHECKING:
    from understudy.runtime.run import Run
    from understudy.traces import TraceWriter
    from understudy.worlds.forage import Forage
    from understudy.worlds.view import Frame

PICTURES = (".gif", ".png")
FRAMES_PER_S = 12.0


def run(
    behavior: Annotated[str, typer.Option("--behavior", help="The behavior to run.")] = "forage",
    library: Library = LIBRARY,
    world: World = WORLD,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Which world.")] = 0,
    record: Annotated[
        Path | None,
        typer.Option("--record", "-r", metavar="OUT.gif|OUT.png", help="Draw it instead of showing it."),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option("--trace", metavar="OUT.jsonl|OUT.parquet", help="Keep where it was and what it did."),
    ] = None,
    seconds: Annotated[
        float, typer.Option("--seconds", min=0.1, help="End after so much simulated time.")
    ] = 600.0,
    speed: Annotated[
        float, typer.Option("--speed", min=0.1, max=1000, help="Times as fast as in life.")
    ] = 8.0,
    bind: Bind = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Run a behavior in a world: watch it in the terminal, or write a moving GIF or a PNG of its path.

    [dim]understudy run --library demo/library --behavior forage --seed 7[/]

    [dim]understudy run --behavior goto --bind A=station --record goto.gif[/]
    """
    from understudy.cli.output import console, print_json
    from understudy.cli.parts import bindings, find_kit, find_world, opened
    from understudy.cli.progress import compile_once
    from understudy.errors import SettingError
    from understudy.runtime.program import link
    from understudy.runtime.run import Run
    from understudy.traces import write_trace

    if record is not None and record.suffix.lower() not in PICTURES:
        remedy = "name a file that ends in .gif (in motion) or .png (its path)"
        raise SettingError(
            where="--record", setting=repr(str(record)), problem="is no picture", remedy=remedy
        )
    where = find_world(world)
    compile_once(world=where, quiet=as_json)
    found = opened(library, find_kit(kit, world)).library
    program = link(found, behavior, bindings(bind))
    body = where.make([seed])
    running = Run.of(body, program)
    shown = record is None and not as_json and console().is_terminal
    watch = _watch if shown else _record
    if trace is None:
        frames = watch(running, body, seconds, speed, None)
    else:
        with write_trace(trace, scenario=world, seed=seed, tick_s=body.tick_s, robots=body.agents) as writer:
            frames = watch(running, body, seconds, speed, writer)
    if record is not None:
        _draw(frames, record, title=f"{behavior}, seed {seed}", speed=speed)
    facts = _facts(body, running, behavior=behavior, seed=seed, record=record)
    if as_json:
        print_json(facts)
    else:
        ended = "[green]all food is home[/]" if facts["success"] else f"[yellow]in {facts['path'][-1]}[/]"
        brought = f"brought {facts['delivered']} of {facts['total']} units home"
        console().print(f"{behavior} in world {seed}: {ended} after {facts['seconds']:.1f} s; {brought}")
        if record is not None:
            console().print(f"Drawn in {record}", markup=False, soft_wrap=True)
        if trace is not None:
            console().print(f"Traced in {trace}", markup=False, soft_wrap=True)


def _facts(body: Forage, running: Run, *, behavior: str, seed: int, record: Path | None) -> dict[str, Any]:
    return {
        "behavior": behavior,
        "seed": seed,
        "seconds": round(body.time_s, 6),
        "success": bool(body.success()[0]),
        "delivered": int(body.delivered[0]),
        "total": int(body.total[0]),
        "path": list(running.interpreters[0].path) or ["idle"],
        "record": None if record is None else str(record),
    }


def _ended(running: Run, body: Forage, seconds: float) -> bool:
    """Whether all is done: the food is home, the root rests with its flag up, or the time is over."""
    active = running.interpreters[0].active
    rests = bool(active) and active[0].flag is not None
    return rests or body.time_s >= seconds - 1e-9 or bool(body.success()[0] and body.total[0])


def _frame(running: Run, body: Forage) -> Frame:
    from understudy.worlds.forage_view import from_forage
    from understudy.worlds.view import Frame

    active = running.interpreters[0].active
    return Frame(from_forage(body.view()), (active[0].state_name if active else "",))


def _tick(running: Run, body: Forage, trace: TraceWriter | None) -> None:
    running.tick()
    if trace is not None:
        from understudy.worlds.forage_view import from_forage

        trace.add(from_forage(body.view()), [interpreter.path for interpreter in running.interpreters])


def _record(
    running: Run, body: Forage, seconds: float, speed: float, trace: TraceWriter | None
) -> list[Frame]:
    from understudy.pictures.recording import Recording

    recording = Recording()
    recording.see(_frame(running, body))
    while not _ended(running, body, seconds):
        _tick(running, body, trace)
        recording.see(_frame(running, body))
    return recording.frames


def _watch(
    running: Run, body: Forage, seconds: float, speed: float, trace: TraceWriter | None
) -> list[Frame]:
    """Show the run in the terminal as it goes; Ctrl-C ends it."""
    from rich.live import Live

    from understudy.cli.arena import screen
    from understudy.cli.output import console
    from understudy.worlds.forage_view import from_forage

    out = console()
    step = speed / FRAMES_PER_S
    with Live(console=out, auto_refresh=False, transient=False) as live:
        due = monotonic()
        while True:
            paths = [interpreter.path for interpreter in running.interpreters]
            view = from_forage(body.view())
            live.update(screen(view, paths, wide=out.width, tall=out.height - 6), refresh=True)
            if _ended(running, body, seconds):
                return []
            until = body.time_s + step
            while body.time_s < until and not _ended(running, body, seconds):
                _tick(running, body, trace)
            due += 1.0 / FRAMES_PER_S
            sleep(max(0.0, due - monotonic()))


def _draw(frames: list[Frame], path: Path, *, title: str, speed: float) -> None:
    from understudy.model.atomic import failing
    from understudy.pictures import path_png, run_gif

    with failing(
        path, "writing the picture", remedy="name a file in a folder that exists and that you may write to"
    ):
        if path.suffix.lower() == ".gif":
            run_gif(frames, path, speed=speed)
        else:
            path_png(frames, path, title=title)
