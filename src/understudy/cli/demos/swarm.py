"""The swarm demo: two hundred robots and three levels of coordinators learn to pull boxes together."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.worlds.teams import Libraries

WORLDS = 4
FILM_S, SPEED, EVERY = 60.0, 8.0, 4
"""How long the film's run is, s, how many times as fast it is shown, and each how many ticks it has a picture."""
PLATOONS, TICKS = 400, 300
"""Platoons of the ten thousand, and how long they run."""


def show(seed: int, out: Path, talk: Console) -> dict[str, Any]:
    """Teach, keep, judge and tell; the result as plain data."""
    from understudy.cli.demos.talking import keep, live, tell_lessons
    from understudy.cli.progress import compile_once, progress
    from understudy.experiments.swarm.measuring import judged, speed, worlds_of
    from understudy.experiments.swarm.practice import scenario
    from understudy.experiments.swarm.teaching import teach

    talk.print("\n[bold]Two hundred robots and three levels of coordinators learn by being shown.[/]")
    compile_once(learner=True, world=scenario(), quiet=talk.quiet)
    with live(talk) as report:
        taught = teach(seed, progress=report)
    coordinators = {name: each.library for name, each in taught.squads.items()}
    tell_lessons([each for library in coordinators.values() for each in library.taught.values()], talk)
    talk.print("  [dim]and what the robots learned: see the pictures[/]")
    pictures = keep(taught.robots.library, out / "library", out / "pictures")
    for name, library in coordinators.items():
        pictures += keep(library, out / "library" / name, out / "pictures")
    with progress("Pulling boxes in unseen worlds", quiet=talk.quiet) as said:
        said(0, 3)
        found = judged(taught.libraries, worlds_of(seed)[:WORLDS])
        said(1, 3)
        fast = speed(taught.libraries, PLATOONS, TICKS)
        said(2, 3)
        pictures.append(_film(taught.libraries, out / "pictures", worlds_of(seed)[0]))
    accounts = {name: each for teaching in taught.teachings for name, each in teaching.accounts.items()}
    examples = {name: account.examples for name, account in accounts.items()}
    result = {
        "examples": examples | {"total": sum(examples.values())},
        "presses": sum(account.presses for account in accounts.values()),
        "teaching_seconds": round(sum(account.seconds for account in accounts.values()), 1),
        "worlds": WORLDS,
        **found,
        "ticks_per_s": fast,
        "seed": seed,
        "library": str(out / "library"),
        "pictures": [str(picture) for picture in pictures],
    }
    _tell(result, talk, out)
    return result


def _film(libraries: Libraries, folder: Path, world: int) -> Path:
    """A film of the two hundred."""
    from understudy.experiments.swarm.practice import coordinated
    from understudy.model.atomic import failing
    from understudy.pictures import run_gif
    from understudy.worlds.view import Frame

    team, frames = coordinated(libraries, [world]), []
    while team.ground.time_s < FILM_S:
        team.run(EVERY)
        frames.append(Frame(team.ground.view(), [(*path, "")[0] for path in team.paths]))  # type: ignore[attr-defined]
    film = folder / "swarm.gif"
    with failing(folder, "writing the pictures", remedy="see that the disk has room"):
        run_gif(frames, film, speed=SPEED)
    return film


def _tell(result: dict[str, Any], talk: Console, out: Path) -> None:
    from understudy.cli.demos.talking import lasted, tell_next, tell_numbers
    from understudy.cli.output import table

    robots = 25 * PLATOONS
    numbers = {
        "taught with": f"{result['presses']} presses, {result['examples']['total']} examples",
        "in": f"{lasted(result['teaching_seconds'])} of watching the robots",
        "judged in": f"{result['worlds']} unseen worlds, ten minutes each",
        f"{robots:,} robots": f"{result['ticks_per_s'] / 10:.1f} times real time, at ten ticks a second",
    }
    tell_numbers("How well they pull together", numbers, talk)
    made = table("an hour", "#crates", "#containers", "#hands", "#share")
    for what, key in (
        ("three levels, by hand", "by_hand"),
        ("three levels, taught", "taught"),
        ("alone, answering calls", "answering"),
        ("alone", "alone"),
    ):
        each, share = result[key], result[key]["hands"] / max(1.0, result["by_hand"]["hands"])
        made.add_row(
            what,
            f"{each['crates']:.0f}",
            f"{each['containers']:.1f}",
            f"[bold]{each['hands']:.0f}[/]",
            f"[bold]{share:.2f}[/]",
        )
    talk.print(made)
    library = out / "library"
    commands = {
        f"understudy run swarm --library {library} --seed 3": "watch them, here in the terminal",
        f"understudy studio swarm --library {library}": "teach them something else, robots or coordinators",
    }
    tell_next(out, commands, talk)
