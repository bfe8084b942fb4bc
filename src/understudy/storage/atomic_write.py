"""Writing a file so that at every moment, whatever is killed, it is the old one or the new one, whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from understudy.errors import FileError

try:
    import fcntl
except (
    ImportError
):  # pragma: no cover - Windows has no advisory locks on folders; there, one writer at a time
    fcntl = None  # type: ignore[assignment]

UNFINISHED = ".unfinished"
"""How the names of files end that are being written; their names begin with a dot."""


def write_atomically(path: Path | str, data: bytes) -> None:
    """Put `data` at `path`: a temporary file beside it, synced, then renamed over it."""
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
    """Make what was renamed or created in a folder outlast a power cut."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def lock_folder(folder: Path | str) -> Iterator[None]:
    """Keep other processes from writing in a folder; what a killed one left unfinished is removed."""
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
    """Errors of the operating system inside become a FileError of this path."""
    try:
        yield
    except OSError as error:
        named = str(error.filename or path)  # an unfinished file is ours, and nobody asked for it
        raise FileError(
            path=path if named.endswith(UNFINISHED) else named,
            place="",
            problem=f"{doing} failed: {error.strerror or error}",
            remedy=remedy,
        ) from error
