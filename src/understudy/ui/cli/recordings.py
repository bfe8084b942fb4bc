"""Recordings in commands: record a simulated run, and find the scenario and kit of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from understudy.model.library import Kit
    from understudy.robots.recording.header import RunInfo
    from understudy.robots.recording.reader import Recording
    from understudy.runtime.body import Body, Commands
    from understudy.runtime.program import Program
    from understudy.runtime.team.team import Team
    from understudy.sim.scenario.schema import Scenario
    from understudy.ui.cli.options import RunAssignment

SUFFIX = ".mcap"


@contextmanager
def record_team_ticks(
    path: Path | None, team: Team, *, ran: Callable[[], RunInfo]
) -> Iterator[Callable[[], None]]:
    """Yield the function that advances the team by one tick, recording it if `path` is a recording.

    `ran` returns the description of the run for the recording's header.
    """
    from understudy.robots.recording.header import SCENARIO
    from understudy.sim.scenario.files import format_scenario
    from understudy.sim.world import World

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
    from understudy.robots.recording.recorder import RunRecorder
    from understudy.runtime.body import list_reading_keys

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
    from understudy.analysis.run_header import fingerprint_libraries
    from understudy.robots.recording.header import RunInfo

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


def is_recording(path: Path) -> bool:
    """Return whether the file name ends as that of a recording."""
    return path.suffix.lower() == SUFFIX


def read_recorded_scenario(recording: Recording) -> Scenario | None:
    """Return the scenario stored in a recording, or the one it names; None if it has neither, as of a robot."""
    from understudy.robots.recording.header import SCENARIO
    from understudy.sim.scenario.files import parse_scenario
    from understudy.ui.cli.options import find_optional_scenario

    kept, ran = recording.head.files.get(SCENARIO), recording.head.ran
    if kept is not None:
        return parse_scenario(kept, f"{recording.path} ({SCENARIO})")
    return find_optional_scenario(ran.scenario)


def choose_recording_kit(recording: Recording, named: str | None, where: Scenario | None) -> Kit:
    """Return the kit named, else the kit that the recording names, else that of its scenario or body."""
    from understudy.errors import FileError
    from understudy.sim.kit import make_scenario_kit
    from understudy.ui.cli.options import WORLD, find_kit, make_world_kit, open_world

    named = named or recording.head.ran.kit
    if named is not None:
        return find_kit(named, WORLD)
    if where is None and recording.head.ran.scenario is not None:
        return make_world_kit(open_world(recording.head.ran.scenario))
    if where is None:
        problem, remedy = "it names neither its world nor its kit", "give --kit MODULE:NAME"
        raise FileError(path=recording.path, place="", problem=problem, remedy=remedy)
    return make_scenario_kit(where)
