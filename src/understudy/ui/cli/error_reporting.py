"""Error reporting of all commands: one paragraph on stderr, an exit code, a traceback only with `--debug`."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from understudy.errors import FileError, UnderstudyError
from understudy.ui.cli import INTERRUPTED

FAULT = 70
"""Exit code for a fault in Understudy itself; 2 means wrong input, 1 an unfavorable result."""


class ErrorReportingGroup(TyperGroup):
    """Command group that catches the errors of all its commands and reports them in one form."""

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
    typer.echo(f"Error: {error}", err=True)
    if "--json" in sys.argv:
        from understudy.ui.cli.output import print_json

        print_json({"error": {"type": error.json_type, "message": str(error), **_fields(error)}})
    return error.exit_code


def _fields(error: UnderstudyError) -> dict[str, Any]:
    plain = (str, int, float, tuple, list, type(None))
    return {key: value for key, value in vars(error).items() if isinstance(value, plain)}
