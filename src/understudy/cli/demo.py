"""`understudy demo`: a robot is taught to forage before your eyes, and then judged."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.cli.parts import Json

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.evaluation import Evaluation
    from understudy.model.library import Library
    from understudy.training.demonstrators.teacher import Account, Progress, Teaching

TASKS = ("forage",)


def demo(
    task: Annotated[str, typer.Argument(help="What to teach: forage.")] = "forage",
    seed: Annotated[int, typer.Option("--seed", min=0, max=2**30, help="Which teaching.")] = 0,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="DIR", help="Where the library and the pictures go.")
    ] = Path("demo"),
    as_json: Json = False,
) -> None:
    """Teach a robot to forage by showing it, and see how well it learned.

    A scripted teacher watches the robot and presses behaviors as a person would: late, and only now and then.
    It teaches GoTo, Harvest, Deposit and Forage in turn; then the robot forages alone in 100 worlds it has
    never seen, beside a forager written by hand. The same seed gives the same result.

    [dim]understudy demo --seed 7 --out my-demo[/]
    """
    from understudy.cli.output import console, print_json
    from understudy.cli.parts import find_world
    from understudy.cli.progress import compile_once
    from understudy.errors import UnknownName

    if task not in TASKS:
        raise UnknownName(what="task", name=task, where="the demo", known=TASKS)
    began = perf_counter()
    _make_room(out)
    talk = console(err=as_json)
    talk.quiet = as_json
    talk.print("\n[bold]A robot learns to forage by being shown.[/]")
    compile_once(learner=True, world=find_world("forage"), quiet=as_json)
    teaching = _teach(seed, talk)
    _tell_lessons(teaching, talk)
    pictures = _save(teaching.library, out, seed)
    evaluation, corners = _judge(teaching.library, seed, quiet=as_json)
    result = {
        "examples": {name: account.examples for name, account in teaching.accounts.items()}
        | {"total": teaching.examples},
        "presses": sum(account.presses for account in teaching.accounts.values()),
        "teaching_seconds": round(teaching.seconds, 1),
        "worlds": len(evaluation.seeds),
        "success": evaluation.success,
        "relative_to_expert": round(evaluation.relative_to_expert, 4),
        "corner_cases": corners,
        "seed": seed,
        "library": str(out / "library"),
        "pictures": [str(picture) for picture in pictures],
        "seconds": round(perf_counter() - began, 2),
    }
    if as_json:
        print_json(result)
    else:
        _tell_result(result, talk, out)


def _make_room(out: Path) -> None:
    """The folders for what the demo keeps: a place that cannot be written to is told before the teaching."""
    from tempfile import TemporaryFile

    from understudy.model.atomic import failing

    for folder in (out / "library", out / "pictures"):
        with failing(folder, "making the folder", remedy="name a folder that you may write to with --out"):
            folder.mkdir(parents=True, exist_ok=True)
            TemporaryFile(dir=folder).close()


def _teach(seed: int, talk: Console) -> Teaching:
    from understudy.experiments.forage.teaching import teach

    with _live(talk) as progress:
        return teach(seed, progress=progress)


@contextmanager
def _live(talk: Console) -> Iterator[Progress]:
    """A table of the lessons that fills as they are taught."""
    from rich.live import Live
    from rich.table import Table

    from understudy.cli.output import table

    lessons: dict[str, tuple[str, Account]] = {}

    def drawn() -> Table:
        made = table("lesson", "#examples", "#presses", "#time", "")
        for name, (what, account) in lessons.items():
            minutes, seconds = divmod(round(account.seconds), 60)
            mark = "[green]✓[/] learned" if what == "learned" else f"[yellow]{what}[/]"
            numbers = str(account.examples), str(account.presses), f"{minutes}:{seconds:02d}"
            made.add_row(name, *numbers, mark)
        return made

    talk.print()
    with Live(drawn(), console=talk, auto_refresh=False) as live:

        def progress(name: str, what: str, account: Account) -> None:
            lessons[name] = (what, account)
            live.update(drawn(), refresh=talk.is_terminal)

        yield progress
        live.update(drawn(), refresh=True)


def _tell_lessons(teaching: Teaching, talk: Console) -> None:
    from rich.markup import escape
    from rich.padding import Padding
    from rich.table import Table

    from understudy.model.account import conditions
    from understudy.model.binding import called

    talk.print(
        "\n[bold]What it learned[/]  [dim]when it leaves each state; read off the examples, nothing else[/]"
    )
    for name in teaching.accounts:
        automaton = teaching.library.automaton(name)
        title = called(name, {parameter: parameter for parameter in automaton.parameters})
        talk.print(f"  [bold cyan]{escape(title)}[/]")
        grid = Table.grid(padding=(0, 2))
        for state, lines in conditions(automaton, teaching.library.taught[name].lesson).items():
            leaves = [line for line in lines if not line.startswith("stays")]
            for index, line in enumerate(leaves):
                grid.add_row(f"[cyan]{escape(state)}[/]" if index == 0 else "", escape(line))
        talk.print(Padding(grid, (0, 0, 0, 4), expand=False))


def _save(library: Library, out: Path, seed: int) -> list[Path]:
    """Save the library, and draw each automaton and one run."""
    from understudy.cli.shelf import graph_conditions
    from understudy.experiments.forage.teaching import frames_of, worlds_of
    from understudy.model.atomic import failing, write
    from understudy.model.folder import save
    from understudy.pictures import automaton_svg, path_png

    for taught in library.taught.values():
        save(out / "library", taught)
    world, folder = worlds_of(seed)[0], out / "pictures"
    graphs = {folder / f"{name}.svg": taught for name, taught in library.taught.items()}
    path = folder / "path.png"
    with failing(folder, "writing the pictures", remedy="see that the disk has room"):
        for picture, taught in graphs.items():
            write(picture, automaton_svg(taught.automaton, graph_conditions(taught)).encode())
        path_png(frames_of(library, world), path, title=f"Taught to forage: world {world}")
    return [*graphs, path]


def _judge(library: Library, seed: int, *, quiet: bool) -> tuple[Evaluation, dict[str, float]]:
    from understudy.cli.progress import progress
    from understudy.experiments.forage.teaching import judge, judge_corners

    with progress("Foraging in unseen worlds", quiet=quiet) as report:
        return judge(library, seed, progress=report), judge_corners(library, seed)


def _tell_result(result: dict[str, Any], talk: Console, out: Path) -> None:
    from rich.markup import escape

    minutes, seconds = divmod(round(result["teaching_seconds"]), 60)
    rows = (
        ("taught with", f"{result['presses']} presses, {result['examples']['total']} examples"),
        ("in", f"{minutes} min {seconds:02d} s of watching the robot"),
        ("succeeds in", f"{result['success']:.0%} of {result['worlds']} unseen worlds"),
        ("food per second", f"{result['relative_to_expert']:.2f} of a forager written by hand"),
    )
    talk.print("\n[bold]How well it forages[/]")
    for what, value in rows:
        talk.print(f"  {what:<16} [bold]{value}[/]")
    talk.print("  [dim]and in the paper's corner cases[/]")
    for name, success in result["corner_cases"].items():
        talk.print(f"    {name:<42} [bold]{success:.0%}[/]")
    library, pictures = out / "library", out / "pictures"
    talk.print(
        f"\n[dim]library[/]  {escape(str(library))}\n[dim]pictures[/] {escape(str(pictures))}", soft_wrap=True
    )
    talk.print("\n[bold]What to try next[/]")
    for command, what in (
        (f"understudy run --library {library} --seed 3", "watch it forage, here in the terminal"),
        (f"understudy show goto --library {library}", "its examples, and what was learned from them"),
        ("understudy teach goto --library mine", "teach it yourself, with the arrow keys"),
        ("understudy demo --seed 1", "another teacher, another robot"),
    ):
        talk.print(f"  {escape(command)}\n    [dim]{what}[/]", soft_wrap=True)
    talk.print()
