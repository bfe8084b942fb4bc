"""Run the measurements of `understudy bench`, and print them as tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any, TypeAlias

import typer

from understudy.extras import format_install_command
from understudy.jit.settings import compile_on_first_call
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.viz.appearance import format_thousands

Result: TypeAlias = dict[str, Any]

SOURCES: Mapping[str, str] = MappingProxyType(
    {
        "looks": "learning.run_looks",
        "crowding": "swarm.run_crowding",
        "million": "swarm.run_million",
        "squads": "swarm.run_squads",
        "robots": "robot_latency.run",
    }
)
"""The function of each measurement that is not called `run` in a module of its own name."""
NOISE = "Medians; on a machine that does other things too, trust ratios to about 20 %."


def measure(*names: str, as_json: bool) -> None:
    """Run measurements by name and print them, importing the module of each only when it is needed."""
    compile_on_first_call()
    results: dict[str, Result] = {}
    for name in names:
        module, _, function = SOURCES.get(name, f"{name}.run").partition(".")
        results[name] = getattr(import_module(f"understudy_lab.bench.{module}"), function)()
        if not as_json:
            TABLES.get(name, print_speeds)(results[name])
    passed = all(result["passed"] for result in results.values())
    if as_json:
        print_json(results[names[0]] if len(names) == 1 else {**results, "passed": passed})
    else:
        make_console().print(f"[dim]{NOISE}[/]")
    raise typer.Exit(0 if passed else 1)


def print_learning(result: Result) -> None:
    """Print the times to learn a tree."""
    table = make_table(
        "#examples", "#ours ms", "#from a lesson ms", "#scikit-learn ms", "no slower", title="Learning"
    )
    for row in result["sizes"]:
        times = [f"{row[key]:.3g}" for key in ("ours_ms", "from_lesson_ms", "sklearn_ms")]
        table.add_row(str(row["examples"]), *times, _mark(row["as_fast"]))
    make_console().print(table)
    goals = make_table("5 % noise, ms", "#goal", "#ours", "#from a lesson", "reached")
    for row in result["goals"]:
        times = [f"{row[key]:.3g}" for key in ("goal_ms", "ours_ms", "from_lesson_ms")]
        goals.add_row(row["what"], *times, _mark(row["passed"]))
    make_console().print(goals)
    walls = result["wall_following"]
    table = make_table("~learner", "#processor ms", "#right in cross-validation", title=walls["what"])
    for name, taken in walls["processor_ms"].items():
        table.add_row(name, f"{taken:.3g}", f"{walls['accuracy'][name]:.2%}")
    make_console().print(table)
    make_console().print(f"{walls['ratio']:.2f} times scikit-learn's time; {_mark(walls['passed'])}")


def print_looks(result: Result) -> None:
    """Print the times of analyses of a lesson."""
    title = f"Looking at {result['examples']} examples"
    table = make_table("", "#ms", "#at most", "reached", title=title)
    for row in result["looks"]:
        table.add_row(row["what"], f"{row['ms']:.3g}", f"{row['goal_ms']:g}", _mark(row["passed"]))
    make_console().print(table)


def print_segmentation(result: Result) -> None:
    """Print the time to segment a recording."""
    table = make_table("", "#behaviors", "#s", "#at most", "reached", title="Segmenting a recording")
    what = f"{result['hours']:g} h, {result['ticks']} ticks"
    times = f"{result['s']:.3g}", f"{result['goal_s']:g}"
    table.add_row(what, str(result["behaviors"]), *times, _mark(result["passed"]))
    make_console().print(table)


def print_reading(result: Result) -> None:
    """Print the time to read a bag."""
    table = make_table(
        "", "#topics", "#mapped", "#s", "#at most", "reached", title="Reading a bag of an hour"
    )
    counts = str(result["topics"]), str(result["mapped"])
    times = f"{result['s']:.3g}", f"{result['goal_s']:g}"
    table.add_row(f"measured with {result['ticks']} ticks", *counts, *times, _mark(result["passed"]))
    make_console().print(table)


def print_interpreter(result: Result) -> None:
    """Print the times of one decision."""
    table = make_table("", "#µs", "goal", "reached", title="Deciding")
    ours, ratio = result["pulse_us"], result["ratio"]
    levels = " > ".join(result["path"])
    table.add_row(
        f"a pulse ({levels})",
        f"{ours:.2f}",
        f"at most {result['goal_us']:g}",
        _mark(ours <= result["goal_us"]),
    )
    table.add_row(
        f"a tick of py_trees, {result['py_trees_nodes']} nodes", f"{result['py_trees_us']:.2f}", "", ""
    )
    wanted = f"at least {result['goal_ratio']:g}"
    table.add_row("times faster", f"{ratio:.1f}", wanted, _mark(ratio >= result["goal_ratio"]))
    make_console().print(table)


def print_robots(result: Result) -> None:
    """Print the times from a reading to its command."""
    title = "From a reading to its command, ms"
    table = make_table("~", "#messages", "#median", "#99 of 100", "#longest", "#lost", title=title)
    for row in result["results"]:
        times = [f"{row[key]:.2f}" for key in ("p50_ms", "p99_ms", "max_ms")]
        table.add_row(row["what"], str(row["messages"]), *times, str(row["lost"]))
    make_console().print(table)
    _print_goals(result)


def print_start(result: Result) -> None:
    """Print the times from a command to its end."""
    table = make_table("~from a command to its end, s", "cache", "#median", "#range", title="Starting")
    for row in result["results"]:
        table.add_row(
            row["case"], row["cache"], f"{row['s']:.2f}", f"{row['least_s']:.2f}–{row['most_s']:.2f}"
        )
    make_console().print(table)
    _print_goals(result)


def _print_goals(result: Result) -> None:
    goals = make_table("~goal", "#at most", "#measured", "reached")
    for goal in result["goals"]:
        measured = "-" if goal["passed"] is None else f"{goal['value']:.2f}"
        goals.add_row(goal["what"], f"{goal['most']:g}", measured, _mark(goal["passed"]))
    make_console().print(goals)
    for peer in result["missing"]:
        make_console().print(f"Not measured: {peer}.", markup=False)


def _mark(reached: bool | None) -> str:
    return "[dim]not measured[/]" if reached is None else "[green]yes[/]" if reached else "[red]no[/]"


def print_speeds(result: Result) -> None:
    """Print robot-ticks per second."""
    title = "Running: robot-ticks per second"
    table = make_table("~task", "#robots", "#threads", "#speed", "#spread", "#of by hand", title=title)
    shares = {
        (row["task"], row["robots"], row["threads"]): row["of_by_hand"] for row in result.get("fractions", ())
    }
    for row in result["results"]:
        key = task, robots, threads = row["task"], row["robots"], row["threads"]
        spread = f"{row['spread']:.0%}" if "spread" in row else ""
        share = f"{shares[key]:.0%}" if key in shares else ""
        table.add_row(
            task, format_thousands(robots), str(threads), short(row["robot_ticks_per_s"]), spread, share
        )
    make_console().print(table)
    goals = make_table("~goal", "#wanted", "#measured", "reached")
    for row in result["goals"]:
        wanted = f"at least {short(row['least'])}" if "least" in row else f"at most {short(row['most'])}"
        measured = "-" if row["passed"] is None else short(row["value"])
        goals.add_row(row["what"], wanted, measured, _mark(row["passed"]))
    make_console().print(goals)
    for peer in result.get("missing", ()):
        extra = "bench-vmas" if "VMAS" in peer else "bench"
        print(f"Not measured: {peer}. Install it with: {format_install_command(extra)}")


def short(number: float) -> str:
    """Format a number with three digits: 0.98, 57, 1 000, 20 k, 6.5 M."""
    rounded = float(f"{number:.3g}")
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(rounded) >= max(size, 10_000):
            return f"{rounded / size:g} {letter}"
    return format_thousands(int(rounded)) if abs(rounded) >= 1000 else f"{rounded:g}"


TABLES: Mapping[str, Callable[[Result], None]] = MappingProxyType(
    {
        "learning": print_learning,
        "looks": print_looks,
        "reading": print_reading,
        "segmentation": print_segmentation,
        "interpreter": print_interpreter,
        "start": print_start,
        "robots": print_robots,
    }
)
"""The function that prints each measurement that is not one of robot-ticks per second."""
