"""The demos of teams: a patrol (paper, section 5.1), and two hundred robots under three levels of coordinators."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console

from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy.sim.view import RunFrame
from understudy.storage.atomic_write import convert_os_errors
from understudy.ui.cli.output import make_table
from understudy.ui.cli.progress_bar import show_progress
from understudy.viz.appearance import format_thousands
from understudy.viz.path_png import draw_path_png
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
from understudy_lab.patrol import evaluate, practice
from understudy_lab.patrol.evaluate import DEFER
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.practice import make_coordinated_team, make_uncoordinated_team
from understudy_lab.patrol.tracks import RUN_AWAY, PatrolTracks, watch
from understudy_lab.swarm.practice import COURSE, make_swarm_team
from understudy_lab.swarm.study import ALONE, ANSWERING, LOADS, THREE, WAYS, measure_gathered, worlds_of
from understudy_lab.tasks.swarm_world import EACH, make_expert_libraries, of_platoons
from understudy_lab.teams import TeamCourse, TeamTeaching, world_of

PATROL_WORLDS = 40
PATROL_FILM_S, PATROL_SPEED = 150.0, 8.0
"""The simulated length of the film in s, and its speed relative to real time."""


def demo_patrol(seed: int, out: Path, talk: Console) -> dict[str, Any]:
    """Teach, save, test and print the results, and return them as plain data."""
    talk.print("\n[bold]Four robots and their coordinator learn to patrol by being shown.[/]")
    taught, pictures = _teach_and_save(practice.COURSE, seed, out, talk)
    libraries = taught.libraries
    judged, world = _evaluate_patrol(libraries, seed, quiet=talk.quiet)
    film = make_coordinated_team(libraries, [world], DEFER), out / "pictures" / "patrol.gif"
    pictures.append(_film(*film, seconds=PATROL_FILM_S, speed=PATROL_SPEED))
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


def _teach_and_save(
    course: TeamCourse, seed: int, out: Path, talk: Console
) -> tuple[TeamTeaching, list[Path]]:
    """Teach a team, print what its coordinators learned, and save all libraries; return the graphs of automata."""
    with show_progress_table(talk) as report:
        taught = course.teach(seed, progress=report)
    robots, *coordinators = taught.libraries.values()
    print_lessons([each for library in coordinators for each in library.taught.values()], talk)
    talk.print("  [dim]and what the robots learned: see the pictures[/]")
    graphs = []
    for name, library in taught.libraries.items():
        folder = out / "library" if library is robots else out / "library" / name
        graphs += save_with_graphs(library, folder, out / "pictures")
    return taught, graphs


def _film(
    team: Team, film: Path, *, seconds: float, speed: float, every: int = 1, frames: Sequence[RunFrame] = ()
) -> Path:
    """Film a team for a simulated time in s, a frame for each number of ticks, after other frames; return the file."""
    filmed = list(frames)
    while team.ground.time_s < seconds:
        team.run(every)
        filmed.append(_frame(team))
    with convert_os_errors(film.parent, "writing the pictures", remedy="see that the disk has room"):
        draw_run_gif(filmed, film, speed=speed)
    return film


def _frame(team: Team) -> RunFrame:
    return RunFrame(world_of(team).view(), [(*path, "")[0] for path in team.paths])


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


SWARM_WORLDS, TICKS = 2, 6_000
"""The number of test worlds, and the ticks of 0.1 s that each runs."""
SWARM_FILM_S, SWARM_SPEED, EVERY = 60.0, 8.0, 4
"""The simulated length of the film in s, its speed relative to real time, and the ticks per frame."""
PLATOONS, LARGE_S, LARGE_EVERY = 400, 40.0, 20
"""The number of platoons of the ten thousand robots, their time in s, and the ticks per point of their picture."""


def demo_swarm(seed: int, out: Path, talk: Console) -> dict[str, Any]:
    """Teach, save, test and print the results, and return them as plain data."""
    talk.print("\n[bold]Two hundred robots and three levels of coordinators learn by being shown.[/]")
    taught, pictures = _teach_and_save(COURSE, seed, out, talk)
    libraries = taught.libraries
    results, films = _evaluate_swarm(libraries, seed, out / "pictures", quiet=talk.quiet)
    result = {
        **summarize_teaching(taught.accounts),
        "worlds": SWARM_WORLDS,
        **results,
        "seed": seed,
        "library": str(out / "library"),
        "pictures": [str(picture) for picture in (*pictures, *films)],
    }
    _print_swarm(result, talk, out)
    return result


def _evaluate_swarm(
    libraries: Libraries, seed: int, folder: Path, *, quiet: bool
) -> tuple[dict[str, Any], list[Path]]:
    """Measure what swarms bring home, and how many times faster than real time ten thousand robots are simulated.

    The swarms are the taught one, a hand-written one, and two without coordinators. Return what was measured, and the
    pictures that were drawn.
    """
    worlds = worlds_of(seed)[:SWARM_WORLDS]
    teams = {
        "by hand": make_swarm_team(make_expert_libraries(), worlds),
        "taught": make_swarm_team(libraries, worlds),
        ANSWERING: make_swarm_team(libraries, worlds, way=WAYS[ANSWERING]),
        ALONE: make_swarm_team(libraries, worlds, way=WAYS[ALONE]),
    }
    gathered: dict[str, Any] = {}
    with show_progress("Pulling boxes in unseen worlds", quiet=quiet) as report:
        for done, (name, team) in enumerate(teams.items()):
            report(done, len(teams) + 2)
            gathered[name] = measure_gathered(team, TICKS)
        report(len(teams), len(teams) + 2)
        filmed = make_swarm_team(libraries, worlds[:1], way=WAYS[THREE])
        film = _film(
            filmed,
            folder / "swarm.gif",
            seconds=SWARM_FILM_S,
            speed=SWARM_SPEED,
            every=EVERY,
            frames=[_frame(filmed)],
        )
        report(len(teams) + 1, len(teams) + 2)
        speed, picture = _large(libraries, worlds[0], folder)
        report(len(teams) + 2, len(teams) + 2)
    return {"gathered": gathered, "times_real_time": speed}, [film, picture]


def _large(libraries: Libraries, world: int, folder: Path) -> tuple[float, Path]:
    """Return the speed of ten thousand robots relative to real time, and a picture of their paths."""
    team = make_swarm_team(libraries, [world], of_platoons(PLATOONS))
    team.run(LARGE_EVERY)
    frames, taken, begun = [_frame(team)], 0.0, team.ground.time_s
    while team.ground.time_s < LARGE_S:
        began = perf_counter()
        team.run(LARGE_EVERY)
        taken += perf_counter() - began
        frames.append(_frame(team))
    picture = folder / "swarm-large.png"
    with convert_os_errors(folder, "writing the pictures", remedy="see that the disk has room"):
        draw_path_png(frames, picture, title=f"{PLATOONS} platoons")
    return round((team.ground.time_s - begun) / taken, 1), picture


def _print_swarm(result: dict[str, Any], talk: Console, out: Path) -> None:
    numbers = {
        "taught with": f"{result['presses']} presses, {result['examples']['total']} examples",
        "in": f"{format_lasting(result['teaching_seconds'])} of watching the robots",
        "judged in": f"{result['worlds']} unseen worlds, ten minutes each",
        f"{format_thousands(EACH * PLATOONS)} robots": (
            f"{result['times_real_time']:.1f} times real time, at 10 ticks a second"
        ),
    }
    print_numbers("How well they pull together", numbers, talk)
    table = make_table("an hour", "#crates", "#containers", "#loads", "#of by hand")
    by_hand = result["gathered"]["by hand"]["loads"]
    labels = {"by hand": "coordinated, by hand", "taught": "coordinated, taught"}
    for name, each in result["gathered"].items():
        table.add_row(
            labels.get(name, name),
            f"{each['crates']:.0f}",
            f"{each['containers']:.0f}",
            f"[bold]{each['loads']:.0f}[/]",
            f"[bold]{each['loads'] / max(1.0, by_hand):.2f}[/]",
        )
    talk.print(table)
    talk.print(f"  [dim]a crate is a load, a container {LOADS['container']}[/]")
    library = out / "library"
    commands = {
        f"understudy run swarm --library {library} --seed 3": "watch them, here in the terminal",
        f"understudy studio swarm --library {library}": "teach them something else, robots or coordinators",
        "understudy experiment swarm": "ten teachings, ten worlds each",
    }
    print_next_steps(out, commands, talk)
