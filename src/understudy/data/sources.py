"""The files that episodes are read from: journals, recordings and traces."""

from __future__ import annotations

from pathlib import Path

from understudy.data.episode import Episode
from understudy.errors import FileError
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.parquet import LINES, PARQUET

RECORDING = ".mcap"
TRACES = (LINES, PARQUET)
REMEDY = "name a session's journal, a recording (.mcap), or a trace (.jsonl or .parquet) that `understudy run` wrote"


def read_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a journal, a recording or a trace, whichever the file is.

    Parameters
    ----------
    path
        Journal of a session, recording of a run, of sessions or of a team (.mcap), or trace (.jsonl or .parquet).

    Returns
    -------
    list of Episode
        One of each agent and run, in the order of the file. A journal gives one from each restart or move of the robot
        to the next.

    Raises
    ------
    FileError
        If the file is none of them, is damaged, or has no tick.
    ExtraMissing
        If it is a recording and the extra `ros2` is not installed.
    """
    path = Path(path)
    if path.suffix.lower() == RECORDING:
        from understudy.data.recording_episodes import read_recording_episodes

        return read_recording_episodes(path)
    if path.suffix.lower() in TRACES:
        from understudy.data.trace_episodes import read_trace_episodes

        return read_trace_episodes(path)
    if is_journal(path):
        from understudy.data.journal_episodes import read_journal_episodes

        return read_journal_episodes(path)
    problem = "it is neither a journal nor a recording nor a trace"
    raise FileError(path=path, place="", problem=problem, remedy=REMEDY)


def is_journal(path: Path | str) -> bool:
    """Return whether a file begins as journals do; FileError if it cannot be read or is empty."""
    from understudy.training.journal import MAGIC

    path = Path(path)
    with convert_os_errors(path, "reading it", remedy=REMEDY), path.open("rb") as file:
        first = file.read(len(MAGIC))
    if not first:
        raise FileError(path=path, place="", problem="it is empty", remedy=REMEDY)
    return first == MAGIC
