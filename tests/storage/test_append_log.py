"""Logs survive being cut off anywhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from understudy.errors import FileError
from understudy.storage.append_log import AppendLog, JournalLock, read_log

MAGIC = b"a log 1\n"
RECORDS = [b"one", b"two" * 20, b"\1\2", b"four"]


def write_log(path: Path, records: list[bytes]) -> bytes:
    log = AppendLog.create(path, MAGIC)
    for record in records:
        log.write(record, sync=record == b"four")
    log.close()
    return path.read_bytes()


def test_what_is_written_is_read(tmp_path: Path) -> None:
    write_log(tmp_path / "log", RECORDS)
    assert list(read_log(tmp_path / "log", MAGIC)) == RECORDS


def test_a_record_is_in_the_file_when_write_returns(tmp_path: Path) -> None:
    log = AppendLog.create(tmp_path / "log", MAGIC)
    log.write(b"one")
    assert list(read_log(tmp_path / "log", MAGIC)) == [b"one"]
    log.close()


@pytest.mark.parametrize("tail", [b"", b"\0" * 3, b"\0" * 4096, b"\xa5" * 20], ids=len)
def test_cut_off_at_every_byte(tmp_path: Path, tail: bytes) -> None:
    """What is complete stays, what is torn is cut off, and writing goes on behind it."""
    path = tmp_path / "log"
    whole = write_log(path, RECORDS)
    ends = [len(MAGIC)]
    for record in RECORDS:
        ends.append(ends[-1] + 8 + len(record))
    assert ends[-1] == len(whole)
    for cut in range(len(MAGIC), len(whole)):
        path.write_bytes(whole[:cut] + tail)
        complete = RECORDS[: sum(end <= cut for end in ends[1:])]
        assert list(read_log(path, MAGIC)) == complete
        log = AppendLog.append(path, MAGIC)
        log.write(b"more")
        log.close()
        assert list(read_log(path, MAGIC)) == [*complete, b"more"]


def test_a_changed_byte_in_the_last_record_ends_it(tmp_path: Path) -> None:
    path = tmp_path / "log"
    whole = bytearray(write_log(path, RECORDS))
    whole[-1] ^= 1
    path.write_bytes(whole)
    assert list(read_log(path, MAGIC)) == RECORDS[:-1]


def test_damage_before_complete_records_is_refused_and_nothing_is_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "log"
    whole = bytearray(write_log(path, RECORDS))
    second = len(MAGIC) + 8 + 3
    whole[second + 8 + 5] ^= 1
    path.write_bytes(whole)
    for use in (lambda: list(read_log(path, MAGIC)), lambda: AppendLog.append(path, MAGIC)):
        with pytest.raises(FileError, match=f"log at byte {second}: it is damaged there"):
            use()
    assert path.read_bytes() == bytes(whole)


def test_no_log_at_all(tmp_path: Path) -> None:
    path = tmp_path / "log"
    for content in (b"", MAGIC[:3], b"something else entirely"):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"log.*not a journal"):
            list(read_log(path, MAGIC))
    path.unlink()
    with pytest.raises(FileError, match="cannot be read"):
        list(read_log(path, MAGIC))


def test_a_log_is_never_written_over(tmp_path: Path) -> None:
    before = write_log(tmp_path / "log", RECORDS)
    with pytest.raises(FileError, match="exists already"):
        AppendLog.create(tmp_path / "log", MAGIC)
    assert (tmp_path / "log").read_bytes() == before


def test_the_folder_is_made(tmp_path: Path) -> None:
    write_log(tmp_path / "a" / "b" / "log", [b"x"])
    assert [path.name for path in (tmp_path / "a" / "b").iterdir()] == ["log"]


def test_a_log_that_is_written_is_locked(tmp_path: Path) -> None:
    path = tmp_path / "log"
    log = AppendLog.create(path, MAGIC)
    assert JournalLock.try_acquire(path) is None
    with pytest.raises(FileError, match="another session is writing it"):
        AppendLog.append(path, MAGIC)
    log.close()
    lock = JournalLock.acquire(path)
    assert JournalLock.try_acquire(path) is None
    lock.release()
    lock.release()
    AppendLog.append(path, MAGIC).close()
