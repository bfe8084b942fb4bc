"""The patrol demo (paper, section 5.1): four robots and their coordinator learn to patrol and to defer to a boss."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console

from understudy.sim.team.libraries import Libraries
from understudy.sim.view import RunFrame
from understudy.storage.atomic_write import convert_os_errors
from understudy.ui.cli.output import make_table
from understudy.ui.cli.progress_bar import show_progress
from understudy.viz.run_gif import draw_run_gif
from understudy_lab.commands.demo import (
    format_lasting,
    print_lessons,
    print_next_steps,
    print_numbers,
    save_with_graphs,
    show_progress_table,
    summarize_teaching,
)
from understudy_lab.patrol import evaluate
from understudy_lab.patrol.evaluate import DEFER
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.practice import ROBOT, SQUAD, make_coordinated_team, make_uncoordinated_team, teach
from understudy_lab.patrol.tracks import RUN_AWAY, PatrolTracks, watch

PATROL_WORLDS = 40
PATROL_FILM_S, PATROL_SPEED = 150.0, 8.0
"""The simulated length of the film in s, and its speed relative to real time."""


def demo_patrol(seed: int, out: Path, talk: Console) -> dict[str, Any]:
    """Teach, save, test and print the results, and return them as plain data."""
    talk.print("\n[bold]Four robots and their coordinator learn to patrol by being shown.[/]")
    with show_progress_table(talk) as progress:
        taught = teach(seed, progress=progress)
    libraries = taught.libraries
    robots, coordinator = libraries[ROBOT], libraries[SQUAD]
    print_lessons(list(coordinator.taught.values()), talk)
    talk.print("  [dim]and what the robots learned: see the pictures[/]")
    pictures = [
        *save_with_graphs(robots, out / "library", out / "pictures"),
        *save_with_graphs(coordinator, out / "library" / SQUAD, out / "pictures"),
    ]
    judged, world = _evaluate_patrol(libraries, seed, quiet=talk.quiet)
    pictures.append(_film_patrol(libraries, out / "pictures", world))
    result = {
        **summarize_teaching(taught.accounts),
        "worlds": PATROL_WORLDS,
        **judged,
        "seed": seed,
        "library": str(out / "library"),
        "pictures": [str(picture) for picture in pictures],
    }
    _print_patrol(result, talk, out)
    return result


def _film_patrol(libraries: Libraries, folder: Path, world: int) -> Path:
    """Film one patrol and return the file."""
    team = make_coordinated_team(libraries, [world], DEFER)
    film = folder / "patrol.gif"
    with convert_os_errors(folder, "writing the pictures", remedy="see that the disk has room"):
        draw_run_gif(_frames(team), film, speed=PATROL_SPEED)
    return film


def _frames(team: Any) -> list[RunFrame]:
    frames = []
    while team.ground.time_s < PATROL_FILM_S:
        team.tick()
        frames.append(RunFrame(team.ground.view(), [(*path, "")[0] for path in team.paths]))
    return frames


def _evaluate_patrol(libraries: Libraries, seed: int, *, quiet: bool) -> tuple[dict[str, Any], int]:
    """Return the results of the taught team, and the index of a world worth filming."""
    worlds, ticks = evaluate.worlds_of(seed)[:PATROL_WORLDS], evaluate.TICKS
    with show_progress("Patrolling in unseen worlds", quiet=quiet) as report:
        report(0, 3)
        by_themselves = evaluate.rounds(watch(make_uncoordinated_team(libraries, worlds), ticks))
        report(1, 3)
        together = evaluate.rounds(watch(make_coordinated_team(libraries, worlds, evaluate.PATROL), ticks))
        report(2, 3)
        boss = watch(make_coordinated_team(libraries, worlds, evaluate.DEFER), ticks)
    judged = {"alone": by_themselves, "coordinated": together, "deferring": evaluate.deferrals(boss)}
    return judged, worlds[_eventful(boss)]


def _eventful(tracks: PatrolTracks) -> int:
    """Return the first world with a complete cycle and a boss within the film's length, or 0."""
    end = round(PATROL_FILM_S / tracks.tick_s)
    met = (tracks.doing[:end] == RUN_AWAY).any(axis=(0, 2))
    whole = {
        each.world
        for each in cycles(tracks)
        if each.complete and each.tick + each.seconds / tracks.tick_s < end
    }
    return next((world for world in sorted(whole) if met[world]), 0)


def _print_patrol(result: dict[str, Any], talk: Console, out: Path) -> None:
    numbers = {
        "taught with": f"{result['presses']} presses, {result['examples']['total']} examples",
        "in": f"{format_lasting(result['teaching_seconds'])} of watching the robots",
        "judged in": f"{result['worlds']} unseen worlds, ten minutes each",
    }
    print_numbers("How well they patrol", numbers, talk)
    alone, together, deferring = result["alone"], result["coordinated"], result["deferring"]
    table = make_table("", "#alone", "#coordinated")
    for what, key, pattern in (
        ("robots at the capture of an intruder", "attackers", "{:.1f} of 4"),
        ("robot-seconds an hour on who is gone", "residual_s", "{:.0f}"),
        ("captures an hour", "captures_per_hour", "{:.0f}"),
    ):
        share = result["worlds"] / 6 if key == "residual_s" else 1
        table.add_row(what, *(f"[bold]{pattern.format(each[key] / share)}[/]" for each in (alone, together)))
    table.add_row("home and dispersed again in 2 min", "", f"[bold]{together['complete']:.1%}[/]")
    table.add_row("all face the boss in time", "", f"[bold]{deferring['deferred']:.1%}[/]")
    talk.print(table)
    library = out / "library"
    commands = {
        f"understudy run patrol --library {library} --seed 3": "watch them patrol, here in the terminal",
        f"understudy studio patrol --library {library}": "teach them something else: the robots, or their coordinator",
        "understudy experiment patrol": "ten teachings, a hundred worlds each",
    }
    print_next_steps(out, commands, talk)
