"""Commands `understudy studio` and `understudy robots studio`: train a robot in the browser."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

import typer

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.addons.robots.robot_file import load_team
from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.addons.robots.team_network.remote_robot import make_remote_fleet
from understudy.addons.robots.team_network.team_watch import TeamWatch
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork
from understudy.addons.robots.team_settings import TeamSettings
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import SettingError
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import choose_kit
from understudy.ui.cli.options import FAILURES
from understudy.ui.cli.robot_connection import connect_twin, interrupt_on_termination, split_robots_file
from understudy.ui.web.access import ListenAddress, listen
from understudy.ui.web.app import serve
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.library import check_folder

if TYPE_CHECKING:
    from understudy.addons.robots.twin import Ground
    from understudy.model.library import Kit
    from understudy.ui.cli.studio_options import PageOptions, RobotsStudioOptions, StudioOptions


def listen_for_page(options: PageOptions) -> ListenAddress:
    """Listen, and return the address."""
    return listen(options.host, options.port, options.token)


def announce_page(
    options: PageOptions, what: str, facts: Mapping[str, object], address: ListenAddress
) -> Callable[[], None]:
    """Print where the page is, and return what opens it in the browser once it is served.

    `what` is in singular or plural, as in `The studio is`.
    """
    if options.as_json:
        print_json({**facts, "link": address.link})
    else:
        typer.echo(f"{what} at {address.link}  (Ctrl C ends it)")

    def look() -> None:
        with suppress(webbrowser.Error, OSError):
            webbrowser.open(address.link)

    def show() -> None:
        if not options.no_browser:  # in a thread: the socket already listens, so the page waits to be served
            Thread(target=look, daemon=True).start()

    return show


def has_agents(file: Path) -> bool:
    """Return whether a team's file has agents, each of which decides for itself."""
    return load_team(file)[0].agents != TeamSettings()


@contextmanager
def watch_team(file: Path) -> Iterator[tuple[TeamWatch, DigitalTwin]]:
    """Join a running team as a visitor, and yield what is seen of it, and its robots as a body."""
    team = load_team_plan(file)
    trainer = team.settings.trainer
    network = ZenohNetwork(team.name, team.make_network_options())
    try:
        if trainer is not None:
            if network.is_present(trainer):
                raise SettingError(
                    where=f"team {team.name}", setting=trainer, problem="is training already",
                    remedy="end the other studio first",
                )  # fmt: skip
            network.announce(trainer)
        watch = TeamWatch(team, network)
    except BaseException:
        network.close()
        raise
    with interrupt_on_termination():
        try:
            twin = DigitalTwin(make_remote_fleet(watch))
            try:
                yield watch, twin
            finally:
                twin.close()
        finally:
            watch.close()


def start_studio(options: StudioOptions) -> None:
    """Train a robot in the browser: the page shows the world, and you press what the robot should do."""
    name, seed, failures = options.world_name, options.seed, options.failures
    opened = find_world(name)
    kit = choose_kit(options.kit, opened)
    if isinstance(opened, Scenario):
        _serve_studio(options, opened, kit, seed=seed, failures=failures)
        return
    with closing(BodyWorld(opened, seed, name=name)) as ground:
        _serve_studio(options, ground.scenario, kit, seed=seed, ground=ground, failures=failures)


def start_robots_studio(options: RobotsStudioOptions) -> None:
    """Train real robots in the browser."""
    serve_robots_studio(options, *split_robots_file(options.file), is_recorded=not options.no_record)


def serve_robots_studio(
    options: PageOptions,
    robot: Path | None,
    team: Path | None,
    *,
    is_recorded: bool,
    seed: int = 0,
    failures: Path = FAILURES,
) -> None:
    """Connect to a robot or a team, or join a team that runs, and serve its studio."""
    with ExitStack() as leaving:
        watch = None
        if team is not None and has_agents(team):
            watch, twin = leaving.enter_context(watch_team(team))
        else:
            twin = leaving.enter_context(connect_twin(robot, team, record=None, recorded=is_recorded))
        kit = choose_kit(options.kit, twin.scenario)
        _serve_studio(options, twin.scenario, kit, seed=seed, ground=twin, failures=failures, watch=watch)


def _serve_studio(
    options: PageOptions,
    scenario: Scenario,
    kit: Kit,
    *,
    seed: int,
    failures: Path,
    ground: Ground | None = None,
    watch: TeamWatch | None = None,
) -> None:
    check_folder(options.library)
    address = listen_for_page(options)
    session_host = SessionHost(scenario, options.library, kit, seed=seed, ground=ground, failures=failures)
    facts = {"world": scenario.name, "library": options.library}
    show = announce_page(options, "The studio is", facts, address)
    serve(StudioServer(session_host, watch=watch), address, ready=show)
