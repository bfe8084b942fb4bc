"""Former versions of a trained behavior: which there are, what changed since, and going back to one."""

from __future__ import annotations

from understudy.learning.change_attribution import Moved, moved
from understudy.learning.fit import learn
from understudy.model.diff import changes
from understudy.model.library import Taught
from understudy.storage.library_folder import load_version, save, versions
from understudy.ui.controller import formatting
from understudy.ui.web.actions import session
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views import library
from understudy.ui.web.views.scene import Plain


def listed(stage: Stage, name: str) -> Plain:
    """The former versions, the latest first, and when each was saved."""
    stage.shelf.of(name)
    found = reversed(versions(stage.shelf.folder, name))
    return {
        "versions": [
            {"number": each.number, "saved": each.saved.isoformat() if each.saved else None} for each in found
        ]
    }


def told(stage: Stage, name: str, number: int, to: int | None) -> Plain:
    """What changed from a former version to another, or to the present one: lines by topic, and how switches moved,
    with the examples responsible.
    """
    before = _version(stage, name, number)
    after = stage.shelf.of(name) if to is None else _version(stage, name, to)
    found, switches = changes(before, after), moved(before, after)
    if switches:
        found.pop("conditions", None)  # they say which, and why
    return {
        "changes": [{"topic": topic, "lines": lines} for topic, lines in found.items()],
        "moved": [_moved(each) for each in switches],
    }


def _moved(each: Moved) -> Plain:
    return {
        "from": each.state,
        "to": each.next,
        "what": each.what,
        "gone": [formatting.signed(line) for line in each.gone],
        "new": [formatting.signed(line) for line in each.new],
        "examples": [
            {"number": who.number, "happened": who.happened, "how": who.how} for who in each.examples
        ],
    }


def go_back(stage: Stage, name: str, number: int) -> None:
    """Make a former version the present one; the present one becomes a former version."""
    here = session.settled(stage, name)
    stage.look()
    stage.shelf.of(name)
    taught = library.named(stage.shelf, _version(stage, name, number), name)  # it may have had another name
    save(stage.shelf.folder, taught)
    said = f"{name} is as it was in version {number}; what it was until now is kept as a version, too"
    session.changed(stage, name, said, here=here)


def _version(stage: Stage, name: str, number: int) -> Taught:
    return load_version(stage.shelf.folder, name, number, stage.kit, learn).taught
