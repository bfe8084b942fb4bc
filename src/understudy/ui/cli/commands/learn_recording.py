"""`understudy learn --recording`: the lesson that presses make of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from understudy.model.lesson import Lesson
    from understudy.model.library import Library
    from understudy.robots.recording.reader import Pressed

FLAGS = ("done", "failed")
"""States that are flags where they were pressed and nobody said which are."""


class Asked(NamedTuple):
    """What was asked for; None where nothing was said."""

    name: str | None
    library: Path | None
    presses: Path | None
    states: str | None
    features: str | None
    flags: str | None
    parameters: str | None
    targets: str | None
    reaction_s: float | None
    agent: int
    session: int | None
    kit: str | None


def recorded_lesson(path: Path, asked: Asked) -> Lesson:
    """The lesson, with what an automaton of the library was taught before where it goes on with that."""
    from understudy.errors import SettingError
    from understudy.model.library import Library
    from understudy.robots.recording.reader import read_recording
    from understudy.robots.recording.teach_from_recording import read_presses, recorded_presses, taught_over
    from understudy.ui.cli.options import library_for, targets_in
    from understudy.ui.cli.recordings import kit_for, scenario_of

    recording = read_recording(path, run=asked.session)
    if not 0 <= asked.agent < len(recording.head.names):
        remedy = f"count from 0 to {len(recording.head.names) - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {asked.agent}", remedy=remedy)
    kit = kit_for(recording, asked.kit, scenario_of(recording))
    library = library_for(None, asked.library, kit) if asked.library is not None else Library(kit)
    presses = (
        recorded_presses(recording, asked.agent)
        if asked.presses is None
        else read_presses(asked.presses, recording)
    )
    lesson = _begun(library, asked, presses)
    targets = targets_in(asked.targets)
    return taught_over(recording, library, lesson, presses, targets=targets, agent=asked.agent).lesson


def _begun(library: Library, asked: Asked, presses: Sequence[Pressed]) -> Lesson:
    """The lesson that the presses are added to: that of an automaton of the library, or an empty one."""
    from dataclasses import replace

    from understudy.errors import SettingError
    from understudy.model.lesson import Options
    from understudy.robots.recording.teach_from_recording import names_pressed
    from understudy.training.lesson_design import new_lesson
    from understudy.ui.cli.options import names_in

    name = asked.name or "taught"
    former = library.taught[name].lesson if name in library.taught else None
    if former is not None:
        chosen = {"--states": asked.states, "--features": asked.features, "--flags": asked.flags}
        for option, value in {**chosen, "--parameters": asked.parameters}.items():
            if value is not None:
                problem = f"cannot be changed here: {name!r} is in the library with a lesson"
                raise SettingError(where="learn", setting=option, problem=problem, remedy="leave it out")
        reaction_s = former.options.reaction_s if asked.reaction_s is None else asked.reaction_s
        return replace(former, options=replace(former.options, reaction_s=reaction_s))
    features = names_in(asked.features)
    if not features:
        known = ", ".join(library.features)
        remedy = f"give --features A,B(C): what to decide on, of {known}"
        raise SettingError(where="learn", setting="--features", problem="is missing", remedy=remedy)
    pressed = [state for state in names_pressed(presses) if state != "start"]
    flags = names_in(asked.flags)
    if flags is None:
        flags = [state for state in pressed if state in FLAGS and state not in library.kit.behaviors]
    states = names_in(asked.states) or [state for state in pressed if state not in flags]
    return new_lesson(
        library,
        name,
        states=states,
        features=features,
        flags=flags,
        parameters=names_in(asked.parameters) or (),
        options=Options(reaction_s=asked.reaction_s or 0.0),
    )
