"""`understudy bench`: our speed beside that of others, on the same machine in the same run."""

from __future__ import annotations

from typing import Any

import typer

from understudy.cli.parts import Json

app = typer.Typer(help="Measure speed beside peers, in one run on this machine.", invoke_without_command=True)

NOISE = "Medians; on a machine that does other things too, trust ratios to about 20 %."


@app.callback()
def everything(ctx: typer.Context, as_json: Json = False) -> None:
    """Measure speed beside peers, in one run on this machine; without a name, everything."""
    if ctx.invoked_subcommand is None:
        from understudy.bench import interpreter as decides
        from understudy.bench import learning as learns

        _tell({"learning": learns.run(), "interpreter": decides.run()}, as_json=as_json)


@app.command()
def learning(as_json: Json = False) -> None:
    """Learning a tree, beside scikit-learn's DecisionTreeClassifier.fit."""
    from understudy.bench.learning import run

    _tell({"learning": run()}, as_json=as_json)


@app.command()
def interpreter(as_json: Json = False) -> None:
    """A pulse of a three-level automaton, beside an 11-node py_trees tick."""
    from understudy.bench.interpreter import run

    _tell({"interpreter": run()}, as_json=as_json)


def _tell(results: dict[str, Any], *, as_json: bool) -> None:
    from understudy.cli.output import console, print_json

    passed = all(result["passed"] for result in results.values())
    if as_json:
        print_json(next(iter(results.values())) if len(results) == 1 else {**results, "passed": passed})
    else:
        for name, result in results.items():
            {"learning": _learning, "interpreter": _interpreter}[name](result)
        console().print(f"[dim]{NOISE}[/]")
    raise typer.Exit(0 if passed else 1)


def _learning(result: dict[str, Any]) -> None:
    from understudy.cli.output import console, table

    made = table(
        "#examples", "#ours ms", "#from a lesson ms", "#scikit-learn ms", "no slower", title="Learning"
    )
    for row in result["sizes"]:
        times = [f"{row[key]:.3g}" for key in ("ours_ms", "from_lesson_ms", "sklearn_ms")]
        made.add_row(str(row["examples"]), *times, _mark(row["as_fast"]))
    console().print(made)
    goals = table("5 % noise, ms", "#goal", "#ours", "#from a lesson", "reached")
    for row in result["goals"]:
        times = [f"{row[key]:.3g}" for key in ("goal_ms", "ours_ms", "from_lesson_ms")]
        goals.add_row(row["what"], *times, _mark(row["passed"]))
    console().print(goals)


def _interpreter(result: dict[str, Any]) -> None:
    from understudy.cli.output import console, table

    made = table("", "#µs", "goal", "reached", title="Deciding")
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
    console().print(made)


def _mark(reached: bool) -> str:
    return "[green]yes[/]" if reached else "[red]no[/]"
