"""Part of `understudy learn`: behaviors and splits that a person adds to a drive, and what it leaves to answer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rich.markup import escape

from understudy.addons.recordings.propose_behaviors import make_constant_candidate
from understudy.addons.recordings.split_states import split_state
from understudy.errors import SettingError, UnknownName

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.addons.recordings.drive_findings import DriveFindings, DrivePlace
    from understudy.addons.recordings.recorded_drive import RecordedDrive
    from understudy.addons.recordings.segment import Segmentation
    from understudy.model.library import Library

MOST_QUESTIONS = 5
"""The number of questions that are printed."""


def parse_definition(text: str) -> tuple[str, dict[str, float]]:
    """Parse `NAME: CHANNEL VALUE, CHANNEL VALUE` of `--define`."""
    name, colon, rest = (part.strip() for part in text.partition(":"))
    command = {}
    for part in filter(None, (each.strip() for each in rest.split(","))):
        channel, _, value = part.rpartition(" ")
        try:
            command[channel.strip()] = float(value)
        except ValueError:
            colon = ""
    if not (name and colon and all(command)):
        raise SettingError(
            where="learn",
            setting=f"--define {text!r}",
            problem="is no behavior",
            remedy="write its name and its value on each channel: --define 'arc: drive 0.3, turn 0.6'",
        )
    return name, command


def define_behaviors(
    library: Library, drive: RecordedDrive, definitions: Sequence[str]
) -> tuple[Library, list[str]]:
    """Return the library with the behaviors of `--define`, and their names."""
    behaviors = dict(library.kit.behaviors)
    channels = [each.name for each in drive.channels]
    names = []
    for text in definitions:
        name, command = parse_definition(text)
        for channel in command:
            if channel not in channels:
                raise UnknownName(what="command channel", name=channel, where="the recording", known=channels)
        if name in behaviors or name in library.taught:
            problem, remedy = "there is a behavior of that name already", "choose another name"
            raise SettingError(where="learn", setting=f"--define {text!r}", problem=problem, remedy=remedy)
        behaviors[name] = make_constant_candidate(name, command).ground.behavior
        names.append(name)
    return replace(library, kit=replace(library.kit, behaviors=behaviors)), names


def apply_splits(found: Segmentation, splits: Iterable[str]) -> Segmentation:
    """Split the states of `--split 'STATE after STATE,STATE'`."""
    for text in splits:
        state, after, former = (part.strip() for part in text.partition(" after "))
        names = [each.strip() for each in former.split(",") if each.strip()]
        if not (state and after and names):
            raise SettingError(
                where="learn",
                setting=f"--split {text!r}",
                problem="names no state and the states before",
                remedy="write --split 'back after left', or 'back after left,start'",
            )
        found = split_state(found, state, names)
    return found


def print_drive_findings(out: Console, findings: DriveFindings) -> None:
    """Print latencies, proposals with the options that accept them, and the most useful questions."""
    for latency in findings.latencies:
        out.print(
            f"Motion follows {escape(latency.channel)} after {max(latency.seconds, 0.0):.2f} s "
            f"[dim](by {escape(latency.reading)}, correlation {abs(latency.correlation):.2f})[/]"
        )
    for proposal in findings.behaviors:
        out.print(
            f"[yellow]Nothing explains {proposal.seconds:.1f} s[/] in which the commands are "
            f"{escape(proposal.description)} (longest {format_place(proposal.longest)}). Give it a name: "
            f"[bold]--define 'NAME: {escape(format_definition(proposal.command))}'[/]",
            soft_wrap=True,
        )
    for split in findings.splits:
        option = f"--split '{split.state} after {','.join(split.entered_from)}'"
        out.print(
            f"[yellow]{escape(split.evidence[0].upper() + split.evidence[1:])}.[/] Split it in two: "
            f"[bold]{escape(option)}[/]",
            soft_wrap=True,
        )
    if findings.questions:
        count = len(findings.questions)
        more = f", the {MOST_QUESTIONS} most useful to answer first" if count > MOST_QUESTIONS else ""
        out.print(f"In doubt{more} [dim](answer in `understudy review`)[/]:")
        for question in findings.questions[:MOST_QUESTIONS]:
            choices = ", ".join(f"{label} {chance:.0%}" for label, chance in question.chances.items())
            out.print(f"  {format_place(question.place)}: {escape(choices)}", soft_wrap=True)


def format_definition(command: Mapping[str, float]) -> str:
    """Format a command as `--define` takes it."""
    return ", ".join(f"{channel} {value:g}" for channel, value in command.items())


def format_place(place: DrivePlace) -> str:
    """Format a span of a file."""
    return f"{escape(place.file)} from {place.from_s:.2f} to {place.to_s:.2f} s"
