"""The experiment: a patrol that one program decides for, and that agents with links of their own decide for.

It needs root, and a machine that does nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from understudy.errors import SettingError
from understudy.extras import ExtraMissing
from understudy_lab.declaration import Conclusion, Goal
from understudy_lab.figures import Panels, dots
from understudy_lab.lossy_networks.distributed_patrol import (
    MEMBERS,
    measure_cycles,
    run_apart,
    run_together,
    save_library,
    simulate,
)
from understudy_lab.lossy_networks.links import NONE, Loss, LossyLinks, find_obstacle
from understudy_lab.patrol.practice import teach
from understudy_lab.rows import Rows, group_by_arm
from understudy_lab.study import ResultTable, Row, Study, StudyPlan, Task

SEEDS = range(67_000, 67_004)
"""The teaching seeds of the published result; none was used during development."""
RUNS = (1, 2)
"""The number of runs of each teaching over each network; they differ, because they run in real time."""
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
    libraries = teach(seed).libraries
    row: dict[str, Any] = {}
    for network, loss in NETWORKS.items():
        with TemporaryDirectory() as name:
            folder = Path(name)
            save_library(libraries, folder / "library")
            with simulate(folder, seed):
                if loss is None:
                    done = run_together(folder, libraries, seconds=SECONDS)
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


BY_NETWORK = group_by_arm(NETWORKS)
COUNTED = {
    "minutes": "minutes",
    "captures": "captures",
    "cycles": "cycles",
    "complete": "complete",
    "per_hour": "complete per hour",
}


def _sum(rows: Rows) -> dict[str, float]:
    sums = {key: round(sum(rows.values(key)), 2) for key in ("minutes", "captures", "cycles", "complete")}
    return {**sums, "per_hour": round(_per_hour(sums), 2)}


def _per_hour(sums: Mapping[str, Any]) -> float:
    return _divide(sums["complete"] * 60.0, sums["minutes"])


def _divide(value: float, by: float) -> float:
    return value / by if by else 0.0


def _share(groups: Mapping[str, Rows], network: str) -> float:
    """Return a network's complete cycles per hour, relative to those in one program."""
    return _divide(*(_sum(groups[each])["per_hour"] for each in (network, ONE)))


def _headline(groups: Mapping[str, Rows]) -> str:
    return (
        f"Agents in network namespaces of their own complete {_share(groups, WELL):.0%} of the cycles that one program "
        f"completes, and {_share(groups, LOSES):.0%} if 20 % of packets are lost and the others come 0.1 s later."
    )


def _table(groups: Mapping[str, Rows]) -> ResultTable:
    sums, runs = {network: _sum(rows) for network, rows in groups.items()}, groups[ONE]
    return ResultTable(
        f"{len(runs.seeds)} teachings, each in one unseen world, {len(runs)} runs over each network, "
        f"{sum(each['minutes'] for each in sums.values()):.0f} minutes in real time altogether",
        ("network", *(f"#{head}" for head in COUNTED.values()), "#/ one program"),
        [
            (network, *(f"{each[key]:g}" for key in COUNTED), f"{_share(groups, network):.2f}")
            for network, each in sums.items()
        ],
    )


def _dots(label: str, of: Callable[[Rows], list[float]], top: Callable[[list[float]], float | None]) -> Any:
    def draw(axes: Any, rows_by_network: Mapping[str, Rows]) -> None:
        groups = {name.replace(", ", ",\n"): of(rows) for name, rows in rows_by_network.items()}
        dots(axes, groups, label)
        axes.set_ylim(0, top([value for each in groups.values() for value in each]))

    return draw


EXPERIMENT = Study(
    name="networks",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=BY_NETWORK,
        headline=_headline,
        tables=(_table,),
        goals=[
            Goal(
                f"complete cycles over the network '{network}' / in one program",
                partial(_share, network=network),
                least=wanted,
            )
            for network, wanted in GOALS.items()
        ],
        numbers=lambda groups: {network: _sum(rows) for network, rows in groups.items()},
    ),
    draw=Panels(
        (
            _dots("complete cycles per hour", lambda rows: rows.values(_per_hour), lambda rates: None),
            _dots(
                "duration of a cycle, s",
                lambda rows: [each for row in rows for each in row["cycle_s"] if each is not None],
                lambda durations: max(durations, default=1.0) * 1.1,
            ),
        ),
        wide=3.6,
        prepare=BY_NETWORK,
    ),
    worlds=("patrol",),
    varies=tuple(NETWORKS),
    check_machine=check_machine,
    in_real_time=True,
)
