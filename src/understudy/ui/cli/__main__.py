"""So that `python -m understudy.ui.cli` is the command line too."""

from understudy.ui.cli import main

main()
