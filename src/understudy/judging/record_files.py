"""The files that data are read from: journals, recordings, traces and tables have records, lessons examples."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from understudy.errors import FileError
from understudy.model.lesson import Lesson
from understudy.records.record import Record
from understudy.records.table_files import is_tick_table, read_tick_records
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.parquet import LINES, PARQUET

RECORDING = ".mcap"
TRACES = (LINES, PARQUET)
DOCUMENT, TABLE = ".json", ".csv"
LESSON_REMEDY = "name a library's document (.json), a table of examples (.csv), or a session's journal"
REMEDY = (
    "name a session's journal, a recording (.mcap) or trace (.jsonl, .parquet) of `understudy run`, or a table of "
    "ticks"
)


def read_records(path: Path | str) -> list[Record]:
    """Read the records of a journal, a recording, a trace, a table of ticks or a data set, whichever it is.

    Parameters
    ----------
    path
        Journal of a session, recording of a run, of sessions or of a team (.mcap), trace (.jsonl or .parquet), or table
        of ticks (.csv, .jsonl or .parquet).

    Returns
    -------
    list of Record
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
        return _read_recording_records(path)
    if path.suffix.lower() in (TABLE, *TRACES) and is_tick_table(path):
        return read_tick_records(path)
    if path.suffix.lower() in TRACES:
        from understudy.records.trace_reader import read_trace_records

        _, records = read_trace_records(path)
        if not records:
            remedy = "name a trace of a run that had ended or was interrupted"
            raise FileError(path=path, place="", problem="the trace has no tick", remedy=remedy)
        return records
    if is_journal(path):
        from understudy.training.journal_records import read_journal_records

        return read_journal_records(path)
    problem = "it is neither a journal nor a recording nor a trace"
    raise FileError(path=path, place="", problem=problem, remedy=REMEDY)


def _read_recording_records(path: Path) -> list[Record]:
    """Read the records of all runs of a recording, or of all agents and coordinators of a team."""
    from understudy.records.reader import read_recording
    from understudy.records.team_reader import read_team_recording

    if not path.is_file():
        remedy = "name a file that `understudy run --record FILE.mcap` wrote"
        raise FileError(path=path, place="", problem="there is no such file", remedy=remedy)
    team = read_team_recording(path)
    if team is not None:
        return [replace(each, agent=part) for part in team.parts for each in team.read_part(part).records]
    last = read_recording(path)
    runs = [read_recording(path, run=number) for number in range(1, last.runs)]
    return [record for run in (*runs, last) for record in run.records]


def read_lesson(path: Path | str) -> Lesson:
    """Read the lesson of an automaton's document (.json), of a table of examples (.csv), or of a journal.

    Of a journal, it is the lesson at the end of the session. Its features are as the file has them.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Lesson
        The lesson.

    Raises
    ------
    FileError
        If the file is none of them, is damaged, or has no lesson.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == TABLE:
        from understudy.learning.csv_table import read_lesson_table

        return read_lesson_table(path)
    if suffix == DOCUMENT:
        from understudy.storage.library_folder import open_document

        lesson = open_document(path, None, lambda _: {}).taught.lesson
        if lesson is None:
            problem, remedy = (
                "it has trees and no lesson",
                "name the document of an automaton with its lesson",
            )
            raise FileError(path=path, place="", problem=problem, remedy=remedy)
        return lesson
    if suffix not in (RECORDING, *TRACES) and is_journal(path):
        from understudy.training.journal_replay import ReplayedSession

        return ReplayedSession.from_journal(path, None).history.lesson
    raise FileError(path=path, place="", problem="it has no lesson", remedy=LESSON_REMEDY)


def is_journal(path: Path | str) -> bool:
    """Return whether a file begins as journals do; FileError if it cannot be read or is empty."""
    from understudy.training.journal import MAGIC

    path = Path(path)
    with convert_os_errors(path, "reading it", remedy=REMEDY), path.open("rb") as file:
        first = file.read(len(MAGIC))
    if not first:
        raise FileError(path=path, place="", problem="it is empty", remedy=REMEDY)
    return first == MAGIC
