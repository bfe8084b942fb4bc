"""Command `understudy learn drive`: learn from recordings without presses, and print how they were segmented."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rich.markup import escape

from understudy.addons.bridges.datasets.lerobot_reader import is_lerobot
from understudy.addons.bridges.datasets.minari_reader import is_minari
from understudy.addons.recordings.drive_kit import make_candidates, make_drive_kit
from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.lesson_from_drive import DriveLesson, to_lesson
from understudy.addons.recordings.mapping_file import RecordingMap, load_recording_map, name_mapping_file
from understudy.addons.recordings.pair_report import PairReport, take_pairs
from understudy.addons.recordings.propose_behaviors import discover_behaviors, make_constant_candidate
from understudy.addons.recordings.run_drives import choose_agent
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.addons.recordings.segmentation_report import DriveReport, make_drive_report
from understudy.addons.recordings.split_states import split_state
from understudy.errors import SettingError, UnderstudyError, UnknownName
from understudy.judging.record_files import is_journal
from understudy.model.library import Kit, Library, make_lesson_kit
from understudy.records.join_records import join_records
from understudy.records.reader import has_own_header, read_recording
from understudy.records.record import Record
from understudy.records.table_files import is_tick_table
from understudy.records.trace_reader import is_trace, read_trace_records
from understudy.training.lesson_design import parse_feature
from understudy.ui.cli.commands.learn import learn_lesson
from understudy.ui.cli.lesson_options import DriveOptions, LearnDriveOptions
from understudy.ui.cli.named_inputs import find_kit, open_behavior_library
from understudy.ui.cli.options import WORLD, parse_names, parse_targets
from understudy.ui.cli.output import format_count, make_console, make_table
from understudy.ui.cli.progress_bar import show_progress
from understudy.ui.cli.recorded_runs import choose_recording_kit, read_recorded_scenario, read_run

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.addons.recordings.drive_findings import DriveFindings, DrivePlace
    from understudy.model.features import BoundFeature

WELL_REPEATED = 0.95
"""The share of ticks from which on what was learned counts as a good copy of the driver."""
TIME_IN_STATE = "time_in_state"
MOST_QUESTIONS = 5
"""The number of questions that are printed."""


class OpenedDrives(NamedTuple):
    """Drives of one driver joined to one, and the library whose behaviors may explain it.

    `is_defined` is True if a program defines the kit, and False if it is of the recording alone.
    """

    drive: Record
    library: Library
    is_defined: bool


class SegmentedDrive(NamedTuple):
    """A segmented drive, the library whose behaviors explain it, and the features that decisions depend on, if named.

    `is_defined` is True if a program defines the kit, and False if it is of the recording alone.
    """

    found: Segmentation
    library: Library
    features: list[BoundFeature] | None
    is_defined: bool


def learn_drive(options: LearnDriveOptions) -> None:
    """Learn from recordings of a person who drove: the commands say which behavior was meant at each tick."""
    options.check_name()
    opened = open_drives(options.recordings, options)
    with say_omissions(opened.drive):
        drive = segment_opened_drives(options.recordings[0], opened, options)
        made, pairs = make_drive_lesson(drive, options, driver=options.driver), None
        if options.pairs:
            made, pairs = _take_pairs(drive, made, options)
        report = make_drive_report(drive.found, made, targets=parse_targets(options.targets))
    facts = {"drive": report, **({} if pairs is None else {"pairs": pairs})}
    learn_lesson(made.lesson, options, facts, partial(_print_facts, report, pairs))


def _take_pairs(
    drive: SegmentedDrive, made: DriveLesson, options: LearnDriveOptions
) -> tuple[DriveLesson, PairReport]:
    """Take pairs of the readings that decisions depend on into the lesson, where they are worth it."""
    # A driver's reaction time is not another one because decisions depend on other features.
    asked = replace(options, reaction=made.lesson.options.reaction_s)

    def make(features: Sequence[BoundFeature]) -> DriveLesson:
        again = make_drive_lesson(drive._replace(features=list(features)), asked, driver=options.driver)
        return replace(again, reaction=made.reaction)

    targets = parse_targets(options.targets)
    with show_progress("Pairs of readings tried", quiet=options.as_json) as report:
        return take_pairs(
            drive.found, made, made.lesson.automaton.features, make, targets=targets, report=report
        )


def _print_facts(report: DriveReport, pairs: PairReport | None) -> None:
    """Print the report of a drive, and the pairs of readings that were tried and taken."""
    print_drive_report(report)
    if pairs is not None and pairs.fitting:
        out = make_console()
        for sentence in pairs.list_sentences():
            out.print(escape(sentence), soft_wrap=True)
        if pairs.taken:
            out.print("[dim]Without them: --no-pairs[/]")


@contextmanager
def say_omissions(drive: Record) -> Iterator[None]:
    """Say what was left out of a drive before an error, which may be its reason."""
    try:
        yield
    except UnderstudyError:
        for sentence in drive.omissions:
            make_console(err=True).print(f"[yellow]{escape(sentence)}.[/]", soft_wrap=True)
        raise


def make_drive_lesson(drive: SegmentedDrive, asked: DriveOptions, *, driver: str) -> DriveLesson:
    """Make the lesson of one driver."""
    made = to_lesson(
        drive.found,
        name=asked.name or "driven",
        driver=driver,
        library=drive.library,
        features=drive.features,
        targets=parse_targets(asked.targets),
        reaction_s=asked.reaction,
    )
    if drive.is_defined:
        return made
    return replace(
        made, lesson=replace(made.lesson, kit=make_lesson_kit(made.lesson.automaton, made.library))
    )


def open_drives(paths: Sequence[Path], asked: DriveOptions) -> OpenedDrives:
    """Read the drives of one driver, and find the library whose behaviors may explain them."""
    mapping = None if asked.mapping is None else load_recording_map(asked.mapping)
    with name_mapping_file(asked.mapping):
        opened = [_open(path, asked, mapping) for path in paths]
    if len(opened) == 1:
        return opened[0]
    joined, library = join_records([each.drive for each in opened]), opened[0].library
    if not opened[0].is_defined:  # what the recordings alone define has the labels of all
        library = replace(library, kit=make_drive_kit(joined, {} if mapping is None else mapping.behaviors))
    return OpenedDrives(joined, library, opened[0].is_defined)


def segment_opened_drives(path: Path, opened: OpenedDrives, asked: DriveOptions) -> SegmentedDrive:
    """Find what may explain drives, and segment them; `path` is the first file, for errors."""
    drive, library, is_defined = opened
    library, defined = define_behaviors(library, drive, asked.define or ())
    named = parse_names(asked.behaviors)
    candidates = make_candidates(library, drive, None if named is None else [*named, *defined])
    if not candidates:
        raise _no_behaviors(path, drive)
    names = parse_names(asked.features)
    if names is None and not drive.readings:
        names = [TIME_IN_STATE]
        sentence = "there are no readings, so that switches can only be learned from the time in a state"
        drive = replace(drive, omissions=(*drive.omissions, f"{path}: {sentence}"))
    features = None if names is None else [parse_feature(library, each) for each in names]
    # The readings say nothing about features of the automaton itself, such as the time in a state.
    sensed = [each for each in features or () if not each.is_own]
    found = apply_splits(segment(drive, candidates, features=sensed), asked.split or ())
    return SegmentedDrive(found, library, features, is_defined)


def _open(path: Path, asked: DriveOptions, mapping: RecordingMap | None) -> OpenedDrives:
    """Read a drive, and find the library whose behaviors may explain it."""
    is_defined = True
    if mapping is None and is_trace(path):
        drive, kit = _open_trace(path, asked)
    elif mapping is None and path.suffix.lower() == ".mcap" and has_own_header(path):
        drive, kit = _open_recording(path, asked)
    else:
        drive = read_drive(path, mapping, asked.agent)
        behaviors = {} if mapping is None else mapping.behaviors
        world = None if mapping is None else mapping.world
        is_defined = asked.kit is not None or world is not None
        kit = find_kit(asked.kit, world) if is_defined else make_drive_kit(drive, behaviors)
    if asked.library is not None and asked.library.is_dir():
        return OpenedDrives(drive, open_behavior_library(None, asked.library, kit), is_defined)
    return OpenedDrives(drive, Library(kit), is_defined)


def read_drive(path: Path, mapping: RecordingMap | None, agent: int = 0) -> Record:
    """Read a drive: with a mapping file, or of an agent of whatever Understudy has written."""
    if mapping is None and _is_ours(path):
        return choose_agent(read_run(path), path, agent)
    return read_recorded_drive(path, mapping)


def _is_ours(path: Path) -> bool:
    """Return whether a path is a data set, trace, table of ticks or journal, which needs no mapping file."""
    if path.is_dir():
        return is_lerobot(path) or is_minari(path)
    return (
        is_tick_table(path)
        or is_trace(path)
        or (path.is_file() and path.stat().st_size > 0 and is_journal(path))
    )


def _open_trace(path: Path, asked: DriveOptions) -> tuple[Record, Kit]:
    """Read the drive of a robot from a trace, and find the kit of its scenario."""
    header, records = read_trace_records(path)
    drive, ran = choose_agent(records, path, asked.agent), header.run
    named, world = (asked.kit, None) if ran is None else (asked.kit or ran.kit, ran.scenario)
    if named is None and world is None:
        return drive, make_drive_kit(drive, {})
    return drive, find_kit(named, world or WORLD)


def _open_recording(path: Path, asked: DriveOptions) -> tuple[Record, Kit]:
    """Read the drive of a robot from the last run of a recording of ours, and find the kit of its world or its own."""
    recording = read_recording(path)
    drive = choose_agent(recording.records, path, asked.agent)
    if recording.runs > 1:
        left_out = f"{path}: it has {recording.runs} runs, of which the last was read"
        drive = replace(drive, omissions=(*drive.omissions, left_out))
    return drive, choose_recording_kit(recording, asked.kit, read_recorded_scenario(recording))


def _no_behaviors(path: Path, drive: Record) -> Exception:
    """Return the error that no behavior is known, with those that the commands look like."""
    found = [format_definition(each.command) for each in discover_behaviors(drive)]
    options = " ".join(f"--define 'NAME: {each}'" for each in found)
    looks = f"its commands look like {options}; or " if found else ""
    return SettingError(
        where=str(path),
        setting="--behaviors",
        problem="are none that could explain its commands",
        remedy=f"{looks}give [behaviors.NAME] in the mapping file, or --kit MODULE:NAME with your own",
    )


def print_drive_report(report: DriveReport) -> None:
    """Print the labels of a drive, the driver, and what was left out."""
    out = make_console()
    for sentence in report.omissions:
        out.print(f"[yellow]{escape(sentence)}.[/]", soft_wrap=True)
    shares = make_table("behavior", "#seconds", "#spans", "#certainty")
    for each in report.labels:
        shares.add_row(
            escape(each.label), f"{each.seconds:.1f}", str(each.spans), f"{100 * each.certainty:.0f} %"
        )
    out.print(shares)
    spans = make_table("#from, s", "#to, s", "behavior", "#certainty")
    for row in report.spans:
        doubt = " [yellow]doubtful[/]" if row.doubtful else ""
        spans.add_row(
            f"{row.from_s:.2f}", f"{row.to_s:.2f}", escape(row.label) + doubt, f"{100 * row.certainty:.0f} %"
        )
    out.print(spans)
    for channel in report.driver:
        limit = "" if channel.rate is None else f", at most {channel.rate:.3g} a tick"
        out.print(
            f"Driver on {escape(channel.channel)}: noise {channel.noise:.3g}, "
            f"{100 * channel.gain:.0f} % of the way in a tick{limit}"
        )
    counted = ", ".join(format_count(number, f"{kind} example") for kind, number in report.examples.items())
    doubtful = f"; {report.quarantined} left out as doubtful" if report.quarantined else ""
    out.print(f"Lesson: {counted}{doubtful}")
    color = "green" if report.agreement.share >= WELL_REPEATED else "yellow"
    out.print(f"Repeats [{color}]{escape(str(report.agreement))}[/]", soft_wrap=True)
    if report.reaction_s is not None:
        out.print(
            f"Reaction time {report.reaction_s:g} s. {escape(report.reaction_evidence)}", soft_wrap=True
        )
    print_drive_findings(out, report.findings)


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
    library: Library, drive: Record, definitions: Sequence[str]
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
