"""Command `understudy learn recording`: learn from a recording and presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.addons.recordings.teach_from_recording import (
    is_taught_live,
    list_pressed_states,
    list_recorded_presses,
    read_presses,
    teach_from_recording,
)
from understudy.errors import FileError, SettingError
from understudy.model.automaton import USUAL_FLAGS
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library
from understudy.records.reader import has_own_header, read_recording
from understudy.records.record import RecordedPress
from understudy.training.lesson_design import new_lesson
from understudy.ui.cli.commands.learn import learn_lesson
from understudy.ui.cli.lesson_options import LearnRecordingOptions
from understudy.ui.cli.named_inputs import open_behavior_library
from understudy.ui.cli.options import parse_names, parse_targets
from understudy.ui.cli.recorded_runs import choose_recording_kit, read_recorded_scenario

if TYPE_CHECKING:
    from understudy.model.lesson import Lesson


def learn_recording(options: LearnRecordingOptions) -> None:
    """Learn from a recording and presses, which have the same effect as in a session."""
    options.check_name()
    learn_lesson(learn_from_recording(options.recording, options), options)


def learn_from_recording(path: Path, asked: LearnRecordingOptions) -> Lesson:
    """Make a lesson from a recording of a robot and a table of presses, or of those in the recording.

    If the library has the automaton already, its lesson is extended.
    """
    if has_own_header(path) is False:
        problem = "it is no recording of `understudy`"
        remedy = (
            "use `understudy learn drive`, and give --map MAP.toml, which says what fields of its messages are "
            "readings and commands"
        )
        raise FileError(path=path, place="", problem=problem, remedy=remedy)
    recording = read_recording(path, run=asked.session)
    if not 0 <= asked.agent < len(recording.head.names):
        remedy = f"count from 0 to {len(recording.head.names) - 1}"
        raise SettingError(where=str(path), setting="--agent", problem=f"is {asked.agent}", remedy=remedy)
    kit = choose_recording_kit(recording, asked.kit, read_recorded_scenario(recording))
    library = open_behavior_library(None, asked.library, kit) if asked.library is not None else Library(kit)
    presses = (
        list_recorded_presses(recording, asked.agent)
        if asked.presses is None
        else read_presses(asked.presses, recording)
    )
    lesson = _begun(library, asked, presses)
    targets = parse_targets(asked.targets)
    return teach_from_recording(
        recording, library, lesson, presses, targets=targets, agent=asked.agent
    ).lesson


def _begun(library: Library, asked: LearnRecordingOptions, presses: Sequence[RecordedPress]) -> Lesson:
    """Return the lesson that the presses are added to: that of an automaton of the library, or an empty one."""
    name = asked.name or "taught"
    former = library.taught[name].lesson if name in library.taught else None
    if former is not None:
        chosen = {"--states": asked.states, "--features": asked.features, "--flags": asked.flags}
        for option, value in {**chosen, "--parameters": asked.parameters}.items():
            if value is not None:
                problem = f"cannot be changed here: {name!r} is in the library with a lesson"
                raise SettingError(where="learn", setting=option, problem=problem, remedy="leave it out")
        reaction_s = former.options.reaction_s if asked.reaction is None else asked.reaction
        return replace(former, options=replace(former.options, reaction_s=reaction_s))
    features = parse_names(asked.features)
    if not features:
        known = ", ".join(library.features)
        remedy = f"give --features A,B(C): what to decide on, of {known}"
        raise SettingError(where="learn", setting="--features", problem="is missing", remedy=remedy)
    pressed = [state for state in list_pressed_states(presses) if state != "start"]
    flags = parse_names(asked.flags)
    if flags is None:
        flags = [state for state in pressed if state in USUAL_FLAGS and state not in library.kit.behaviors]
    states = parse_names(asked.states) or [state for state in pressed if state not in flags]
    return new_lesson(
        library,
        name,
        states=states,
        features=features,
        flags=flags,
        parameters=parse_names(asked.parameters) or (),
        options=LearnerOptions(reaction_s=asked.reaction or 0.0),
        live=is_taught_live(presses),
    )
