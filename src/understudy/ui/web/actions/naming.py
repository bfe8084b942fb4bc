"""Naming: a trained behavior of the library under another name, or twice."""

from __future__ import annotations

from understudy.errors import SessionError
from understudy.storage import library_folder
from understudy.ui.controller.status import Said
from understudy.ui.web.actions import session
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views import library


def rename(stage: Stage, name: str, to: str) -> None:
    """Give a trained behavior another name, with its former versions; not where others run it by the former one."""
    here = session.settled(stage, name)
    desk = stage.desk
    stage.look()
    taught = stage.shelf.of(name)
    users = [*stage.shelf.library.users(name)]
    if desk is not None and any(state.behavior == name for state in desk.session.automaton.states):
        users.append(desk.name)
    if users:
        runs = ", ".join(dict.fromkeys(users))
        raise SessionError(
            f"{name} is run by {runs}: duplicate it instead, or choose the states of {runs} first"
        )
    stage.shelf.refuse_new(to, remedy="give another name")
    library_folder.rename(stage.shelf.folder, name, library.named(stage.shelf, taught, to))
    session.changed(stage, to, f"{name} is called {to} now", here=here)


def duplicate(stage: Stage, name: str, to: str) -> None:
    """Copy a trained behavior as the library has it."""
    stage.look()
    taught = stage.shelf.of(name)
    stage.shelf.refuse_new(to, remedy="give another name")
    library.save_copy(stage.shelf, taught, to)
    stage.look()
    stage.said = Said(f"{to} is a copy of {name}", "recorded")
