"""Teaching from a recording: a session over the recorded readings, with presses as if made during the run.

The robot moves as recorded; the presses say what it should have done. They go through a session, and so mean the same
as in any other (docs/semantics.md).
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path

import numpy as np

from understudy.errors import FileError, SessionError
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.records.reader import Recording
from understudy.records.record import GO_ON, PRESS, RESTART, TEACH, TEST, TRAIN, RecordedPress
from understudy.records.replay import ReplayBody
from understudy.training.session import Session

COLUMNS = ("time_s", "state")
DOES = "does"
STEPS = (PRESS, TEST, TRAIN, TEACH, RESTART, GO_ON)
"""The steps that a row may have: a press, switching to testing, training or live teaching, restarting the automaton,
resuming."""
NEAR_S = 1e-6
"""The tolerance in s with which a time in a table counts as that of a tick, because tables round."""


def teach_from_recording(
    recording: Recording,
    library: Library,
    lesson: Lesson,
    presses: Sequence[RecordedPress],
    *,
    targets: Mapping[str, str] | None = None,
    agent: int = 0,
) -> Session:
    """Run a session in which a lesson is taught to an agent of a recording, and return it at its end.

    It begins in training, even if the lesson's options say otherwise. SessionError is raised if a step is unknown or
    impossible.
    """
    body = ReplayBody(recording.records, recording.head)
    session = Session(body, library, lesson, targets=targets, agent=agent)
    session.train()
    waiting = sorted(presses, key=lambda each: each.tick)
    for each in waiting:  # a mistake is told before a long recording is gone through
        if each.does not in STEPS:
            raise SessionError(
                f"{recording.path} has a step {each.does!r:.60}; sessions have {', '.join(STEPS)}"
            )
        if each.state is not None:
            session.automaton.index(each.state)
    while not body.is_over:
        while waiting and waiting[0].tick <= body.tick:
            step = waiting.pop(0)
            body.wait(step.at_s)
            _do(session, step)
        session.tick()
    return session


def _do(session: Session, step: RecordedPress) -> None:
    if step.does == TEST:
        session.test()
    elif step.does == GO_ON:
        session.test(afresh=False)
    elif step.does == TRAIN:
        session.train()
    elif step.does == TEACH:
        session.teach()
    elif step.does == RESTART:
        session.restart()
    elif step.state is None:
        session.confirm()
    else:
        session.direct(step.state)


def list_pressed_states(presses: Sequence[RecordedPress]) -> tuple[str, ...]:
    """List the states that were pressed, in the order of their first press."""
    return tuple(dict.fromkeys(each.state for each in presses if each.state is not None))


def is_taught_live(presses: Sequence[RecordedPress]) -> bool:
    """Return whether the presses were made in live teaching, at least some of them."""
    return any(each.does == TEACH for each in presses)


def list_recorded_presses(recording: Recording, agent: int = 0) -> Sequence[RecordedPress]:
    """Return the presses recorded for an agent; raise SessionError if there are none."""
    presses = recording.records[agent].presses
    if not presses:
        raise SessionError(
            f"{recording.path} holds no presses; give --presses FILE.csv, with columns {', '.join(COLUMNS)}, or "
            "--behaviors A,B to find what was meant from the commands"
        )
    return presses


def read_presses(path: Path | str, recording: Recording) -> Sequence[RecordedPress]:
    """Read presses from a CSV table with the columns time_s, state and optionally `does`.

    A press takes effect at the first tick at or after time_s, in s as the recording counts; an empty state confirms
    the current one. FileError, with the line, is raised if a row is invalid.
    """
    path = Path(path)
    try:
        rows = list(csv.reader(io.StringIO(path.read_text("utf-8-sig"), newline=""), strict=True))
    except (OSError, ValueError, csv.Error) as error:
        problem = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise _wrong(path, 0, f"it cannot be read ({problem})", "give a table of presses") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    if not set(COLUMNS) <= set(header) or not set(header) <= {*COLUMNS, DOES}:
        remedy = f"begin with {','.join(COLUMNS)}, and {DOES} if you want to test or restart, too"
        raise _wrong(path, 1, f"its columns are {', '.join(header) or 'none'}", remedy)
    presses = []
    for line, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(header):
            raise _wrong(path, line, f"it has {len(row)} cells", f"give {len(header)}")
        cells = dict(zip(header, (cell.strip() for cell in row), strict=True))
        presses.append(_pressed(path, line, cells, recording))
    return presses


def _pressed(path: Path, line: int, cells: Mapping[str, str], recording: Recording) -> RecordedPress:
    does = cells.get(DOES) or PRESS
    if does not in STEPS:
        raise _wrong(
            path, line, f"{DOES} is {does!r:.60}", f"give {', '.join(STEPS)}, or nothing for a press"
        )
    try:
        time_s = float(cells["time_s"])
    except ValueError:
        time_s = np.nan
    first, last = (float(recording.times[end]) for end in (0, -1))
    if not (isfinite(time_s) and first - recording.head.tick_s <= time_s <= last + NEAR_S):
        remedy = f"give one of the recording, from {first:g} to {last:g}"
        raise _wrong(path, line, f"time_s is {cells['time_s']!r:.60}", remedy)
    tick = int(np.searchsorted(recording.times, time_s - NEAR_S))
    return RecordedPress(tick, cells["state"] or None, does=does)


def _wrong(path: Path, line: int, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place=f"line {line}" if line else "", problem=problem, remedy=remedy)
