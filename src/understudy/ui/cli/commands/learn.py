"""Command `understudy learn`: learn an automaton from a table, or from a recording and presses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from understudy.ui.cli.options import Json, KitName
from understudy.ui.cli.recording_options import (
    DrivenBehaviors,
    DrivenFeatures,
    DriverNames,
    MapFile,
    RecordedAgent,
    RecordedTargets,
    TrustedDriver,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from understudy.learning.csv_table import QueryRow
    from understudy.learning.report import Report
    from understudy.model.change_summary import ChangeSummary
    from understudy.model.lesson import Lesson
    from understudy.model.library import Library, TrainedAutomaton
    from understudy.robots.recording.reader import RecordedPress
    from understudy.segmentation.segmentation_report import DriveReport
    from understudy.ui.cli.commands.learn_from_drivers import DriversReport


OF_RECORDINGS = (
    "presses", "states", "features", "parameters", "targets", "reaction", "agent", "session", "kit", "mapping",
    "behaviors", "define", "split", "driver", "trust",
)  # fmt: skip
"""Options that only apply to recordings."""


def learn_lesson(
    context: typer.Context,
    lesson: Annotated[
        Path | None, typer.Argument(metavar="[LESSON.csv]", help="Table of examples.", show_default=False)
    ] = None,
    predict: Annotated[
        Path | None,
        typer.Option(
            "--predict", metavar="ROWS.csv", help="Predict the next state for each row of this table."
        ),
    ] = None,
    library: Annotated[
        Path | None, typer.Option("--library", "-l", help="Save the automaton to this folder; needs --name.")
    ] = None,
    name: Annotated[str | None, typer.Option("--name", "-n", help="Name of the automaton.")] = None,
    recording: Annotated[
        list[Path] | None,
        typer.Option(
            "--recording",
            metavar="FILE",
            help="Take examples from a recording instead of a table: MCAP of `understudy run` with presses, or a "
            "drive without presses: CSV, JSON lines or Parquet, or with --map MCAP or a bag of ROS. Several drives "
            "make one lesson.",
        ),
    ] = None,
    driver: DriverNames = None,
    trust: TrustedDriver = None,
    presses: Annotated[
        Path | None,
        typer.Option(
            "--presses",
            metavar="FILE.csv",
            help="Presses as a table time_s,state; those in the recording if left out.",
        ),
    ] = None,
    states: Annotated[
        str | None,
        typer.Option(
            "--states", metavar="A,B(C)", help="States of the automaton; those pressed if left out."
        ),
    ] = None,
    features: DrivenFeatures = None,
    flags: Annotated[
        str | None,
        typer.Option(
            "--flags", metavar="A,B", help="Flags it can raise; done and failed, if shown, if left out."
        ),
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option("--parameters", metavar="A,B", help="Parameters, to be bound to targets later."),
    ] = None,
    targets: RecordedTargets = None,
    reaction: Annotated[
        float | None,
        typer.Option(
            "--reaction",
            min=0.0,
            max=1.0,
            metavar="SECONDS",
            help="Reaction time by which presses are shifted earlier.",
        ),
    ] = None,
    agent: RecordedAgent = 0,
    session: Annotated[
        int | None,
        typer.Option(
            "--session", min=1, help="Number of the session in the recording, from 1; the last if left out."
        ),
    ] = None,
    mapping: MapFile = None,
    behaviors: DrivenBehaviors = None,
    define: Annotated[
        list[str] | None,
        typer.Option(
            "--define",
            metavar="'NAME: CHANNEL VALUE, ...'",
            help="A behavior that may explain a recording, by its constant commands; may be repeated.",
        ),
    ] = None,
    split: Annotated[
        list[str] | None,
        typer.Option(
            "--split",
            metavar="'STATE after STATE'",
            help="Give a state of its own to where a state follows certain others; may be repeated.",
        ),
    ] = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Learn an automaton's transition functions from a table of examples, or from a recording with or without presses.

    Columns are state, next, kind (directive, default, confirmation or watched), and one for each feature. The header
    of a feature includes its kind: distance:continuous, bearing:toroidal(6.283185307179586),
    ready:categorical(no|yes). An empty cell is an absent reading.

    [dim]understudy learn lesson.csv --predict rows.csv --json[/]

    Presses over a recording have the same effect as in a session: each gives a directive and a default.

    [dim]understudy learn --recording drive.mcap --presses presses.csv --features 'distance_to(station)'[/]

    Without presses, the commands of a drive say which behavior the driver meant at each tick.

    [dim]understudy learn --recording drive.csv --map map.toml --behaviors forward,left,right[/]

    Drives of several drivers make one lesson, which says who showed what, and where they contradict each other.

    [dim]understudy learn --recording anna.csv --recording ben.csv --map map.toml --trust anna[/]
    """
    from understudy.errors import SettingError
    from understudy.learning.csv_table import read_lesson_table, read_query_rows
    from understudy.learning.fit import predict_next_states as predicted
    from understudy.learning.report import learn_and_report
    from understudy.model.library import TrainedAutomaton
    from understudy.ui.cli.commands.learn_from_drive import DriveOptions, learn_from_drive, print_drive_report
    from understudy.ui.cli.commands.learn_from_drivers import (
        group_recordings,
        learn_from_drivers,
        print_drivers_report,
    )
    from understudy.ui.cli.options import parse_names, parse_targets
    from understudy.ui.cli.output import print_json

    if (library is None) != (name is None):
        # No name is assumed: saving would replace an automaton of that name, which may be another one.
        missing, remedy = (
            ("--name", f"give the name to save the automaton under in {library}, such as --name driven")
            if name is None
            else (
                "--library",
                f"give the folder of the library to save {name!r} in, such as --library library",
            )
        )
        raise SettingError(where="learn", setting=missing, problem="is missing", remedy=remedy)
    drive: DriveReport | None = None
    joint: DriversReport | None = None
    if lesson is not None and not recording:
        _only_table(context)
        shown = read_lesson_table(lesson, name=name, flags=None if flags is None else parse_names(flags))
    elif (
        recording
        and lesson is None
        and any(_is_drive(each, mapping, behaviors or define) for each in recording)
    ):
        for each in recording:
            _refuse_presses(context, each)
        options = DriveOptions(
            name,
            library,
            mapping,
            behaviors,
            features,
            reaction,
            kit,
            agent,
            define or (),
            split or (),
            parse_targets(targets),
        )
        grouped = group_recordings(recording, driver or (), trust)
        if len(grouped) == 1:
            ((own, paths),) = grouped.items()
            shown, drive = learn_from_drive(paths, options, driver=own)
        else:
            shown, joint = learn_from_drivers(grouped, options, trust)
    elif recording and lesson is None:
        _only_drives(context, recording)
        asked = LearnOptions(
            name,
            library,
            presses,
            states,
            features,
            flags,
            parameters,
            targets,
            reaction,
            agent,
            session,
            kit,
        )
        shown = learn_from_recording(recording[0], asked)
    else:
        problem = "is missing" if lesson is None else "is one too many beside a recording"
        remedy = "give either a table, or --recording FILE"
        raise SettingError(where="learn", setting="LESSON.csv", problem=problem, remedy=remedy)
    rows = None if predict is None else read_query_rows(predict, shown)
    result = learn_and_report(shown)
    automaton = replace(shown.automaton, transitions=result.transitions)
    saved = None if library is None else _save(library, TrainedAutomaton(automaton, shown))
    following = None if rows is None else predicted(result.transitions, automaton.state_names, rows)
    if not as_json:
        if drive is not None:
            print_drive_report(drive)
        if joint is not None:
            print_drivers_report(joint)
        _show(result, rows, following)
        if saved is not None:
            _print_saved(*saved)
        return
    told: dict[str, object] = {"states": result.states, "predictions": following or []}
    if drive is not None:
        told["drive"] = drive
    if joint is not None:
        told |= {"drivers": joint.drivers, "contradictions": joint.contradictions, "trusted": joint.trusted}
        told["quarantined"] = joint.quarantined
    if saved is not None:
        path, changed = saved
        told |= {"saved": str(path), "changed": () if changed is None else changed.changes}
    print_json(told)


def _is_drive(recording: Path, mapping: Path | None, behaviors: str | list[str] | None) -> bool:
    """Return whether a recording is to be segmented, because nothing else says what its driver meant."""
    return mapping is not None or behaviors is not None or recording.suffix.lower() != ".mcap"


def _refuse_presses(context: typer.Context, recording: Path) -> None:
    """Refuse options that only apply to recordings with presses; traces have several robots, too."""
    from understudy.analysis.run_header import is_trace
    from understudy.errors import SettingError

    options = ("presses", "states", "flags", "parameters", "session")
    for option in options if is_trace(recording) else (*options, "agent"):
        source = context.get_parameter_source(option)
        if source is not None and source.name == "COMMANDLINE":
            problem = "is not used with a recording whose behaviors are found from its commands"
            remedy = "leave it out, or give neither --map nor --behaviors"
            raise SettingError(where="learn", setting=f"--{option}", problem=problem, remedy=remedy)


def _only_drives(context: typer.Context, recordings: Sequence[Path]) -> None:
    """Refuse several recordings with presses, and options that apply only to drives."""
    from understudy.errors import SettingError

    if len(recordings) > 1:
        problem, remedy = "is given several times", "give recordings with presses one by one"
        raise SettingError(where="learn", setting="--recording", problem=problem, remedy=remedy)
    for option in ("driver", "trust"):
        source = context.get_parameter_source(option)
        if source is not None and source.name == "COMMANDLINE":
            problem, remedy = "is not used with a recording of presses", "leave it out, or give a drive"
            raise SettingError(where="learn", setting=f"--{option}", problem=problem, remedy=remedy)


def _only_table(context: typer.Context) -> None:
    """Refuse options that apply only to recordings when a table is given."""
    from understudy.errors import SettingError

    for option in OF_RECORDINGS:
        source = context.get_parameter_source(option)
        if source is not None and source.name == "COMMANDLINE":
            problem, remedy = "is not used with a table", "leave it out, or give --recording"
            raise SettingError(
                where="learn",
                setting=f"--{'map' if option == 'mapping' else option}",
                problem=problem,
                remedy=remedy,
            )


def _save(folder: Path, taught: TrainedAutomaton) -> tuple[Path, ChangeSummary | None]:
    """Save the automaton; refuse if automata of the folder would then contain themselves.

    Return its path, and what it decides otherwise than the version that it replaces, if that has the same states.
    """
    from understudy.learning.lesson_change import summarize_lesson_change
    from understudy.model.library import Kit, Library
    from understudy.storage.library_folder import open_each_automaton, save_automaton

    beside = (
        open_each_automaton(folder, None, lambda _: {}).library
        if folder.is_dir()
        else Library(Kit.from_parts())
    )
    beside.with_automaton(taught)
    former = beside.taught.get(taught.automaton.name)
    changed = None
    if former is not None and former.automaton.state_names == taught.automaton.state_names:
        changed = summarize_lesson_change(former, taught)
    return save_automaton(folder, taught), changed


def _print_saved(path: Path, changed: ChangeSummary | None) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import make_console

    out = make_console()
    out.print(f"Saved to [bold]{escape(str(path))}[/]", soft_wrap=True)
    if changed is not None:
        out.print("What it decides otherwise than the version before, beyond what new rows say:")
        for each in changed.changes:
            out.print(Padding(f"[yellow]{escape(each.said)}[/]", (0, 0, 0, 2), expand=False))


def _show(result: Report, rows: tuple[QueryRow, ...] | None, following: list[str] | None) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import format_count, make_console, make_table

    out = make_console()
    if not result.states:
        out.print("[yellow]Nothing was learned: no example was made by a press.[/]")
    for name, state in result.states.items():
        size = f"{format_count(state.nodes, 'node')}, depth {state.depth}, {state.fit_ms:.2g} ms"
        out.print(f"[cyan]{escape(name)}[/] [dim]{size}[/]")
        for line in state.conditions:
            out.print(Padding(escape(line), (0, 0, 0, 2), expand=False))
        for number, what in ((state.contradictions, "contradiction"), (state.disagreements, "disagreement")):
            if number:
                out.print(Padding(f"[yellow]{format_count(number, what)}[/]", (0, 0, 0, 2), expand=False))
        if state.overruled:
            said = f"{state.overruled} of {format_count(state.watched, 'watched example')} decided otherwise"
            out.print(Padding(f"[yellow]{said}[/]", (0, 0, 0, 2), expand=False))
    if rows is not None and following is not None:
        made = make_table("#row", "state", "next")
        for index, (row, next_state) in enumerate(zip(rows, following, strict=True), 1):
            made.add_row(
                str(index), escape(row.state), "[dim]stay[/]" if next_state == row.state else next_state
            )
        out.print(made)


class LearnOptions(NamedTuple):
    """Options of `understudy learn` for a recording; None for those that were not given."""

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


def learn_from_recording(path: Path, asked: LearnOptions) -> Lesson:
    """Make a lesson from a recording of a robot and a table of presses, or of those in the recording.

    If the library has the automaton already, its lesson is extended.
    """
    from understudy.errors import FileError, SettingError
    from understudy.model.library import Library
    from understudy.robots.recording.reader import has_own_header, read_recording
    from understudy.robots.recording.teach_from_recording import (
        list_recorded_presses,
        read_presses,
        teach_from_recording,
    )
    from understudy.ui.cli.options import open_behavior_library, parse_targets
    from understudy.ui.cli.recordings import choose_recording_kit, read_recorded_scenario

    if has_own_header(path) is False:
        problem = "it is no recording of `understudy`"
        remedy = "give --map MAP.toml, which says what fields of its messages are readings and commands"
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


def _begun(library: Library, asked: LearnOptions, presses: Sequence[RecordedPress]) -> Lesson:
    """Return the lesson that the presses are added to: that of an automaton of the library, or an empty one."""
    from dataclasses import replace

    from understudy.errors import SettingError
    from understudy.model.automaton import USUAL_FLAGS
    from understudy.model.learner_options import LearnerOptions
    from understudy.robots.recording.teach_from_recording import is_taught_live, list_pressed_states
    from understudy.training.lesson_design import new_lesson
    from understudy.ui.cli.options import parse_names

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
        options=LearnerOptions(reaction_s=asked.reaction_s or 0.0),
        live=is_taught_live(presses),
    )
