"""Command `understudy replay`: decide again over a recording, which is read before what decides is imported."""

from __future__ import annotations

from understudy.errors import SettingError
from understudy.records.reader import Recording, read_recording
from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.run_options import ReplayOptions

decide_again = import_on_call("understudy.ui.cli.commands.run_replay:decide_again")
replay_drive = import_on_call("understudy.ui.cli.commands.replay_drive:replay_drive")


def replay_recording(options: ReplayOptions) -> None:
    """Decide again over a recording, and show where decisions differ; exit with code 1 if any does.

    Over the recording of another program, run an automaton and count the ticks of the driver that it repeats.
    """
    is_own = options.recording.suffix.lower() == ".mcap" and options.mapping is None
    if options.recording.exists() and not is_own:
        replay_drive(options)
        return
    recording = read_recording(options.recording)
    _check_taught(recording, options)
    decide_again(recording, options)


def _check_taught(recording: Recording, options: ReplayOptions) -> None:
    """Refuse a recording of a teaching session unless the options name an automaton and its library."""
    if recording.head.ran.behavior is None and (options.behavior is None or options.library is None):
        missing = "--behavior" if options.behavior is None else "--library"
        problem = "is missing: nothing ran, a person taught"
        remedy = "name the automaton and its library"
        raise SettingError(where=str(options.recording), setting=missing, problem=problem, remedy=remedy)
