"""What all demos say and keep: lessons as they are taught, what was learned, numbers, what to try next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.library import Library, TrainedAutomaton
    from understudy_lab.teachers.teacher import Progress, TeachingCost


def make_output_folders(out: Path) -> None:
    """The folders for what the demo keeps: a place that cannot be written to is told before the teaching."""
    from tempfile import TemporaryFile

    from understudy.storage.atomic_write import convert_os_errors

    for folder in (out / "library", out / "pictures"):
        with convert_os_errors(
            folder, "making the folder", remedy="name a folder that you may write to with --out"
        ):
            folder.mkdir(parents=True, exist_ok=True)
            TemporaryFile(dir=folder).close()


@contextmanager
def show_progress_table(talk: Console) -> Iterator[Progress]:
    """A table of the lessons that fills as they are taught."""
    from rich.live import Live
    from rich.table import Table

    from understudy.ui.cli.output import make_table

    lessons: dict[str, tuple[str, TeachingCost]] = {}

    def drawn() -> Table:
        made = make_table("lesson", "#examples", "#presses", "#time", "")
        for name, (what, account) in lessons.items():
            minutes, seconds = divmod(round(account.seconds), 60)
            mark = "[green]✓[/] learned" if what == "learned" else f"[yellow]{what}[/]"
            numbers = str(account.examples), str(account.presses), f"{minutes}:{seconds:02d}"
            made.add_row(name, *numbers, mark)
        return made

    talk.print()
    with Live(drawn(), console=talk, auto_refresh=False) as live:

        def progress(name: str, what: str, account: TeachingCost) -> None:
            lessons[name] = (what, account)
            live.update(drawn(), refresh=talk.is_terminal)

        yield progress
        live.update(drawn(), refresh=True)


def print_lessons(taught: Sequence[TrainedAutomaton], talk: Console) -> None:
    """When each of them leaves its states."""
    from rich.markup import escape
    from rich.padding import Padding
    from rich.table import Table

    from understudy.model.binding import format_bound_name
    from understudy.model.describe import describe_transitions

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
    """Save a library, and a graph of each of its automata; the graphs."""
    from understudy.storage.atomic_write import convert_os_errors, write_atomically
    from understudy.storage.library_folder import save_automaton
    from understudy.ui.cli.library_data import list_conditions_by_switch
    from understudy.viz.automaton_svg import draw_automaton_svg

    for taught in library.taught.values():
        save_automaton(folder, taught)
    graphs = {pictures / f"{name}.svg": taught for name, taught in library.taught.items()}
    with convert_os_errors(pictures, "writing the pictures", remedy="see that the disk has room"):
        for picture, taught in graphs.items():
            write_atomically(
                picture, draw_automaton_svg(taught.automaton, list_conditions_by_switch(taught)).encode()
            )
    return list(graphs)


def summarize_teaching(accounts: Mapping[str, TeachingCost]) -> dict[str, Any]:
    """What the teaching took, as plain data."""
    examples = {name: account.examples for name, account in accounts.items()}
    return {
        "examples": examples | {"total": sum(examples.values())},
        "presses": sum(account.presses for account in accounts.values()),
        "teaching_seconds": round(sum(account.seconds for account in accounts.values()), 1),
    }


def format_lasting(seconds: float) -> str:
    """A time, in minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def print_numbers(title: str, rows: Mapping[str, str], talk: Console, *, wide: int = 16) -> None:
    """What came out."""
    talk.print(f"\n[bold]{title}[/]")
    for what, value in rows.items():
        talk.print(f"  {what:<{wide}} [bold]{value}[/]")


def print_next_steps(out: Path, commands: Mapping[str, str], talk: Console) -> None:
    """Where everything is, and what to try next."""
    from rich.markup import escape

    library, pictures = out / "library", out / "pictures"
    talk.print(
        f"\n[dim]library[/]  {escape(str(library))}\n[dim]pictures[/] {escape(str(pictures))}", soft_wrap=True
    )
    talk.print("\n[bold]What to try next[/]")
    for command, what in commands.items():
        talk.print(f"  {escape(command)}\n    [dim]{what}[/]", soft_wrap=True)
    talk.print()
