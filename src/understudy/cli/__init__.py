"""The command line: the composition root, which joins sessions, libraries, worlds and pictures."""

from __future__ import annotations


def main() -> None:
    """Run the command that the arguments name, and end the process with its exit code."""
    from understudy.cli.app import app

    app(prog_name="understudy")


__all__ = ["main"]
