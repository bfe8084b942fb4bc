"""What was known when a run was made: automata that changed since, in the former versions that were run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from understudy.model.kit import Kit
    from understudy.model.library import Library, Taught
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries

ALONE = "robot"
"""What the sort of a robot without a scenario is called."""


def known_now(where: Scenario | None, behavior: str | None, folder: Path, kit: Kit) -> Libraries:
    """What everybody of a scenario knows now, or a robot without one."""
    from understudy.ui.cli.options import library_for, team_for

    if where is None:
        return {ALONE: library_for(behavior, folder, kit)}
    return team_for(where, behavior, folder, kit)


def known_then(
    where: Scenario | None,
    behavior: str | None,
    folder: Path,
    kit: Kit,
    automata: Mapping[str, Mapping[str, str]],
) -> tuple[Libraries, dict[str, int]]:
    """What everybody knew when the run was made, by the fingerprints of its automata, and the number of the former
    version of each automaton that is another by now; CannotRepeat where one is gone.
    """
    from understudy.sim.team.libraries import folders_of

    known = dict(known_now(where, behavior, folder, kit))
    places = {} if where is None else folders_of(where, folder, kit)
    former: dict[str, int] = {}
    for sort, marks in automata.items():
        place = folder if where is None else places[sort][0] if sort in places else folder / sort
        for name, mark in marks.items():
            library, version = _as_it_was(known[sort], place, name, mark)
            if version is not None:
                known = {each: library if it is known[sort] else it for each, it in known.items()}
                former[name] = version
    return known, former


def _as_it_was(library: Library, place: Path, name: str, mark: str) -> tuple[Library, int | None]:
    """The library with an automaton as its mark says, and which former version that is; None where it still is so."""
    from understudy.analysis.explain_run import CannotRepeat
    from understudy.errors import UnderstudyError
    from understudy.storage.fingerprint import fingerprint
    from understudy.storage.library_folder import load_version, versions
    from understudy.ui.cli.options import learner

    now = library.taught.get(name)
    if now is not None and fingerprint(now) == mark:
        return library, None
    for version in reversed(versions(place, name)):
        try:
            taught: Taught = load_version(place, name, version.number, library.kit, learner()).taught
        except UnderstudyError:
            continue  # of another kit, or damaged: it is none of what was run, as far as anybody can tell
        if fingerprint(taught) == mark:
            return library.with_taught(taught), version.number
    problem = f"{name} in {place} {'is another by now' if now else 'is gone'}, and no former version is what was run"
    raise CannotRepeat(problem=problem, remedy="run it again with --trace, and ask that")
