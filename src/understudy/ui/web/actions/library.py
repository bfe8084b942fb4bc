"""Keeping: what a person does to the library - saving what is trained, removing, bringing back, throwing away."""

from __future__ import annotations

from understudy.errors import SessionError, UnknownName
from understudy.storage.filenames import alike
from understudy.ui.controller import journal_store
from understudy.ui.controller.status import Said
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views import lesson_test, library
from understudy.ui.web.views.scene import Plain


def save_current_automaton(stage: Stage, name: str | None, *, anyway: bool = False) -> Plain:
    """Save what is trained; under another name, a copy of it. Where something that worked no longer does, that is
    answered instead, unless it is to be saved `anyway`.
    """
    desk = stage.trained
    if name is None or name == desk.name:
        stage.look()
        worse = () if anyway else lesson_test.worse(stage)
        if worse:
            desk.said = Said(f"{desk.name} is not saved yet: something that worked no longer does")
            return {"worse": list(worse)}
        desk.keep(desk.session.taught())
        desk.said = Said(f"{desk.name} is saved", "recorded")
    else:
        stage.look()
        stage.shelf.refuse_new(name, remedy="give another name")
        library.save_copy(stage.shelf, desk.session.taught(), name)
        desk.said = Said(f"A copy of {desk.name} is saved as {name}", "recorded")
    stage.look()
    return {}


def remove(stage: Stage, name: str) -> None:
    """Move a trained behavior to the trash."""
    desk = stage.desk
    if desk is not None and alike(name) == alike(desk.name):
        raise SessionError(f"{name} is being trained: open another before it is removed")
    if desk is not None and any(state.behavior == name for state in desk.session.automaton.states):
        raise SessionError(f"{desk.name}, which is being trained, runs {name}: choose its states first")
    stage.look()
    library.remove(stage.shelf, name)
    stage.look()
    stage.said = Said(f"{name} is in the trash, from where it can be restored")


def restore(stage: Stage, name: str) -> None:
    """Bring a trained behavior back from the trash."""
    stage.look()
    library.restore(stage.shelf, name)
    stage.look()
    stage.said = Said(f"{name} is back in the library")


def discard(stage: Stage, name: str) -> None:
    """Throw away a lesson that was cut off; its journal stays among those that ended."""
    stage.look_for_cut_off()
    if name not in stage.cut_off:
        where, known = "the lessons that were cut off", list(stage.cut_off)
        raise UnknownName(what="automaton", name=name, where=where, known=known)
    stage.discarded[name] = journal_store.end(stage.cut_off[name].path, stage.shelf.folder, name)
    stage.look_for_cut_off()
    stage.said = Said(f"The lesson of {name} that was cut off is thrown away")


def recall(stage: Stage, name: str) -> None:
    """Offer a lesson again that was thrown away since the studio was started."""
    if name not in stage.discarded:
        where, known = "the lessons that were thrown away", list(stage.discarded)
        raise UnknownName(what="automaton", name=name, where=where, known=known)
    journal_store.reopen(stage.discarded[name])
    del stage.discarded[name]
    stage.look_for_cut_off()
    stage.said = Said(f"The lesson of {name} that was cut off can go on again")
