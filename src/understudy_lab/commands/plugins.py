"""The commands of the laboratory, as entry points name them."""

from __future__ import annotations

from understudy.ui.cli.plugins import MEASURING, TEACHING, Command
from understudy_lab.commands import bench, demo, experiment

demo_command = Command("demo", demo.demo, TEACHING)
experiment_command = Command("experiment", experiment.experiment, MEASURING)
bench_command = Command("bench", bench.app, MEASURING)
