"""The forage demo: a robot learns to bring food home, and is compared with a hand-written controller."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from understudy.judging.evaluate import find_success_flag
from understudy.judging.evaluation import Evaluation
from understudy.judging.raised_range import describe_raised, find_shown_goal
from understudy.model.library import Library
from understudy.storage.atomic_write import convert_os_errors
from understudy.ui.cli.progress_bar import show_progress
from understudy.viz.path_png import draw_path_png
from understudy_lab.commands.demo import (
    format_lasting,
    print_lessons,
    print_next_steps,
    print_numbers,
    save_with_graphs,
    show_progress_table,
    summarize_teaching,
)
from understudy_lab.forage.teach import (
    Continued,
    frames_of,
    judge,
    judge_corners,
    teach,
    teach_until_it_holds,
    worlds_of,
)


def demo_forage(seed: int, out: Path, talk: Console, *, method: str = "live") -> dict[str, Any]:
    """Teach, save, test and print the results, and return them as plain data."""
    talk.print("\n[bold]A robot learns to forage by being shown.[/]")
    continued: Mapping[str, Continued] = {}
    with show_progress_table(talk) as progress:
        if method == "live":
            teaching, continued = teach_until_it_holds(seed, progress=progress)
        else:
            teaching = teach(seed, method={"paper": "plain"}.get(method, method), progress=progress)
    library = teaching.library
    print_lessons([library.taught[name] for name in teaching.accounts], talk)
    pictures = [
        *save_with_graphs(library, out / "library", out / "pictures"),
        _path(library, out / "pictures", seed),
    ]
    evaluation, corners = _evaluate_forage(library, seed, quiet=talk.quiet)
    result = {
        "method": method,
        **summarize_teaching(teaching.accounts),
        "holds": {
            name: {
                "verdict": each.result.verdict.value,
                "works": each.result.held,
                "worlds": each.result.worlds,
                "presses": each.presses,
            }
            for name, each in continued.items()
        },
        "worlds": len(evaluation.seeds),
        "success": evaluation.success,
        "relative_to_expert": round(evaluation.relative_to_expert, 4),
        "corner_cases": corners,
        "seed": seed,
        "library": str(out / "library"),
        "pictures": [str(picture) for picture in pictures],
    }
    _print_forage(result, library, talk, out)
    return result


INDENT = " " * 19


def _tell(holds: Mapping[str, Mapping[str, Any]], library: Library) -> dict[str, str]:
    """Return in words whether each behavior holds, after how many presses, and what success is where none was shown."""
    results = {}
    for name, each in holds.items():
        beginning = {
            "holds": "in at least 95 % of worlds",
            "fails": "does not hold: in less than 95 % of worlds",
        }.get(each["verdict"], "does not hold yet")
        more = f"{each['presses']} more press{'es' * (each['presses'] != 1)}"
        flag = find_success_flag(library, name)
        word = "" if find_shown_goal(library, name, flag) else describe_raised(flag, None)
        results[name] = f"{beginning} ({each['works']} of {each['worlds']}), after {more}"
        results[name] += f"\n{INDENT}".join(["", *word.split(": ")]) if word else ""
    return results


def _path(library: Library, folder: Path, seed: int) -> Path:
    """Draw the path of one run and return the picture's file."""
    world, picture = worlds_of(seed)[0], folder / "path.png"
    with convert_os_errors(folder, "writing the pictures", remedy="see that the disk has room"):
        draw_path_png(frames_of(library, world), picture, title=f"Taught to forage: world {world}")
    return picture


def _evaluate_forage(library: Library, seed: int, *, quiet: bool) -> tuple[Evaluation, dict[str, float]]:
    with show_progress("Foraging in unseen worlds", quiet=quiet) as report:
        return judge(library, seed, progress=report), judge_corners(library, seed)


def _print_forage(result: dict[str, Any], library: Library, talk: Console, out: Path) -> None:
    if result["holds"]:
        print_numbers(
            "Taught where it went wrong in new worlds, until it holds", _tell(result["holds"], library), talk
        )
    numbers = {
        "taught with": f"{result['presses']} presses, {result['examples']['total']} examples",
        "in": f"{format_lasting(result['teaching_seconds'])} of watching the robot",
        "succeeds in": f"{result['success']:.0%} of {result['worlds']} unseen worlds",
        "food per second": f"{result['relative_to_expert']:.2f} of a forager written by hand",
    }
    print_numbers("How well it forages", numbers, talk)
    talk.print("  [dim]and in the paper's corner cases[/]")
    for name, success in result["corner_cases"].items():
        talk.print(f"    {name:<42} [bold]{success:.0%}[/]")
    folder = out / "library"
    commands = {
        f"understudy run --library {folder} --seed 3": "watch it forage, here in the terminal",
        f"understudy show goto --library {folder}": "its examples, and what was learned from them",
        "understudy teach goto --library mine": "teach it yourself, with the arrow keys",
        "understudy demo --seed 1": "another teacher, another robot",
    }
    print_next_steps(out, commands, talk)
