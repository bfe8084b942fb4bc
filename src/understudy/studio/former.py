"""Former versions of a trained behavior: which there are, what changed since, and going back to one."""

from __future__ import annotations

from understudy.learning.responsible import moved
from understudy.learning.transitions import learn
from understudy.model.changes import changes
from understudy.model.folder import load_version, save, versions
from understudy.model.library import Taught
from understudy.studio import openings, shelf
from understudy.studio.scene import Plain
from understudy.studio.stage import Stage


def listed(stage: Stage, name: str) -> Plain:
    """The former versions, the latest first, and when each was saved."""
    stage.shelf.of(name)
    found = reversed(versions(stage.shelf.folder, name))
    return {
        "versions": [
            {"number": each.number, "saved": each.saved.isoformat() if each.saved else None} for each in found
        ]
    }


def told(stage: Stage, name: str, number: int, *, to_next: bool) -> Plain:
    """What changed from a former version to the one after it, or to the present one, and which examples are behind it:
    lines by topic.
    """
    later = [each.number for each in versions(stage.shelf.folder, name) if each.number > number]
    before = _version(stage, name, number)
    after = _version(stage, name, later[0]) if to_next and later else stage.shelf.of(name)
    found = changes(before, after)
    because = [f"  {each}" for each in moved(before, after)]
    if because:
        found["because of"] = because
    return {"changes": [{"topic": topic, "lines": lines} for topic, lines in found.items()]}


def go_back(stage: Stage, name: str, number: int) -> None:
    """Make a former version the present one; the present one becomes a former version."""
    here = openings.settled(stage, name)
    stage.look()
    stage.shelf.of(name)
    taught = shelf.named(stage.shelf, _version(stage, name, number), name)  # it may have had another name
    save(stage.shelf.folder, taught)
    said = f"{name} is as it was in version {number}; what it was until now is kept as a version, too"
    openings.changed(stage, name, said, here=here)


def _version(stage: Stage, name: str, number: int) -> Taught:
    return load_version(stage.shelf.folder, name, number, stage.kit, learn).taught
