"""The experiment: a patrol that one program decides for, and that agents with links of their own decide for.

It needs root, and a machine that does nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import SettingError
from understudy.extras import ExtraMissing
from understudy_lab.figures import dots, panels
from understudy_lab.lossy_networks.distributed_patrol import (
    MEMBERS,
    measure_cycles,
    run_apart,
    run_together,
    save_library,
    simulate,
)
from understudy_lab.lossy_networks.links import NONE, Loss, LossyLinks, find_obstacle
from understudy_lab.patrol.teach import teach
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(67_000, 67_004)
"""The teaching seeds of the published result; none was used during development."""
RUNS = (1, 2)
"""Each teaching runs so often over each network, because runs in real time differ."""
SECONDS = 240.0
"""The length of a run, s, in real time."""
LOSSY = Loss(0.2, 0.1, 0.03)
NETWORKS: Mapping[str, Loss | None] = {"one program": None, "no loss": NONE, "20 % loss, 100 ms": LOSSY}
"""The networks between the agents; None: one program decides for all robots."""
ONE, WELL, LOSES = NETWORKS
GOALS: Mapping[str, float] = {WELL: 0.9, LOSES: 0.8}
"""The cycles that are asked for, relative to those of one program."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per seed and run; in the quick version each runs once."""
    return [{"seed": seed, "run": run} for run in RUNS[: 1 if plan.quick else None] for seed in plan.seeds]


def work(task: Task) -> Row:
    """Teach a patrol, and run it in the same unseen world over each of the networks; refuse where that cannot be."""
    check_machine()
    seed = task["seed"]
    taught = teach(seed)
    row: dict[str, Any] = {}
    for network, loss in NETWORKS.items():
        with TemporaryDirectory() as name:
            folder = Path(name)
            save_library(taught, folder / "library")
            with simulate(folder, seed):
                if loss is None:
                    done = run_together(folder, taught, seconds=SECONDS)
                else:
                    with LossyLinks(MEMBERS, loss, seed=seed) as links:
                        done = run_apart(folder, folder / "library", links, seconds=SECONDS)
            row[network] = measure_cycles(folder, done)
    return row


def check_machine() -> None:
    """Raise UnderstudyError if this machine cannot run it."""
    if obstacle := find_obstacle():
        raise SettingError(
            where="experiment networks", setting="this machine", problem=f"cannot run it: {obstacle}",
            remedy="run it as root on Linux",
        )  # fmt: skip
    for module, extra in (("mujoco", "mujoco"), ("zenoh", "ros2")):
        if find_spec(module) is None:
            raise ExtraMissing(what="the experiment networks", extra=extra)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize how many cycles agents complete, compared with one program."""
    found = {network: _sum(rows, network) for network in NETWORKS}
    shares = {network: _divide(each["per_hour"], found[ONE]["per_hour"]) for network, each in found.items()}
    minutes = sum(each["minutes"] for each in found.values())
    teachings = len({row["task"]["seed"] for row in rows})
    return StudyFindings(
        headline=(
            f"Agents in network namespaces of their own complete {shares[WELL]:.0%} of the cycles that one program "
            f"completes, and {shares[LOSES]:.0%} if 20 % of packets are lost and the others come 0.1 s later."
        ),
        tables=(
            ResultTable(
                f"{teachings} teachings, each in one unseen world, {len(rows)} runs over each network, "
                f"{minutes:.0f} minutes in real time altogether",
                (
                    "network",
                    "#minutes",
                    "#captures",
                    "#cycles",
                    "#complete",
                    "#complete per hour",
                    "#/ one program",
                ),
                [_told(network, each, shares[network]) for network, each in found.items()],
            ),
        ),
        goals=tuple(
            StudyGoal(
                f"complete cycles over the network '{network}' / in one program",
                f"{wanted:.0%}",
                f"{shares[network]:.0%}",
                shares[network] >= wanted,
            )
            for network, wanted in GOALS.items()
        ),
        numbers=found,
    )


def _sum(rows: Sequence[Row], network: str) -> dict[str, Any]:
    keys = ("minutes", "captures", "cycles", "complete")
    found = {key: round(sum(row[network][key] for row in rows), 2) for key in keys}
    return {**found, "per_hour": round(_divide(found["complete"] * 60.0, found["minutes"]), 2)}


def _divide(value: float, by: float) -> float:
    return value / by if by else 0.0


def _told(network: str, found: Mapping[str, Any], share: float) -> tuple[str, ...]:
    counts = tuple(f"{found[key]:g}" for key in ("minutes", "captures", "cycles", "complete", "per_hour"))
    return (network, *counts, f"{share:.2f}")


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the complete cycles per hour of every teaching, and the duration of every cycle."""
    figure, (rates, durations) = panels(2, wide=3.6)
    per_hour = {
        network: [_divide(row[network]["complete"] * 60.0, row[network]["minutes"]) for row in rows]
        for network in NETWORKS
    }
    seconds = {
        network: [each for row in rows for each in row[network]["cycle_s"] if each is not None]
        for network in NETWORKS
    }
    dots(
        rates,
        {name.replace(", ", ",\n"): each for name, each in per_hour.items()},
        "complete cycles per hour",
    )
    dots(
        durations,
        {name.replace(", ", ",\n"): each for name, each in seconds.items()},
        "duration of a cycle, s",
    )
    rates.set_ylim(0, None)
    durations.set_ylim(0, max((np.max(each) for each in seconds.values() if each), default=1.0) * 1.1)
    return figure


EXPERIMENT = Study(
    name="networks",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("patrol",),
    varies=tuple(NETWORKS),
    check_machine=check_machine,
    in_real_time=True,
)
