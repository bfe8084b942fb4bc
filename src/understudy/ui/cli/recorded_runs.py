"""Recordings in commands: record a simulated run, and find the scenario, the kit and the libraries of a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.addons.bridges.environments.body_maker import find_world
from understudy.errors import FileError, UnderstudyError
from understudy.judging.explain_run import RunNotReproducible
from understudy.judging.run_header import fingerprint_libraries, fingerprint_programs
from understudy.learning.fit import learn
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.records.header import SCENARIO, RunInfo
from understudy.records.recorder import RunRecorder
from understudy.records.writer import check_recording_path
from understudy.runtime.body import Body, Commands, list_reading_keys
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import format_scenario, parse_scenario
from understudy.sim.team.libraries import Libraries, find_type_folders
from understudy.sim.world import World
from understudy.storage.atomic_write import check_file_place
from understudy.storage.document import fingerprint_automaton
from understudy.storage.library_folder import list_versions, load_version
from understudy.ui.cli.named_inputs import (
    ALONE,
    RunAssignment,
    find_kit,
    find_optional_scenario,
    make_world_kit,
    open_behavior_library,
    open_team_libraries,
)
from understudy.ui.cli.options import WORLD

if TYPE_CHECKING:
    from understudy.records.reader import Recording
    from understudy.records.record import Record
    from understudy.runtime.link import Program
    from understudy.runtime.team.team import Team
    from understudy.sim.scenario.schema import Scenario


SUFFIX = ".mcap"
PICTURES = (".gif", ".png")
"""Endings of files in which a run is drawn."""
DRAWING = "writing the picture"
PICTURE_REMEDY = "name a file in a folder that exists and that you may write to"


def check_record_place(path: Path | None) -> None:
    """Refuse a file to which a run cannot be recorded or drawn, before anything is compiled; None is no file."""
    if path is None:
        return
    if is_recording(path):
        check_recording_path(path)
    else:
        check_file_place(path, DRAWING, remedy=PICTURE_REMEDY)


@contextmanager
def record_team_ticks(
    path: Path | None, team: Team, *, ran: Callable[[], RunInfo]
) -> Iterator[Callable[[], None]]:
    """Yield the function that advances the team by one tick, recording it if `path` is a recording.

    `ran` returns the description of the run for the recording's header.
    """
    body = team.ground
    if not isinstance(body, World):
        raise TypeError("a team of real robots")
    files = {SCENARIO: format_scenario(body.scenario)}
    with record_ticks(
        path,
        body,
        team.tick,
        lambda: team.paths,
        ran=ran,
        files=files,
        commands=lambda: team.layers[0].commands,
    ) as tick:
        yield tick


@contextmanager
def record_ticks(
    path: Path | None,
    body: Body,
    advance: Callable[[], None],
    list_paths: Callable[[], Sequence[Sequence[str]]],
    *,
    ran: Callable[[], RunInfo],
    files: Mapping[str, str] | None = None,
    commands: Callable[[], Commands | None] = lambda: None,
) -> Iterator[Callable[[], None]]:
    """Yield the function that advances the agents of a body by one tick, recording it if `path` is a recording.

    `advance` advances them, `list_paths` lists the states of each, outermost first, `ran` returns the description of
    the run for the recording's header, and `files` are stored in it. `commands` returns the commands of the last tick
    by channel, if they are known.
    """
    if path is None or not is_recording(path):
        yield advance
        return
    keys = list_reading_keys(body)
    with RunRecorder(path, clock=lambda: body.time_s) as recorder:
        recorder.begin(body, ran=ran(), files=files)

        def tick() -> None:
            time_s, percept = body.time_s, body.sense(keys)
            advance()
            recorder.write_tick(time_s, percept, list_paths(), commands=commands(), at_s=time_s)

        yield tick


def make_run_info(
    programs: Mapping[str, Sequence[Program]],
    assigned: RunAssignment,
    library: Path,
    *,
    scenario: str | None,
    seed: int,
    kit: str | None,
) -> RunInfo:
    """Describe a team's run, in which agents may run `programs`, for the header of a recording or a trace."""
    return RunInfo(
        scenario=scenario,
        seed=seed,
        kit=kit,
        library=str(library.resolve()),
        sorts=list(assigned.roots),
        behavior=assigned.behavior,
        binding=assigned.binding,
        automata=fingerprint_libraries(programs, assigned.libraries),
    )


def describe_body_run(
    program: Program, assigned: RunAssignment, *, world: str, seed: int, library: Path, kit: str | None
) -> RunInfo:
    """Describe a run on a body of the user's own for the header of its recording."""
    automata = fingerprint_programs([program], assigned.libraries[assigned.sort])
    return RunInfo(
        scenario=world,
        seed=seed,
        kit=kit,
        library=str(library.resolve()),
        sorts=[assigned.sort],
        behavior=assigned.behavior,
        binding=assigned.binding,
        automata={assigned.sort: automata},
    )


def is_recording(path: Path) -> bool:
    """Return whether the file name ends as that of a recording."""
    return path.suffix.lower() == SUFFIX


def read_run(path: Path) -> list[Record]:
    """Read the records of a journal, recording, trace, table of ticks or data set, whichever it is."""
    from understudy.addons.bridges.datasets.lerobot_reader import is_lerobot, read_lerobot
    from understudy.addons.bridges.datasets.minari_reader import is_minari, read_minari
    from understudy.judging.record_files import read_records

    if is_lerobot(path):
        return read_lerobot(path)
    return read_minari(path) if is_minari(path) else read_records(path)


def read_recorded_scenario(recording: Recording) -> Scenario | None:
    """Return the scenario stored in a recording, or the one it names; None if it has neither, as of a robot."""
    kept, ran = recording.head.files.get(SCENARIO), recording.head.ran
    if kept is not None:
        return parse_scenario(kept, f"{recording.path} ({SCENARIO})")
    return find_optional_scenario(ran.scenario)


def choose_recording_kit(recording: Recording, named: str | None, where: Scenario | None) -> Kit:
    """Return the kit named, else the kit that the recording names, else that of its scenario or body."""
    named = named or recording.head.ran.kit
    if named is not None:
        return find_kit(named, WORLD)
    if where is None and recording.head.ran.scenario is not None:
        return make_world_kit(find_world(recording.head.ran.scenario))
    if where is None:
        problem, remedy = "it names neither its world nor its kit", "give --kit MODULE:NAME"
        raise FileError(path=recording.path, place="", problem=problem, remedy=remedy)
    return make_scenario_kit(where)


def load_current_libraries(where: Scenario | None, behavior: str | None, folder: Path, kit: Kit) -> Libraries:
    """Load the current library of every sort of agents in a scenario, or of a single robot without one."""
    if where is None:
        return {ALONE: open_behavior_library(behavior, folder, kit)}
    return open_team_libraries(where, behavior, folder, kit)


def load_recorded_libraries(
    where: Scenario | None,
    behavior: str | None,
    folder: Path,
    kit: Kit,
    automata: Mapping[str, Mapping[str, str]],
) -> tuple[Libraries, dict[str, int]]:
    """Load the libraries of all sorts as they were when a run was made.

    `automata` holds the fingerprints of the run, by sort and name. Also returns the version number of each automaton
    that has changed since. Raises RunNotReproducible if no stored version has the fingerprint.
    """
    known = dict(load_current_libraries(where, behavior, folder, kit))
    places = {} if where is None else find_type_folders(where, folder, kit)
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
    """Return the library with the automaton of this fingerprint, and its version number (None: current)."""
    now = library.taught.get(name)
    if now is not None and fingerprint_automaton(now) == mark:
        return library, None
    for version in reversed(list_versions(place, name)):
        try:
            taught: TrainedAutomaton = load_version(place, name, version.number, library.kit, learn).taught
        except UnderstudyError:
            continue  # of another kit, or damaged: it is none of what was run, as far as anybody can tell
        if fingerprint_automaton(taught) == mark:
            return library.with_automaton(taught), version.number
    problem = f"{name} in {place} {'is another by now' if now else 'is gone'}, and no former version is what was run"
    raise RunNotReproducible(problem=problem, remedy="run it again with --trace, and ask that")
