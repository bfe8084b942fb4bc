"""So that `python -m understudy.cli` is the command line too."""

from understudy.cli import main

main()
