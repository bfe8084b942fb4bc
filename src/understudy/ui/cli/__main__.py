"""Run the command line with `python -m understudy.ui.cli`."""

from understudy.ui.cli import run_command_line

run_command_line()
