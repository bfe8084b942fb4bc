"""The command `understudy bench`: measure speed against other programs, on the same machine in the same run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any

import typer

from understudy.extras import format_install_command
from understudy.ui.cli.options import Json

app = typer.Typer(help="Measure speed beside peers, in one run on this machine.", invoke_without_command=True)

SOURCES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "looks": ("learning", "run_looks"),
        "crowding": ("swarm", "run_crowding"),
        "million": ("swarm", "run_million"),
        "squads": ("swarm", "run_squads"),
        "robots": ("robot_latency", "run"),
    }
)
"""The module and function of each measurement that is not called `run` in a module of its own name."""

NOISE = "Medians; on a machine that does other things too, trust ratios to about 20 %."


@app.callback()
def everything(ctx: typer.Context, as_json: Json = False) -> None:
    """Measure speed against other programs, in one run on this machine; without a name, run all measurements."""
    if ctx.invoked_subcommand is None:
        _measure(*MEASUREMENTS, as_json=as_json)


@app.command("learning")
def learning(as_json: Json = False) -> None:
    """Compare the time to learn a tree with scikit-learn's DecisionTreeClassifier.fit."""
    _measure("learning", as_json=as_json)


@app.command("looks")
def looks(as_json: Json = False) -> None:
    """Compare the analyses of a lesson of 200 examples with a fit of scikit-learn."""
    _measure("looks", as_json=as_json)


@app.command("segmentation")
def segmentation(as_json: Json = False) -> None:
    """Measure the time to find behaviors in an hour of driving."""
    _measure("segmentation", as_json=as_json)


@app.command("interpreter")
def interpreter(as_json: Json = False) -> None:
    """Compare one update of a three-level automaton with one of a py_trees tree of 11 nodes."""
    _measure("interpreter", as_json=as_json)


@app.command("swarm")
def swarm(as_json: Json = False) -> None:
    """Compare swarms of 100 to 100 000 robots with Mesa 3, VMAS and hand-written code (takes minutes)."""
    _measure("swarm", as_json=as_json)


@app.command("patrol")
def patrol(as_json: Json = False) -> None:
    """Measure the paper's patrol world, one world alone and a thousand in parallel."""
    _measure("patrol", as_json=as_json)


@app.command("environments")
def environments(as_json: Json = False) -> None:
    """Measure scenarios as environments of Gymnasium and PettingZoo, beside VMAS and a PettingZoo environment."""
    _measure("environments", as_json=as_json)


@app.command("squads")
def squads(as_json: Json = False) -> None:
    """Measure two hundred and ten thousand robots in three levels of squads, compared with real time."""
    _measure("squads", as_json=as_json)


@app.command("crowding")
def crowding(as_json: Json = False) -> None:
    """Compare robots that all drive to one point with the same task spread out (takes minutes)."""
    _measure("crowding", as_json=as_json)


@app.command("million")
def million(as_json: Json = False) -> None:
    """Measure the speed and the memory of a million robots."""
    _measure("million", as_json=as_json)


@app.command("start")
def start(as_json: Json = False) -> None:
    """Measure how long a person waits after a command, with empty and full caches, beside peers (takes minutes)."""
    _measure("start", as_json=as_json)


@app.command("robots")
def robots(as_json: Json = False) -> None:
    """Measure the time from a sensor value to the command it causes in another process, over DDS and Zenoh."""
    _measure("robots", as_json=as_json)


def _measure(*names: str, as_json: bool) -> None:
    """Run measurements by name, importing each module only when it is needed."""
    from understudy.jit.settings import compile_on_first_call
    from understudy.ui.cli.output import make_console, print_json

    compile_on_first_call()
    results: dict[str, dict[str, Any]] = {}
    for name in names:
        module, function = SOURCES.get(name, (name, "run"))
        results[name] = getattr(import_module(f"understudy_lab.bench.{module}"), function)()
        if not as_json:
            MEASUREMENTS[name](results[name])
    passed = all(result["passed"] for result in results.values())
    if as_json:
        print_json(results[names[0]] if len(names) == 1 else {**results, "passed": passed})
    else:
        make_console().print(f"[dim]{NOISE}[/]")
    raise typer.Exit(0 if passed else 1)


def _learning(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    made = make_table(
        "#examples", "#ours ms", "#from a lesson ms", "#scikit-learn ms", "no slower", title="Learning"
    )
    for row in result["sizes"]:
        times = [f"{row[key]:.3g}" for key in ("ours_ms", "from_lesson_ms", "sklearn_ms")]
        made.add_row(str(row["examples"]), *times, _mark(row["as_fast"]))
    make_console().print(made)
    goals = make_table("5 % noise, ms", "#goal", "#ours", "#from a lesson", "reached")
    for row in result["goals"]:
        times = [f"{row[key]:.3g}" for key in ("goal_ms", "ours_ms", "from_lesson_ms")]
        goals.add_row(row["what"], *times, _mark(row["passed"]))
    make_console().print(goals)


def _looks(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    title = f"Looking at {result['examples']} examples"
    made = make_table("", "#ms", "#at most", "reached", title=title)
    for row in result["looks"]:
        made.add_row(row["what"], f"{row['ms']:.3g}", f"{row['goal_ms']:g}", _mark(row["passed"]))
    make_console().print(made)


def _segmentation(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    made = make_table("", "#behaviors", "#s", "#at most", "reached", title="Segmenting a recording")
    what = f"{result['hours']:g} h, {result['ticks']} ticks"
    times = f"{result['s']:.3g}", f"{result['goal_s']:g}"
    made.add_row(what, str(result["behaviors"]), *times, _mark(result["passed"]))
    make_console().print(made)


def _interpreter(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    made = make_table("", "#µs", "goal", "reached", title="Deciding")
    ours, ratio = result["pulse_us"], result["ratio"]
    levels = " > ".join(result["path"])
    made.add_row(
        f"a pulse ({levels})",
        f"{ours:.2f}",
        f"at most {result['goal_us']:g}",
        _mark(ours <= result["goal_us"]),
    )
    made.add_row(
        f"a tick of py_trees, {result['py_trees_nodes']} nodes", f"{result['py_trees_us']:.2f}", "", ""
    )
    wanted = f"at least {result['goal_ratio']:g}"
    made.add_row("times faster", f"{ratio:.1f}", wanted, _mark(ratio >= result["goal_ratio"]))
    make_console().print(made)


def _robots(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    title = "From a reading to its command, ms"
    made = make_table("~", "#messages", "#median", "#99 of 100", "#longest", "#lost", title=title)
    for row in result["results"]:
        times = [f"{row[key]:.2f}" for key in ("p50_ms", "p99_ms", "max_ms")]
        made.add_row(row["what"], str(row["messages"]), *times, str(row["lost"]))
    make_console().print(made)
    goals = make_table("~goal", "#at most", "#measured", "reached")
    for row in result["goals"]:
        measured = "-" if row["passed"] is None else f"{row['value']:.2f}"
        goals.add_row(row["what"], f"{row['most']:g}", measured, _mark(row["passed"]))
    make_console().print(goals)
    for peer in result["missing"]:
        make_console().print(f"Not measured: {peer}.", markup=False)


def _start(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    made = make_table("~from a command to its end, s", "cache", "#median", "#range", title="Starting")
    for row in result["results"]:
        made.add_row(
            row["case"], row["cache"], f"{row['s']:.2f}", f"{row['least_s']:.2f}–{row['most_s']:.2f}"
        )
    make_console().print(made)
    goals = make_table("~goal", "#at most", "#measured", "reached")
    for goal in result["goals"]:
        goals.add_row(goal["what"], f"{goal['most']:g}", f"{goal['value']:.2f}", _mark(goal["passed"]))
    make_console().print(goals)
    for peer in result["missing"]:
        make_console().print(f"Not measured: {peer}.", markup=False)


def _mark(reached: bool | None) -> str:
    return "[dim]not measured[/]" if reached is None else "[green]yes[/]" if reached else "[red]no[/]"


def _speeds(result: dict[str, Any]) -> None:
    from understudy.ui.cli.output import make_console, make_table
    from understudy.viz.appearance import format_thousands

    title = "Running: robot-ticks per second"
    made = make_table("~task", "#robots", "#threads", "#speed", "#spread", "#of by hand", title=title)
    shares = {
        (row["task"], row["robots"], row["threads"]): row["of_by_hand"] for row in result.get("fractions", ())
    }
    for row in result["results"]:
        key = task, robots, threads = row["task"], row["robots"], row["threads"]
        spread = f"{row['spread']:.0%}" if "spread" in row else ""
        share = f"{shares[key]:.0%}" if key in shares else ""
        made.add_row(
            task, format_thousands(robots), str(threads), short(row["robot_ticks_per_s"]), spread, share
        )
    make_console().print(made)
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
    from understudy.viz.appearance import format_thousands

    rounded = float(f"{number:.3g}")
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(rounded) >= max(size, 10_000):
            return f"{rounded / size:g} {letter}"
    return format_thousands(int(rounded)) if abs(rounded) >= 1000 else f"{rounded:g}"


MEASUREMENTS: Mapping[str, Callable[[dict[str, Any]], None]] = MappingProxyType(
    {
        "learning": _learning,
        "looks": _looks,
        "segmentation": _segmentation,
        "interpreter": _interpreter,
        "start": _start,
        "robots": _robots,
        **dict.fromkeys(("swarm", "patrol", "environments", "squads", "crowding", "million"), _speeds),
    }
)
"""The measurements in order, each with the function that prints its result."""
