"""`understudy experiment`: the published experiments, run again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.cli.parts import Json

if TYPE_CHECKING:
    from rich.console import Console

app = typer.Typer(help="Run a published experiment again; `list` names them.", no_args_is_help=True)

QUICK = 2


@app.command("list")
def list_(as_json: Json = False) -> None:
    """The experiments there are."""
    from understudy.cli.output import console, print_json, table

    experiments = [{"name": "forage", "question": "Can a robot be taught to forage, and how well does it?"}]
    if as_json:
        print_json(experiments)
        return
    made = table("experiment", "question")
    for each in experiments:
        made.add_row(each["name"], each["question"])
    console().print(made)


@app.command()
def forage(
    seeds: Annotated[
        str | None,
        typer.Option("--seeds", metavar="A:B", help="The teachings; the published ones unless given."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help=f"Only the first {QUICK} teachings.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE.json", help="Keep the result in a file, too.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Teach twenty robots to forage, each judged on 100 unseen worlds, with both methods.

    Exit code 1 if the result falls short of what it must reach.

    [dim]understudy experiment forage --seeds 41000:41020[/]
    """
    import msgspec

    from understudy.cli.evaluate import parse_seeds
    from understudy.cli.output import console, print_json
    from understudy.cli.parts import find_world
    from understudy.cli.progress import compile_once, progress
    from understudy.experiments.forage.run import TEACHINGS, run
    from understudy.model.atomic import write

    chosen = TEACHINGS if seeds is None else parse_seeds(seeds)
    compile_once(learner=True, world=find_world("forage"), quiet=as_json)
    with progress("Robots taught", quiet=as_json) as report:
        result = run(chosen[:QUICK] if quick else chosen, progress=report)
    if out is not None:
        write(out, msgspec.json.format(msgspec.json.encode(result), indent=2) + b"\n")
    if as_json:
        print_json(result)
    else:
        _tell(result, console())
    raise typer.Exit(0 if result["passed"] else 1)


def _tell(result: dict[str, Any], out: Console) -> None:
    from understudy.cli.output import table

    first, last = result["seeds"]
    methods = result["methods"]
    made = table("", *(f"#{method}" for method in methods))
    for what, told in (
        ("teachings that reach 95 %", lambda found: f"{found['teachings_reaching_95']} of {found['of']}"),
        ("success, worst teaching", lambda found: f"{found['success']['min']:.0%}"),
        ("food per second / yardstick's", lambda found: _spread(found["relative_to_expert"], 3)),
        ("press-made examples", lambda found: _spread(found["examples"], 0)),
        ("presses", lambda found: _spread(found["presses"], 0)),
        ("teaching time, s", lambda found: _spread(found["teaching_seconds"], 0)),
    ):
        made.add_row(what, *map(told, methods.values()))
    out.print(f"[bold]Foraging[/]: teachings {first}:{last}, each judged on its own 100 unseen worlds")
    out.print("[dim]medians over teachings, with the smallest and the largest[/]")
    out.print(made)
    corners = table("corner case", *(f"#{method}" for method in methods))
    for name in methods["watched"]["corner_cases"]:
        corners.add_row(name, *(f"{found['corner_cases'][name]['min']:.0%}" for found in methods.values()))
    out.print("Success in the paper's corner cases, worst teaching")
    out.print(corners)
    out.print(f"The hand-coded yardstick takes {_spread(result['yardstick'], 3)} of its lower bound's time.")
    for miss in result["misses"]:
        out.print(f"[red]Short:[/] {miss}")


def _spread(values: dict[str, float], digits: int) -> str:
    return f"{values['median']:.{digits}f} ({values['min']:.{digits}f}–{values['max']:.{digits}f})"
