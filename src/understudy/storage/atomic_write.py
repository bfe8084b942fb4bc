"""Atomic writing: at every moment a file is either the old or the new one, even if the program is killed."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from understudy.errors import FileError

try:
    import fcntl
except (
    ImportError
):  # pragma: no cover - Windows has no advisory locks on folders; there, one writer at a time
    fcntl = None  # type: ignore[assignment]

UNFINISHED = ".unfinished"
"""The ending of the names of files that are still being written; these names begin with a dot."""
FULL = (errno.ENOSPC, errno.EDQUOT)
FREE_SPACE = "free space on that disk, or name a place on another"
TRIAL_BYTES = 4096


def write_atomically(path: Path | str, data: bytes) -> None:
    """Write `data` to `path`: to a temporary file beside it, which is synced and then renamed."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
    try:
        with temporary.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
        sync_folder(path.parent)
    finally:
        temporary.unlink(missing_ok=True)


def sync_folder(folder: Path | str) -> None:
    """Wait until files that were renamed or created in a folder are on disk, to survive a power cut."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def check_file_place(path: Path | str, doing: str, **remedy: str) -> None:
    """Check by a trial that a file can be written to a path, before the long work of which it will be the result.

    FileError is raised if its folder is missing or cannot be written to, if the disk is full, or if a folder has that
    name. Nothing changes: the trial is another file beside it, which is removed. `doing` and `remedy` are for the
    message, as `convert_os_errors` takes them.
    """
    path = Path(path)
    with convert_os_errors(path, doing, **remedy):
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        _try_to_write(path)


def check_folder_place(folder: Path | str, doing: str, **remedy: str) -> None:
    """Check by a trial that a folder can be written to a path, or replaced there; as `check_file_place`.

    Missing folders around it are no error, since they are made with it.
    """
    folder = Path(folder)
    with convert_os_errors(folder, doing, **remedy):
        place = folder.resolve()
        while not place.parent.exists():
            place = place.parent
        _try_to_write(place)


def _try_to_write(path: Path) -> None:
    """Write a block beside a path, wait until it is on disk, and remove it."""
    trial = path.with_name(f".{path.name}.{os.getpid()}.trial{UNFINISHED}")
    try:
        with trial.open("xb", buffering=0) as file:
            file.write(bytes(TRIAL_BYTES))
            os.fsync(file.fileno())
    finally:
        with suppress(OSError):  # where it could not be made, as a file's name cannot be that of a folder
            trial.unlink()


@contextmanager
def lock_folder(folder: Path | str) -> Iterator[None]:
    """Lock a folder against writing by other processes, and remove unfinished files of killed ones."""
    if fcntl is None:  # pragma: no cover
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        for left in Path(folder).glob(f".*{UNFINISHED}"):
            left.unlink(missing_ok=True)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def convert_os_errors(
    path: Path | str, doing: str, remedy: str = "see that the folder exists and that you may use it"
) -> Iterator[None]:
    """Convert errors of the operating system raised inside into a FileError of this path.

    `doing` is the action that failed, such as "saving"; `remedy` says what to do, unless the disk is full.
    """
    try:
        yield
    except OSError as error:
        named = str(error.filename or path)  # the user did not name the unfinished file
        raise FileError(
            path=path if named.endswith(UNFINISHED) else named,
            place="",
            problem=f"{doing} failed: {error.strerror or error}",
            remedy=FREE_SPACE if error.errno in FULL else remedy,
        ) from error
