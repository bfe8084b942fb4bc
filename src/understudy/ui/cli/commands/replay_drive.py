"""An automaton run over the readings of a drive, for `understudy replay`: its states, and how it repeats the driver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.markup import escape

from understudy.addons.recordings.drive_kit import make_candidates
from understudy.addons.recordings.mapping_file import load_recording_map, name_mapping_file
from understudy.addons.recordings.rerun_drive import OTHER, Agreement, count_repeated, run_over_drive
from understudy.addons.recordings.segment import segment
from understudy.errors import SettingError
from understudy.model.automaton import Automaton, State
from understudy.model.library import Library
from understudy.storage.json_text import select_facts
from understudy.ui.cli.commands.learn_from_drive import read_drive, say_omissions
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import choose_behavior, find_kit, open_behavior_library
from understudy.ui.cli.options import LIBRARY, parse_bindings
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.run_options import ReplayOptions


@dataclass(frozen=True, slots=True)
class StateSpan:
    """Ticks in a row in one state: the file, and the times of its first tick and of its end, s."""

    file: str
    from_s: float
    to_s: float
    state: str


@dataclass(frozen=True, slots=True)
class DriveReplay:
    """What an automaton did over the readings of a drive, and how many ticks of the driver it repeats."""

    recording: Path
    behavior: str
    spans: list[StateSpan]
    agreement: Agreement
    omissions: list[str]


def replay_drive(options: ReplayOptions) -> None:
    """Run an automaton over the readings of a drive, and compare what it commands with what the driver meant."""
    mapping = None if options.mapping is None else load_recording_map(options.mapping)
    folder = options.library or LIBRARY
    with name_mapping_file(options.mapping):
        drive = read_drive(options.recording, mapping)
    with say_omissions(drive):
        library = open_behavior_library(
            None, folder, find_kit(options.kit, None if mapping is None else mapping.world)
        )
        name = choose_behavior(library, options.behavior, folder)
        automaton, targets = library.automaton(name), parse_bindings(options.bind)
        calls = {state.name: format_call(state, targets) for state in automaton.states}
        candidates = make_candidates(library, drive, _list_behaviors(library, automaton, options.recording))
        found = segment(drive, candidates)
        names = tuple(calls)
        states = run_over_drive(library, name, drive, names, targets=targets)
    labels = {each.name: index for index, each in enumerate(candidates)}
    meant = np.array([*(labels.get(call, OTHER) for call in calls.values()), OTHER])
    result = DriveReplay(
        options.recording,
        name,
        [
            StateSpan(
                episode.source,
                float(drive.times[first]),
                float(drive.times[end - 1] + drive.tick_s),
                names[states[first]] if states[first] != OTHER else "",
            )
            for episode in drive.episodes
            for first, end in episode.list_runs(states)
        ],
        count_repeated(found, meant[states]),
        list(drive.omissions),
    )
    if options.as_json:
        print_json(select_facts(result, "recording", "behavior", "spans", "agreement", "omissions"))
    else:
        _show(result)


def format_call(state: State, targets: Mapping[str, str]) -> str:
    """Format what a state runs as candidates are called: goto(ball)."""
    arguments = ", ".join(targets.get(each, each) for each in state.binding.values())
    return f"{state.behavior}({arguments})" if arguments else state.behavior or ""


def _list_behaviors(library: Library, automaton: Automaton, path: Path) -> list[str]:
    """List the behaviors that the states of an automaton run."""
    behaviors = [each.behavior for each in automaton.states if each.behavior is not None]
    commanding = [
        each
        for each in dict.fromkeys(behaviors)
        if each in library.taught or library.kit.behaviors[each].command
    ]
    if not commanding:
        problem = f"is {automaton.name!r}, whose states command nothing that a recording could show"
        remedy = "name an automaton that was learned from a drive, or give --kit"
        raise SettingError(where=str(path), setting="--behavior", problem=problem, remedy=remedy)
    return commanding


def _show(result: DriveReplay) -> None:
    out = make_console()
    for sentence in result.omissions:
        out.print(f"[yellow]{escape(sentence)}.[/]", soft_wrap=True)
    rows = make_table("#from, s", "#to, s", "state")
    for span in result.spans:
        rows.add_row(f"{span.from_s:.2f}", f"{span.to_s:.2f}", escape(span.state) or "[dim]none of them[/]")
    out.print(rows)
    out.print(f"{escape(result.behavior)} repeats {escape(str(result.agreement))}", soft_wrap=True)
