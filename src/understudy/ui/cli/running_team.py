"""The running team of agents that a studio opens: whom it watches, and which of their robots it may train."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from understudy.robots.team_network.team_watch import TeamWatch
    from understudy.robots.twin import DigitalTwin


def has_agents(file: Path) -> bool:
    """Return whether a team's file has agents, each of which decides for itself."""
    from understudy.robots.robot_file import load_team
    from understudy.robots.team_settings import TeamSettings

    return load_team(file)[0].agents != TeamSettings()


@contextmanager
def watch_team(file: Path) -> Iterator[tuple[TeamWatch, DigitalTwin]]:
    """Join a running team as a visitor, and yield what is seen of it, and its robots as a body."""
    from understudy.errors import SettingError
    from understudy.robots.team_network.load_plan import load_team_plan
    from understudy.robots.team_network.remote_robot import make_remote_fleet
    from understudy.robots.team_network.team_watch import TeamWatch
    from understudy.robots.team_network.zenoh_network import ZenohNetwork
    from understudy.robots.twin import DigitalTwin
    from understudy.ui.cli.robot_options import interrupt_on_termination

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
