"""The company: what the robots do that are not trained."""

from __future__ import annotations

from collections.abc import Mapping

from understudy.errors import SettingError, UnderstudyError, UnknownName
from understudy.model.binding import Binding, called
from understudy.ui.controller.status import Said
from understudy.ui.web.session_host import Stage


def occupy(stage: Stage, behavior: str | None, targets: Mapping[str, str]) -> None:
    """Let the others idle (None), or run a behavior of the library, its parameters standing for targets."""
    desk, library = stage.trained, stage.shelf.library
    if stage.world.robots < 2:
        problem, remedy = "cannot be told: there is one robot", "open a world with more"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy=remedy)
    wanted = () if behavior is None else library.parameters(behavior)
    if set(wanted) != set(targets):
        problem = f"need what {', '.join(wanted)} stands for" if wanted else "need no targets"
        raise SettingError(where="the studio", setting="others", problem=problem, remedy="say exactly that")
    known = list(stage.world.targets)
    for target in targets.values():
        if target not in known:
            raise UnknownName(what="target", name=target, where="the world", known=known)
    before = stage.others or {"behavior": None, "targets": {}}
    try:
        desk.session.others(behavior, targets, library=library)
    except UnderstudyError:
        desk.session.others(before["behavior"], before["targets"], library=library)
        raise
    doing = "idle" if behavior is None else f"run {called(behavior, Binding(targets))}"
    desk.said = Said(f"The others {doing} meanwhile")
    stage.moved += 1
