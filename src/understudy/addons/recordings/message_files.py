"""Recordings of messages: MCAP files, and those of ROS 1 and ROS 2, which may be folders of several files."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from understudy.addons.recordings.bag_files import open_ros_1, open_sqlite
from understudy.addons.recordings.mcap_files import MAGIC, open_mcap
from understudy.addons.recordings.recorded_bytes import open_decompressed
from understudy.addons.recordings.recorded_topics import (
    REMEDY,
    MessageFile,
    RecordedMessage,
    RecordedTopic,
    describe_damage,
)
from understudy.errors import FileError

MCAP, SQLITE = ".mcap", ".db3"
METADATA = "metadata.yaml"
NAMED_FILE = re.compile(r"^\s*-\s+['\"]?([^\s'\"]+\.(?:db3|mcap)[.\w]*)", re.MULTILINE)
"""A file of a recording, as its metadata name it."""
MOST_OVERLAP_NS = 1_000_000_000
"""The longest time by which two files of a recording may overlap, ns."""


def open_message_file(path: Path | str, omissions: list[str], stack: ExitStack) -> MessageFile:
    """Open a recording of messages, and list its topics; `stack` closes what is unpacked of it."""
    path = Path(path)
    if not path.is_dir():
        return _open_file(path, omissions, stack)
    files = [each for each in sorted(path.iterdir(), key=_sort_key) if _is_part(each)]
    if not files:
        names = ", ".join(sorted(each.name for each in path.iterdir())[:5]) or "nothing"
        problem = f"it has no {MCAP} or {SQLITE} file, but {names}"
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY)
    _note_metadata(path, files, omissions)
    parts: list[MessageFile] = []
    for each in files:
        try:
            parts.append(_open_file(each, omissions, stack))
        except FileError as error:
            if len(files) == 1:
                raise
            omissions.append(f"{each}: {error.problem}; left out")
    if not parts:
        raise FileError(path=path, place="", problem="none of its files can be read", remedy=REMEDY)
    return _join_parts(path, parts, omissions)


def _note_metadata(path: Path, files: Sequence[Path], omissions: list[str]) -> None:
    """Say if a folder has no metadata, or these name files that are not there."""
    try:
        metadata = (path / METADATA).read_text("utf-8", "replace")
    except OSError:
        omissions.append(
            f"{path}: it has no {METADATA}, as that of a recorder that was killed; its files are read"
        )
        return
    there = {each.name for each in files}
    missing = [name for name in dict.fromkeys(NAMED_FILE.findall(metadata)) if Path(name).name not in there]
    if missing:
        omissions.append(
            f"{path}: {METADATA} names {', '.join(missing)}, which is not there; the rest is read"
        )


def _join_parts(path: Path, parts: Sequence[MessageFile], omissions: list[str]) -> MessageFile:
    """Make one recording of several files that follow each other in time."""
    topics: dict[str, RecordedTopic] = {}
    for part in parts:
        for name, topic in part.topics.items():
            if topics.setdefault(name, topic).type != topic.type:
                problem = f"its messages are {topic.type}, and {topics[name].type} in another file"
                raise FileError(
                    path=part.path, place=f"topic {name!r}", problem=problem, remedy="give one of the files"
                )
    whole = MessageFile(path, topics, lambda _: iter(()))

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        begun = []
        for part in parts:
            try:
                messages = part.read_messages(wanted, omissions) if len(parts) > 1 else part.iterate(wanted)
                if (first := next(messages, None)) is not None:
                    begun.append((first, messages, part))
            except FileError as error:
                omissions.append(f"{part.path}: {error.problem}; left out")
        begun.sort(key=lambda each: each[0].time_ns)
        whole.first_ns = begun[0][2].first_ns if begun else None
        last_ns, last_path = 0, path
        for first, messages, part in begun:
            if first.time_ns < last_ns - MOST_OVERLAP_NS:
                problem = f"it begins before {last_path.name} ends"
                remedy = "give the files of one recording, or one file"
                raise FileError(path=part.path, place="", problem=problem, remedy=remedy)
            yield first
            last_ns = max(last_ns, first.time_ns)
            for message in messages:
                last_ns = max(last_ns, message.time_ns)
                yield message
            last_path = part.path

    whole.iterate = iterate
    return whole


def _sort_key(path: Path) -> tuple[int, str]:
    """Sort drive_2.mcap before drive_10.mcap."""
    digits = "".join(each for each in path.name.partition(".")[0].rpartition("_")[2] if each.isdigit())
    return int(digits or 0), path.name


def _is_part(path: Path) -> bool:
    return any(each in {MCAP, SQLITE} for each in path.suffixes[-2:])


def _open_file(path: Path, omissions: list[str], stack: ExitStack) -> MessageFile:
    """Open a file by what it has, however it is called."""
    plain = stack.enter_context(open_decompressed(path, remedy=REMEDY))
    try:
        with plain.open("rb") as file:
            begin = file.read(64)
    except OSError as error:
        raise FileError(path=path, place="", problem=describe_damage(error), remedy=REMEDY) from None
    try:
        if begin.startswith(b"SQLite format 3"):
            opened = open_sqlite(plain, omissions, stack)
        elif begin.startswith(b"#ROSBAG"):
            opened = open_ros_1(plain)
        elif begin.startswith(MAGIC[:5]):
            opened = open_mcap(plain, omissions)
        else:
            problem = "it is empty" if not begin.strip(b"\0") else "it cannot be read (it is no recording)"
            raise FileError(path=path, place="", problem=problem, remedy=REMEDY)
    except FileError as error:
        raise FileError(path=path, place=error.place, problem=error.problem, remedy=error.remedy) from None
    opened.path = path
    return opened
