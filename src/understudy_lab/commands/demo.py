"""The command `understudy demo`: teach robots with a scripted teacher and test them; helpers of all demos."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table

from understudy.errors import SettingError, UnknownName
from understudy.model.binding import format_bound_name
from understudy.model.describe import describe_transitions, list_conditions_by_switch
from understudy.model.library import Library, TrainedAutomaton
from understudy.storage.atomic_write import convert_os_errors, write_atomically
from understudy.storage.library_folder import save_automaton
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.viz.automaton_svg import draw_automaton_svg
from understudy_lab.teachers.teacher import Progress, TeachingCost

if TYPE_CHECKING:
    from understudy_lab.commands.options import DemoOptions

TASKS = ("forage", "patrol", "swarm")
METHODS = ("live", "watched", "paper")


def demo(options: DemoOptions) -> None:
    """Teach simulated robots, and print how well they learned."""
    task, method = options.task, options.method
    if task not in TASKS:
        raise UnknownName(what="task", name=task, where="the demo", known=TASKS)
    if method not in METHODS:
        raise UnknownName(what="method", name=method, where="the demo", known=METHODS)
    if method != METHODS[0] and task != TASKS[0]:
        problem, remedy = f"is {method!r}, but only foraging is taught in several ways", "leave it out"
        raise SettingError(where=f"demo {task}", setting="--method", problem=problem, remedy=remedy)
    began = perf_counter()
    folder = options.out or Path("demo" if task == TASKS[0] else f"demo-{task}")
    make_output_folders(folder)
    talk = make_console(err=options.as_json)
    talk.quiet = options.as_json
    module = import_module(f"understudy_lab.commands.demo_{'forage' if task == TASKS[0] else 'teams'}")
    choice = {"method": method} if task == TASKS[0] else {}
    result = getattr(module, f"demo_{task}")(options.seed, folder, talk, **choice)
    if options.as_json:
        print_json({**result, "seconds": round(perf_counter() - began, 2)})


def make_output_folders(out: Path) -> None:
    """Create the folders for the demo's files, so that an unwritable place fails before the teaching."""
    for folder in (out / "library", out / "pictures"):
        with convert_os_errors(
            folder, "making the folder", remedy="name a folder that you may write to with --out"
        ):
            folder.mkdir(parents=True, exist_ok=True)
            TemporaryFile(dir=folder).close()


@contextmanager
def show_progress_table(talk: Console) -> Iterator[Progress]:
    """Show a table of the lessons that is updated while they are taught."""
    lessons: dict[str, tuple[str, TeachingCost]] = {}

    def drawn() -> Table:
        table = make_table("lesson", "#examples", "#presses", "#time", "")
        for name, (what, account) in lessons.items():
            minutes, seconds = divmod(round(account.seconds), 60)
            mark = "[green]✓[/] learned" if what == "learned" else f"[yellow]{what}[/]"
            numbers = str(account.examples), str(account.presses), f"{minutes}:{seconds:02d}"
            table.add_row(name, *numbers, mark)
        return table

    talk.print()
    with Live(drawn(), console=talk, auto_refresh=False) as live:

        def progress(name: str, what: str, account: TeachingCost) -> None:
            lessons[name] = (what, account)
            live.update(drawn(), refresh=talk.is_terminal)

        yield progress
        live.update(drawn(), refresh=True)


def print_lessons(taught: Sequence[TrainedAutomaton], talk: Console) -> None:
    """Print the conditions under which each automaton leaves its states."""
    talk.print(
        "\n[bold]What it learned[/]  [dim]when it leaves each state; read off the examples, nothing else[/]"
    )
    for each in taught:
        automaton = each.automaton
        title = format_bound_name(
            automaton.name, {parameter: parameter for parameter in automaton.parameters}
        )
        talk.print(f"  [bold cyan]{escape(title)}[/]")
        grid = Table.grid(padding=(0, 2))
        for state, lines in describe_transitions(automaton, each.lesson).items():
            leaves = [line for line in lines if not line.startswith("stays")]
            for index, line in enumerate(leaves):
                grid.add_row(f"[cyan]{escape(state)}[/]" if index == 0 else "", escape(line))
        talk.print(Padding(grid, (0, 0, 0, 4), expand=False))


def save_with_graphs(library: Library, folder: Path, pictures: Path) -> list[Path]:
    """Save a library and a graph of each of its automata, and return the paths of the graphs."""
    for taught in library.taught.values():
        save_automaton(folder, taught)
    graphs = {pictures / f"{name}.svg": taught for name, taught in library.taught.items()}
    with convert_os_errors(pictures, "writing the pictures", remedy="see that the disk has room"):
        for picture, taught in graphs.items():
            conditions = list_conditions_by_switch(taught.automaton, taught.lesson)
            write_atomically(picture, draw_automaton_svg(taught.automaton, conditions).encode())
    return list(graphs)


def summarize_teaching(accounts: Mapping[str, TeachingCost]) -> dict[str, Any]:
    """Return the cost of the teaching as plain data."""
    examples = {name: account.examples for name, account in accounts.items()}
    return {
        "examples": examples | {"total": sum(examples.values())},
        "presses": sum(account.presses for account in accounts.values()),
        "teaching_seconds": round(sum(account.seconds for account in accounts.values()), 1),
    }


def format_lasting(seconds: float) -> str:
    """Format a time in s as minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def print_numbers(title: str, rows: Mapping[str, str], talk: Console, *, wide: int = 16) -> None:
    """Print a titled table of results."""
    talk.print(f"\n[bold]{title}[/]")
    for what, value in rows.items():
        talk.print(f"  {what:<{wide}} [bold]{value}[/]")


def print_next_steps(out: Path, commands: Mapping[str, str], talk: Console) -> None:
    """Print where the files are, and commands to try next."""
    library, pictures = out / "library", out / "pictures"
    talk.print(
        f"\n[dim]library[/]  {escape(str(library))}\n[dim]pictures[/] {escape(str(pictures))}", soft_wrap=True
    )
    talk.print("\n[bold]What to try next[/]")
    for command, what in commands.items():
        talk.print(f"  {escape(command)}\n    [dim]{what}[/]", soft_wrap=True)
    talk.print()
