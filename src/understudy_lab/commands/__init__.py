"""The commands `demo`, `experiment` and `bench`, which the package registers as entry points."""

from __future__ import annotations

from understudy.ui.cli.plugins import RARE, TEACH, CommandEntry

HERE = "understudy_lab.commands"
demo_command = CommandEntry(
    "demo",
    f"{HERE}.demo:demo",
    TEACH,
    "See simulated robots be taught, and tested",
    f"{HERE}.options:DemoOptions",
)
experiment_command = CommandEntry(
    "experiment",
    f"{HERE}.experiment:experiment",
    RARE,
    "Run a published experiment again, and compare",
    f"{HERE}.options:ExperimentOptions",
)
bench_command = CommandEntry("bench", f"{HERE}.bench:app", RARE, "Measure speed beside peers, in one run")
