"""Handle messages about where one teaches: other worlds and libraries, and worlds that are saved."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Kit
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario_snapshot import make_scenario_snapshot
from understudy.sim.world import World
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.actions.session import open_automaton, refuse_unsaved
from understudy.ui.web.messages import session as m
from understudy.ui.web.session_host import CARRY, SessionHost
from understudy.ui.web.views.library import check_folder


def handle_open_world(host: SessionHost, message: m.OpenWorld) -> StatusMessage:
    """Go to a world of another scenario; what is trained goes along where it can."""
    refuse_fixed(host)
    refuse_unsaved(host, discard=message.discard)
    scenario, kit = host.places.open_world(message.name)
    return _enter(host, scenario, host.folder, kit, f"World {scenario.name}")


def handle_open_library(host: SessionHost, message: m.OpenLibrary) -> StatusMessage:
    """Use another library; an automaton of the same name is opened from it."""
    refuse_fixed(host)
    refuse_unsaved(host, discard=message.discard)
    folder = host.places.open_library(message.name, host.folder)
    check_folder(folder)
    return _enter(host, host.scenario, folder, host.first_kit, f"Library {message.name}")


def _enter(host: SessionHost, scenario: Scenario, folder: Path, kit: Kit, sentence: str) -> StatusMessage:
    """Enter a world with a library, and open there what was trained; refused, nothing has changed."""
    trained = None if host.trainer is None else host.trainer.name
    world = World(scenario, [host.seed])  # what cannot be entered is told before anything is left
    host.enter(world, folder, kit)
    if trained is not None and trained in host.library_view.library.taught:
        with suppress(UnderstudyError):  # it may need what this world does not have
            open_automaton(host, trained, discard=True)
            return StatusMessage(f"{sentence}: {trained} is opened here")
    return StatusMessage(f"{sentence}: teach something new, or open an automaton of the library")


def handle_save_world(host: SessionHost, message: m.SaveWorld) -> StatusMessage:
    """Save the world as it stands as a scenario, which is offered from then on."""
    refuse_fixed(host)
    about = f"Saved in the studio: {host.scenario.name}, world {host.seed}, as it stood then."
    snapshot = make_scenario_snapshot(host.scenario, host.world.view(), name=message.name, about=about)
    path = host.places.save_world(snapshot)
    host.scene_version += 1
    return StatusMessage(
        f"The world is saved as {snapshot.name}, in {path.parent.name}/{path.name}", "recorded"
    )


def refuse_fixed(host: SessionHost) -> None:
    """Raise SessionError if the world is that of real robots or a body of the user's own."""
    if isinstance(host.world, BodyWorld):
        raise SessionError(
            f"{host.world.name} is a body of your own: start the studio again for another world"
        )
    if not isinstance(host.world, World):
        raise SessionError(f"real robots are where they are, with the library that was chosen: {CARRY}")
