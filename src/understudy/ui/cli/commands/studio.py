"""Command `understudy studio`: train a robot in the browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import (
    FAILURES,
    LIBRARY,
    FailuresOption,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
    ScenarioName,
)
from understudy.ui.cli.robot_options import NoRecording, RobotFileOption, TeamFileOption, connect_twin
from understudy.ui.cli.robot_options import find_robots_file as real

if TYPE_CHECKING:
    from understudy.robots.twin import Ground


def start_studio(
    scenario: ScenarioName = None,
    world: SameWorld = None,
    library: LibraryOption = LIBRARY,
    kit: KitName = None,
    host: Annotated[
        str,
        typer.Option("--host", help="Address to listen on; any but this machine's own needs a token."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port, or the next free one.")] = 8437,
    token: Annotated[
        str | None, typer.Option("--token", help="Token that pages need to connect; random if left out.")
    ] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the world.")] = 0,
    failures: FailuresOption = FAILURES,
    robot: RobotFileOption = None,
    team: TeamFileOption = None,
    no_record: NoRecording = False,
    as_json: Json = False,
) -> None:
    """Train a robot in the browser: the page shows the world, and you press what the robot should do.

    It works without internet. Every example is saved before it is acknowledged; after an interruption, start the
    studio again and continue.

    [dim]understudy studio forage[/]

    [dim]understudy studio --world cart_pole:make[/]

    [dim]understudy studio --robot rover.toml[/]

    If the file of a team has agents, the studio opens the running team: it shows what each agent does, and trains
    robots and coordinators over the network.

    [dim]understudy studio --team team.toml --library library[/]
    """
    from contextlib import ExitStack, closing

    from understudy.sim.body_world import BodyWorld
    from understudy.sim.kit import make_scenario_kit
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli.options import choose_scenario_name, find_kit, make_world_kit, open_world
    from understudy.ui.cli.output import print_json
    from understudy.ui.cli.running_team import has_agents, watch_team
    from understudy.ui.web.access import listen
    from understudy.ui.web.app import serve
    from understudy.ui.web.server import StudioServer
    from understudy.ui.web.session_host import SessionHost
    from understudy.ui.web.views.library import check_folder

    with ExitStack() as leaving:
        watch = None
        if real(robot, team, world=scenario or world) is None:
            name = choose_scenario_name(scenario, world)
            opened = open_world(name)
            parts = make_world_kit(opened) if kit is None else find_kit(kit, name)
            ground: Ground | None = None
            if isinstance(opened, Scenario):
                found = opened
            else:
                ground = leaving.enter_context(closing(BodyWorld(opened, seed, name=name)))
                found = ground.scenario
        elif team is not None and has_agents(team):
            watch, twin = leaving.enter_context(watch_team(team))
            ground, found = twin, twin.scenario
            parts = make_scenario_kit(found) if kit is None else find_kit(kit, found.name)
        else:
            twin = leaving.enter_context(connect_twin(robot, team, record=None, recorded=not no_record))
            ground, found = twin, twin.scenario
            parts = make_scenario_kit(found) if kit is None else find_kit(kit, found.name)
        check_folder(library)
        address = listen(host, port, token)
        session_host = SessionHost(found, library, parts, seed=seed, ground=ground, failures=failures)
        if as_json:
            print_json({"world": found.name, "library": library, "link": address.link})
        else:
            typer.echo(f"The studio is at {address.link}  (Ctrl C ends it)")

        def ready() -> None:
            if not no_browser:
                _open(address.link)

        serve(StudioServer(session_host, watch=watch), address, ready=ready)


def _open(link: str) -> None:
    """Open the page in the browser, in a thread; the socket already listens, so the page waits to be served."""
    import webbrowser
    from contextlib import suppress
    from threading import Thread

    def look() -> None:
        with suppress(webbrowser.Error, OSError):
            webbrowser.open(link)

    Thread(target=look, daemon=True).start()
