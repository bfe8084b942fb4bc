"""Assembly of all commands; each module imports its dependencies only when its command is called."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from understudy import __version__
from understudy.ui.cli.error_reporting import ErrorReportingGroup
from understudy.ui.cli.plugins import LIBRARY, RUNNING, TEACHING, CommandEntry, load_plugins, order_commands

HERE = "understudy.ui.cli.commands"
COMMANDS = (
    CommandEntry("studio", f"{HERE}.studio:start_studio", TEACHING),
    CommandEntry("teach", f"{HERE}.teach:teach", TEACHING),
    CommandEntry("learn", f"{HERE}.learn:learn_lesson", TEACHING),
    CommandEntry("advise", f"{HERE}.advise:advise", TEACHING),
    CommandEntry("run", f"{HERE}.run:run_behavior", RUNNING),
    CommandEntry("why", f"{HERE}.why:show_explanation", RUNNING),
    CommandEntry("eval", f"{HERE}.eval:evaluate_behavior", RUNNING),
    CommandEntry("worlds", f"{HERE}.worlds:list_worlds", RUNNING),
    CommandEntry("prepare", f"{HERE}.prepare:prepare", RUNNING),
    CommandEntry("robots", f"{HERE}.robots:app", RUNNING),
    CommandEntry("agent", f"{HERE}.agent:run_agent", RUNNING),
    CommandEntry("team", f"{HERE}.team:app", RUNNING),
    CommandEntry("list", f"{HERE}.list:list_automata", LIBRARY),
    CommandEntry("show", f"{HERE}.show:show_automaton", LIBRARY),
    CommandEntry("draw", f"{HERE}.draw:draw_automata", LIBRARY),
    CommandEntry("diff", f"{HERE}.diff:show_diff", LIBRARY),
    CommandEntry("validate", f"{HERE}.validate:validate", LIBRARY),
    CommandEntry("test", f"{HERE}.test:run_library_tests", LIBRARY),
    CommandEntry("check", f"{HERE}.check:check_automata", LIBRARY),
    CommandEntry("falsify", f"{HERE}.falsify:falsify_behavior", LIBRARY),
    CommandEntry("simplify", f"{HERE}.simplify:simplify", LIBRARY),
    CommandEntry("export", f"{HERE}.export:app", LIBRARY),
    CommandEntry("rebuild", f"{HERE}.list:rebuild", LIBRARY),
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"understudy {__version__}")
        raise typer.Exit


def understudy(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Train robots, and teams of robots, by being shown."""


def make_command_line(arguments: Sequence[str] = ()) -> typer.Typer:
    """Make the command line with all commands, or, if the arguments name a built-in one, with this one alone.

    The modules of the other commands, and other packages that add some, are then not imported, which takes longer than
    many a command.
    """
    app = typer.Typer(
        cls=ErrorReportingGroup,
        no_args_is_help=True,
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        add_completion=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="Start with [bold]understudy demo[/]. Every command has --help, and --json for output to programs.",
    )
    app.callback()(understudy)
    asked = next((argument for argument in arguments if not argument.startswith("-")), None)
    wanted = [command for command in COMMANDS if command.name == asked]
    for command in wanted or order_commands(COMMANDS, load_plugins()):
        command.add_to(app)
    return app
