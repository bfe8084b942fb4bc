"""The command `understudy bench`: measure speed against other programs, on the same machine in the same run."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import typer

from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.options import Json

ABOUT: Mapping[str, str] = MappingProxyType(
    {
        "learning": "Compare the time to learn a tree with scikit-learn's DecisionTreeClassifier.fit.",
        "looks": "Compare the analyses of a lesson of 200 examples with a fit of scikit-learn.",
        "reading": "Measure the time to read an hour of a bag with 40 topics.",
        "segmentation": "Measure the time to find behaviors in an hour of driving.",
        "interpreter": "Compare one update of a three-level automaton with one of a py_trees tree of 11 nodes.",
        "swarm": "Compare swarms of 100 to 100 000 robots with Mesa 3, VMAS and hand-written code (takes minutes).",
        "patrol": "Measure the paper's patrol world, one world alone and a thousand in parallel.",
        "environments": "Measure scenarios as environments of Gymnasium and PettingZoo, beside VMAS and a "
        "PettingZoo environment.",
        "squads": "Measure two hundred and ten thousand robots in three levels of squads, compared with real time.",
        "crowding": "Compare robots that all drive to one point with the same task spread out (takes minutes).",
        "million": "Measure the speed and the memory of a million robots.",
        "start": "Measure how long a person waits after a command, with empty and full caches, beside peers "
        "(takes minutes).",
        "robots": "Measure the time from a sensor value to the command it causes in another process, over "
        "DDS and Zenoh.",
    }
)
"""The measurements, and what each is about."""
SPEEDS = ("swarm", "patrol", "environments", "squads", "crowding", "million")
"""The measurements of robot-ticks per second, which come last where all run."""

_measure = import_on_call("understudy_lab.commands.bench_tables:measure")
app = typer.Typer(help="Measure speed beside peers, in one run on this machine.", invoke_without_command=True)


@app.callback()
def everything(ctx: typer.Context, as_json: Json = False) -> None:
    """Measure speed against other programs, in one run on this machine; without a name, run all measurements."""
    if ctx.invoked_subcommand is None:
        _measure(*(name for name in ABOUT if name not in SPEEDS), *SPEEDS, as_json=as_json)


def _add_command(name: str) -> None:
    @app.command(name, help=ABOUT[name])
    def measure(as_json: Json = False) -> None:
        _measure(name, as_json=as_json)


for _name in ABOUT:
    _add_command(_name)
