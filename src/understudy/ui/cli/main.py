"""The table of all commands, and the command line made from it, which reports errors in one form."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Annotated, Any

import typer

from understudy import __version__
from understudy.errors import FileError, UnderstudyError
from understudy.ui.cli import FAULT, INTERRUPTED
from understudy.ui.cli.command_group import CommandGroup, CommandTable, show_rare_commands
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.plugins import CHECK, LOOK, RARE, ROBOTS, RUN, SHARE, TEACH, CommandEntry

HERE = "understudy.ui.cli"
ROWS = (
    ("studio", TEACH, "Teach a robot in the browser",
     "studio_options:StudioOptions", "studio:start_studio"),
    ("teach", TEACH, "Teach a robot with the keyboard, in the terminal",
     "lesson_options:TeachOptions", "teach:teach"),
    ("learn", TEACH, "Learn from a table of examples, or from recordings", None, None),
    ("learn table", TEACH, "Learn from a table of examples",
     "lesson_options:LearnTableOptions", "learn_table:learn_table"),
    ("learn recording", TEACH, "Learn from a recorded run and presses",
     "lesson_options:LearnRecordingOptions", "learn_from_recording:learn_recording"),
    ("learn drive", TEACH, "Learn from recordings of a person who drove, without presses",
     "lesson_options:LearnDriveOptions", "learn_from_drive:learn_drive"),
    ("learn drivers", TEACH, "Learn from recordings of several people who drove",
     "lesson_options:LearnDriversOptions", "learn_from_drivers:learn_drivers"),
    ("drive", TEACH, "Drive a simulated robot in the browser, and learn from that",
     "studio_options:DrivingOptions", "studio_drive:drive_robot"),
    ("review", TEACH, "Correct the labels of recorded drives in the browser, and learn",
     "studio_options:ReviewOptions", "studio_drive:review_recordings"),
    ("advise", TEACH, "Suggest what to show next in a lesson",
     "library_options:AdviseOptions", "advise:advise"),
    ("run", RUN, "Run a behavior in a simulated world",
     "run_options:SimulatedRunOptions", "run:run_behavior"),
    ("eval", RUN, "Measure how often a behavior succeeds, in many worlds",
     "run_options:EvaluateOptions", "eval:evaluate_behavior"),
    ("worlds", RUN, "List the simulated worlds, or print the file of one",
     "run_options:WorldsOptions", "worlds:list_worlds"),
    ("list", LOOK, "List the automata of a library",
     "library_options:ListOptions", "list:list_automata"),
    ("show", LOOK, "Show what an automaton learned, and its examples",
     "library_options:ShowOptions", "show:show_automaton"),
    ("draw", LOOK, "Draw an automaton as a picture",
     "library_options:DrawOptions", "show:draw_automata"),
    ("diff", LOOK, "Show what changed between two versions, and why",
     "library_options:DiffOptions", "diff:show_diff"),
    ("why", LOOK, "Explain what a robot did at a moment of a run",
     "run_options:WhyOptions", "why:show_explanation"),
    ("replay", LOOK, "Decide again over a recording, and show the differences",
     "run_options:ReplayOptions", "replay:replay_recording"),
    ("test", CHECK, "Test a library on its lessons and properties",
     "library_options:LibraryTestOptions", "test:run_library_tests"),
    ("check", CHECK, "Find what can go wrong, without running anything",
     "library_options:CheckOptions", "check:check_automata"),
    ("falsify", CHECK, "Look for worlds in which a behavior fails",
     "falsify_options:FalsifyOptions", "falsify:falsify_behavior"),
    ("export", SHARE, "Export an automaton as code, or data of lessons and runs", None, None),
    ("export automaton", SHARE, "Export an automaton as code that runs by itself",
     "export_options:ExportOptions", "export:export_behavior"),
    ("export table", SHARE, "Export a lesson, a session or a run as a table",
     "export_options:ExportTableOptions", "export_data:export_table"),
    ("export dataset", SHARE, "Export runs as a data set for LeRobot or Minari",
     "export_options:ExportDatasetOptions", "export_data:export_dataset"),
    ("export why", SHARE, "Explain the decisions of exported code from its trace",
     "export_options:ExportWhyOptions", "export:explain_exported"),
    ("robots", ROBOTS, "Check, stop and simulate robots, calibrate cameras", None, None),
    ("robots check", ROBOTS, "Show which readings arrive, and what is missing",
     "robots_options:RobotsCheckOptions", "robots:check_robots"),
    ("robots run", ROBOTS, "Run a behavior on real robots",
     "run_options:RobotRunOptions", "run_robot:run_on_robots"),
    ("robots teach", ROBOTS, "Teach a real robot with the keyboard",
     "lesson_options:RobotTeachOptions", "teach:teach_on_robot"),
    ("robots studio", ROBOTS, "Teach real robots in the browser",
     "studio_options:RobotsStudioOptions", "studio:start_robots_studio"),
    ("robots stop", ROBOTS, "Stop robots, whatever program is driving them",
     "robots_options:RobotsStopOptions", "robots_stop:stop_robots"),
    ("robots stops", ROBOTS, "Show when and why a robot was stopped",
     "robots_options:RobotStopsOptions", "robots_stops:show_stops"),
    ("robots color", ROBOTS, "Find a camera's color of an object from images",
     "robots_options:RobotColorOptions", "robots:calibrate_color"),
    ("robots layout", ROBOTS, "Print a layout for Foxglove",
     "robots_options:RobotLayoutOptions", "robots_files:write_layout"),
    ("robots simulate", ROBOTS, "Simulate robots as ROS 2 robots",
     "robots_options:SimulateOptions", "robots_simulate:simulate_robots"),
    ("team", ROBOTS, "Run, see, arm and stop the agents of a team", None, None),
    ("team agent", ROBOTS, "Run one robot or one coordinator of a team",
     "robots_options:AgentOptions", "team:run_agent"),
    ("team status", ROBOTS, "Show what each agent does, and which are missing",
     "robots_options:TeamStatusOptions", "team:show_status"),
    ("team arm", ROBOTS, "Let the robots of a team move",
     "robots_options:TeamArmOptions", "team_orders:arm_team"),
    ("team stop", ROBOTS, "Stop and disarm the robots of a team at once",
     "robots_options:TeamStopOptions", "team_orders:stop_team"),
    ("team logs", ROBOTS, "Show what happened to each agent",
     "robots_options:TeamLogsOptions", "team:show_logs"),
    ("team push", ROBOTS, "Hand a library to all agents of a team",
     "robots_options:TeamPushOptions", "team:push_to_team"),
    ("team merge", ROBOTS, "Merge the recordings of agents into one file",
     "robots_options:TeamMergeOptions", "robots_files:merge_team"),
    ("falsify-body", RARE, "Look for seeds with which a body of your own fails",
     "falsify_options:FalsifyBodyOptions", "falsify_body:falsify_own_body"),
    ("prepare", RARE, "Compile ahead of time, for images and classrooms",
     "run_options:PrepareOptions", "prepare:prepare"),
    ("validate", RARE, "Check every file, name and lesson of a library",
     "library_options:ValidateOptions", "validate:validate"),
    ("rebuild", RARE, "Learn trees again that no longer match their examples",
     "library_options:RebuildOptions", "validate:rebuild"),
    ("simplify", RARE, "Prune trees, and see which decisions change",
     "library_options:SimplifyOptions", "simplify:simplify"),
)  # fmt: skip
"""Name, heading, summary, options and place of each command; a group of commands has no place."""

COMMANDS = [
    CommandEntry("more", show_rare_commands, RARE, "List these commands"),
    *(
        CommandEntry(
            name, run and f"{HERE}.commands.{run}", heading, summary, options and f"{HERE}.{options}"
        )
        for name, heading, summary, options, run in ROWS
    ),
]


class CommandLine(CommandGroup):
    """The command line `understudy` with all commands; it catches their errors and reports them in one form."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__("", CommandTable(COMMANDS), **attributes)

    def invoke(self, ctx: Any) -> Any:
        """Run the command, and turn errors into a message and an exit code."""
        try:
            return super().invoke(ctx)
        except UnderstudyError as error:
            if ctx.params.get("debug"):
                raise
            raise typer.Exit(report_error(error)) from error
        except KeyboardInterrupt as error:
            typer.echo("\nInterrupted.", err=True)
            raise typer.Exit(INTERRUPTED) from error
        except BrokenPipeError as error:  # as in `understudy list | head -1`
            _print_no_more()
            raise typer.Exit(0) from error
        except (typer.Exit, typer.Abort):
            raise
        except OSError as error:
            if ctx.params.get("debug"):
                raise
            raise typer.Exit(report_error(_refused(error))) from error
        except Exception as error:
            if ctx.params.get("debug") or _of_typer(error):
                raise
            typer.echo(
                f"Error: something broke inside Understudy: {_named(error)}. This is a fault of the "
                "program, not yours, and no file was left half written. To report it, run it again as "
                f"`understudy --debug {' '.join(sys.argv[1:])}` and send what it prints.",
                err=True,
            )
            raise typer.Exit(FAULT) from error


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


def make_command_line() -> typer.Typer:
    """Make the command line with all commands; the module of a command is imported when it is called."""
    app = typer.Typer(
        cls=CommandLine,
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        add_completion=True,  # of shells: --install-completion and --show-completion
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="Start with understudy demo. Every command has --help, and --json for programs.\n"
        "The others, rarely needed, are listed by understudy more.",
    )
    app.callback()(understudy)
    return app


def _print_no_more() -> None:
    """Redirect standard output to the null device, so that no later write can fail on a closed pipe."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refused(error: OSError) -> FileError:
    """Convert an error of the operating system to a `FileError`; without a file name, standard output failed."""
    if error.filename is None:
        _print_no_more()
    return FileError(
        path=error.filename or "standard output",
        place="",
        problem=error.strerror or str(error),
        remedy="see that it exists, that you may use it, and that the disk has room",
    )


def _named(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _of_typer(error: Exception) -> bool:
    """Return whether an error is one of command-line usage, which typer reports itself."""
    return type(error).__module__.startswith(("typer", "click"))


def report_error(error: UnderstudyError) -> int:
    """Print the error on stderr, and with `--json` as an object on stdout; return its exit code."""
    message = ". ".join([str(error), *getattr(error, "__notes__", ())])
    typer.echo(f"Error: {message}", err=True)
    if "--json" in sys.argv or "--format json" in " ".join(sys.argv).replace("=", " "):
        print_json({"error": {"type": error.json_type, "message": message, **_fields(error)}})
    return error.exit_code


def _fields(error: UnderstudyError) -> dict[str, Any]:
    plain = (str, int, float, tuple, list, type(None))
    return {key: value for key, value in vars(error).items() if isinstance(value, plain) and key[0] != "_"}
