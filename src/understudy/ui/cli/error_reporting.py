"""How commands fail: one paragraph on stderr, an exit code that means something, no traceback unasked."""

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
"""Exit code of a fault in Understudy itself; 2 is for what the user gave, 1 for a result that is bad news."""


class ErrorReportingGroup(TyperGroup):
    """Commands whose errors are reported the same way everywhere."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
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
    """Let nothing more reach a standard output that takes nothing more, not even when the process ends."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refused(error: OSError) -> FileError:
    """What the operating system refused to do with a file, or with standard output where it names none."""
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
    """Whether it is an error of usage, which typer shows itself."""
    return type(error).__module__.startswith(("typer", "click"))


def report_error(error: UnderstudyError) -> int:
    """Say what was wrong, on stderr and with --json on stdout too; the exit code."""
    typer.echo(f"Error: {error}", err=True)
    if "--json" in sys.argv:
        from understudy.ui.cli.output import print_json

        print_json({"error": {"type": error.json_type, "message": str(error), **_fields(error)}})
    return error.exit_code


def _fields(error: UnderstudyError) -> dict[str, Any]:
    plain = (str, int, float, tuple, list, type(None))
    return {key: value for key, value in vars(error).items() if isinstance(value, plain)}
