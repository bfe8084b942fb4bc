"""The experiment: many teachings of each variant and of its reference, with the same seeds."""

from __future__ import annotations

from understudy_lab.ablation.evaluate import measure_variant
from understudy_lab.ablation.findings import conclude, draw
from understudy_lab.ablation.variants import BASE, VARIANTS
from understudy_lab.study import Row, Study, StudyPlan, Task

SEEDS = range(56_000, 56_020)


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per variant and seed; the variants of one seed share their test worlds."""
    return [{"variant": name, "seed": seed} for seed in plan.seeds for name in VARIANTS]


def work(task: Task) -> Row:
    """Run and test one teaching of a variant; only the base keeps its lessons."""
    row = measure_variant(task["variant"], task["seed"])
    return row if task["variant"] == BASE else {key: row[key] for key in row if key != "lessons"}


EXPERIMENT = Study(
    name="ablation",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage",),
)
