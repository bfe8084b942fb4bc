"""Options of `understudy demo` and `understudy experiment`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from understudy.ui.cli.options import CommandOptions


class DemoOptions(CommandOptions):
    """Teach simulated robots by demonstration, and test how well they learned.

    A scripted teacher watches the robots and presses buttons as a person would: late, and only now and then.

    forage: it teaches a robot GoTo, Harvest, Deposit and Forage in turn; then the robot forages alone in 100 worlds
    it has never seen, compared with a hand-written controller.

    patrol: it teaches four robots to look for intruders, and their coordinator to command all of them; then they patrol
    in unseen worlds, with and without the coordinator (paper, section 5.1). A GIF shows it.

    swarm: it teaches 200 robots, and three levels of coordinators, to pull boxes together; then 10 000 robots run the
    same automata, and their speed is measured. A GIF shows the 200.

    The same seed gives the same result.

    [dim]understudy demo --seed 7 --out my-demo[/]

    [dim]understudy demo patrol[/]

    [dim]understudy demo swarm[/]
    """

    task: Annotated[str, typer.Argument(help="What to teach: forage, patrol or swarm.")] = "forage"
    seed: Annotated[int, typer.Option("--seed", min=0, max=2**30, help="Which teaching.")] = 0
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            help="Where the library and the pictures go: demo, demo-patrol or demo-swarm.",
            show_default=False,
        ),
    ] = None
    method: Annotated[
        str,
        typer.Option(
            "--method",
            help="How to teach foraging: live (the robot acts from the first press on), watched (demonstrations, then "
            "corrections; also learns from what was watched without a press), or paper (without that).",
        ),
    ] = "live"


class ExperimentOptions(CommandOptions):
    """Run published experiments again: teach robots, test them, and compare with the published results.

    Tasks whose results are already in the folder are not repeated, so an interrupted run can be continued. Exit code 1
    if a result differs from the published one, or a goal that was reached before is missed.

    [dim]understudy experiment forage --quick[/]

    [dim]understudy experiment forage --part 2/8[/] on each of 8 computers, then [dim]understudy experiment forage
    --gather[/]
    """

    name: Annotated[str, typer.Argument(metavar="list|all|NAME", help="Which one; list names them.")]
    seeds: Annotated[
        str | None,
        typer.Option("--seeds", metavar="A:B", help="The teachings; the published ones unless given."),
    ] = None
    quick: Annotated[
        bool, typer.Option("--quick", help="A small part, compared with what was published.")
    ] = False
    data: Annotated[
        Path | None,
        typer.Option("--data", metavar="DIR", help="Data from elsewhere, for one that takes any."),
    ] = None
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Where results are kept: results/NAME unless given."),
    ] = None
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="So many processes; one per processor unless given."),
    ] = None
    part: Annotated[
        str | None,
        typer.Option(
            "--part",
            metavar="I/N",
            help="Run only the I-th of N parts, such as 2/8. --gather joins them.",
            show_default=False,
        ),
    ] = None
    gathers: Annotated[
        bool, typer.Option("--gather", help="Join the rows of all parts, which must have ended.")
    ] = False
    cluster: Annotated[
        str | None,
        typer.Option(
            "--cluster",
            metavar="slurm|local",
            help="Run --jobs parts as jobs of a cluster, and join them.",
            show_default=False,
        ),
    ] = None
    cluster_option: Annotated[
        list[str] | None,
        typer.Option(
            "--cluster-option",
            metavar="KEY=VALUE",
            help="A parameter of submitit, such as timeout_min=240 or slurm_partition=cpu.",
            show_default=False,
        ),
    ] = None
