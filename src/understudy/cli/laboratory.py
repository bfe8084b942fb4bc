"""The commands of the laboratory, as entry points name them."""

from __future__ import annotations

from understudy.cli import bench, demo, experiment
from understudy.cli.plugins import MEASURING, TEACHING, Command

demo_command = Command("demo", demo.demo, TEACHING)
experiment_command = Command("experiment", experiment.experiment, MEASURING)
bench_command = Command("bench", bench.app, MEASURING)
