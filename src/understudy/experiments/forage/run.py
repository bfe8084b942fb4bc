"""The experiment: many teachings, each judged on its own unseen worlds; with both methods side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from understudy.evaluation import measure
from understudy.experiments.forage.teaching import METHODS, summary, teach_and_judge, worlds_of
from understudy.worlds.forage import Forage
from understudy.worlds.forage_expert import HandForager, lower_bound

TEACHINGS = range(41_000, 41_020)
"""The teaching seeds of the published result: nobody had looked at any of them before."""

GOALS = {"taught well": 0.95, "worst": 0.85, "relative_to_expert": 0.92, "examples": 80, "seconds": 600.0}


def run(
    seeds: Sequence[int] = TEACHINGS, *, progress: Callable[[int, int], None] = lambda done, total: None
) -> dict[str, Any]:
    """Teach and judge each seed with each method. Plain data: a summary and the rows behind it, by method."""
    done, total = 0, len(seeds) * len(METHODS)
    results: dict[str, Any] = {"experiment": "forage", "seeds": [seeds[0], seeds[-1] + 1], "methods": {}}
    for method in METHODS:
        rows = []
        for seed in seeds:
            progress(done, total)
            rows.append(summary(teach_and_judge(seed, method=method)))
            done += 1
        results["methods"][method] = {**overall(rows), "teachings": rows}
    results["yardstick"] = yardstick(seeds)
    results["misses"] = misses(results["methods"]["watched"])
    results["passed"] = not results["misses"]
    progress(total, total)
    return results


def overall(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Medians and spread over teachings: the taught automaton is the unit, never the world."""
    success = np.array([row["success"] for row in rows])
    return {
        "teachings_reaching_95": int((success >= 0.95).sum()),
        "of": len(rows),
        "success": spread(success),
        "relative_to_expert": spread([row["relative_to_expert"] for row in rows]),
        "examples": spread([row["examples"]["total"] for row in rows]),
        "presses": spread([row["presses"] for row in rows]),
        "teaching_seconds": spread([row["teaching_seconds"] for row in rows]),
        "corner_cases": {
            name: spread([row["corner_cases"][name] for row in rows]) for name in rows[0]["corner_cases"]
        },
    }


def spread(values: Sequence[float] | np.ndarray[Any, Any]) -> dict[str, float]:
    """Smallest, median and largest."""
    low, middle, high = np.percentile(np.asarray(values, np.float64), [0, 50, 100])
    return {"min": round(float(low), 4), "median": round(float(middle), 4), "max": round(float(high), 4)}


def yardstick(seeds: Sequence[int]) -> dict[str, float]:
    """The hand-coded forager's time as a multiple of its lower bound, over the worlds of all teachings."""
    worlds = [world for seed in seeds for world in worlds_of(seed)]
    body = Forage(worlds)
    bound = lower_bound(body)
    hand = HandForager(body.agents, body.settings)
    return spread(measure(body, hand.decide, hand.keys, limit_s=10.0 * bound + 60.0).seconds / bound)


def misses(result: dict[str, Any]) -> list[str]:
    """What falls short of the goals, in words."""
    wanted = int(np.ceil(GOALS["taught well"] * result["of"]))
    checks = {
        f"{result['teachings_reaching_95']} of {result['of']} teachings reach 95 % success, not {wanted}": (
            result["teachings_reaching_95"] >= wanted
        ),
        f"the worst teaching reaches {result['success']['min']:.0%}, not 85 %": (
            result["success"]["min"] >= GOALS["worst"]
        ),
        f"median food per second is {result['relative_to_expert']['median']:.3f} of the yardstick's, not 0.92": (
            result["relative_to_expert"]["median"] >= GOALS["relative_to_expert"]
        ),
        f"a median teaching takes {result['examples']['median']:.0f} examples, more than 80": (
            result["examples"]["median"] <= GOALS["examples"]
        ),
        f"a median teaching takes {result['teaching_seconds']['median']:.0f} s, more than 600": (
            result["teaching_seconds"]["median"] <= GOALS["seconds"]
        ),
    }
    return [text for text, held in checks.items() if not held]
