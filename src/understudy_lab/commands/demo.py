"""`understudy demo`: robots are taught before your eyes, and then judged."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.options import Json

TASKS = ("forage", "patrol", "swarm")


def demo(
    task: Annotated[str, typer.Argument(help="What to teach: forage, patrol or swarm.")] = "forage",
    seed: Annotated[int, typer.Option("--seed", min=0, max=2**30, help="Which teaching.")] = 0,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            help="Where the library and the pictures go: demo, demo-patrol or demo-swarm.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Teach robots by showing them, and see how well they learned.

    A scripted teacher watches the robots and presses behaviors as a person would: late, and only now and then.

    forage: it teaches a robot GoTo, Harvest, Deposit and Forage in turn; then the robot forages alone in 100 worlds
    it has never seen, beside a forager written by hand.

    patrol: it teaches four robots to look for intruders, and their coordinator to send all of them; then they patrol
    in unseen worlds, with and without the coordinator (paper, section 5.1). A GIF shows it.

    swarm: it teaches 200 robots, and three levels of coordinators, to pull boxes together; then 10 000 run what they
    learned, against the clock. A GIF shows the 200.

    The same seed gives the same result.

    [dim]understudy demo --seed 7 --out my-demo[/]

    [dim]understudy demo patrol[/]

    [dim]understudy demo swarm[/]
    """
    from importlib import import_module
    from time import perf_counter

    from understudy.errors import UnknownName
    from understudy.ui.cli.output import make_console, print_json
    from understudy_lab.commands.demo_report import make_output_folders

    if task not in TASKS:
        raise UnknownName(what="task", name=task, where="the demo", known=TASKS)
    began = perf_counter()
    folder = out or Path("demo" if task == TASKS[0] else f"demo-{task}")
    make_output_folders(folder)
    talk = make_console(err=as_json)
    talk.quiet = as_json
    module = import_module(f"understudy_lab.commands.demo_{task}")
    result = getattr(module, f"demo_{task}")(seed, folder, talk)
    if as_json:
        print_json({**result, "seconds": round(perf_counter() - began, 2)})
