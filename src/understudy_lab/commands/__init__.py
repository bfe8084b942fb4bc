"""The commands `demo`, `experiment` and `bench`, which the package registers as entry points."""

from __future__ import annotations

from understudy.ui.cli.plugins import MEASURING, TEACHING, CommandEntry
from understudy_lab.commands import bench, demo, experiment

demo_command = CommandEntry("demo", demo.demo, TEACHING)
experiment_command = CommandEntry("experiment", experiment.experiment, MEASURING)
bench_command = CommandEntry("bench", bench.app, MEASURING)
