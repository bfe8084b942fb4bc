"""Episodes of a recording: one of each run and agent, and in a team's recording one of each agent and coordinator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode, EpisodePress
from understudy.model.kinds import Kind
from understudy.records.message_types import format_reading_label
from understudy.records.reader import (
    PRESS,
    TEACH,
    TEST,
    TRAIN,
    RecordedPress,
    Recording,
    read_recording,
)
from understudy.records.team_reader import read_team_recording


def read_recording_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a recording.

    Recordings have all readings of the body and the states of all levels. They have no commands beside the messages to
    the robot, and do not say which kind of example a press recorded.
    """
    path = Path(path)
    if not path.is_file():
        remedy = "name a file that `understudy run --record FILE.mcap` wrote"
        raise FileError(path=path, place="", problem="there is no such file", remedy=remedy)
    team = read_team_recording(path)
    if team is not None:
        return [episode for part in team.parts for episode in _list_episodes(team.read_part(part), part)]
    last = read_recording(path)
    runs = [read_recording(path, run=number) for number in range(1, last.runs)]
    return [episode for recording in (*runs, last) for episode in _list_episodes(recording, "")]


def _list_episodes(recording: Recording, part: str) -> Iterator[Episode]:
    head = recording.head
    kinds = _find_kinds(recording)
    for number, name in enumerate(head.names):
        yield Episode(
            agent=part or name.strip("/") or f"robot {number}",
            tick_s=head.tick_s,
            times=recording.times,
            states=tuple(recording.paths[number]),
            readings={
                format_reading_label(key): recording.values[:, row, number]
                for row, key in enumerate(recording.keys)
            },
            kinds=kinds,
            presses=tuple(_list_presses(recording.presses[number], recording.ticks)),
            source=str(recording.path),
            seed=head.ran.seed if head.ran.scenario is not None else None,
            behavior=head.ran.behavior or "",
        )


def _find_kinds(recording: Recording) -> dict[str, Kind]:
    kind_of = {reading.name: reading.kind for reading in recording.head.readings}
    return {format_reading_label(key): kind_of[key[0]] for key in recording.keys}


def _list_presses(steps: Sequence[RecordedPress], ticks: int) -> list[EpisodePress]:
    """List the presses among the steps of a session; of several before one tick the last counts.

    Those while the automaton is tested are corrections.
    """
    is_tested, presses = False, dict[int, EpisodePress]()
    for step in steps:
        if step.does in (TEST, TRAIN, TEACH):
            is_tested = step.does == TEST
        elif step.does == PRESS and step.tick < ticks:
            presses[step.tick] = EpisodePress(step.tick, step.state, is_tested)
            is_tested = False  # a press ends testing
    return list(presses.values())
