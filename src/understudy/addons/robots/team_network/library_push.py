"""An agent's folder of automata, which a library handed to all agents of a team replaces as a whole."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from threading import Lock

from understudy.errors import FileError, UnderstudyError
from understudy.storage.atomic_write import convert_os_errors, lock_folder, sync_folder, write_atomically

MOST_BYTES = 50_000_000
"""The largest size of a library that an agent takes over, bytes."""
FORMER, NEXT = "former", "next"

Files = Mapping[str, bytes]
"""The documents of a library by their paths within its folder."""


def read_library_files(folder: Path | str) -> dict[str, bytes]:
    """Read the documents of a library with those of its subfolders; refuse a folder without any with a FileError."""
    folder = Path(folder)
    files = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*.json"))
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    }
    if not files:
        raise FileError(
            path=folder, place="", problem="has no automata", remedy="name the folder of a library"
        )
    return files


class LibraryFolder:
    """An agent's folder of automata, which can be replaced as a whole.

    The former content stays beside it, in a folder whose name ends with `.former`. Several agents of one computer may
    share the folder: the first one replaces it, and the others find it replaced.

    Parameters
    ----------
    folder
        The folder.
    agent
        The name of the agent, which distinguishes what several agents of one computer prepare.
    compute_fingerprint
        A function that opens the library in a folder and returns its fingerprint; it raises an UnderstudyError if the
        library cannot be used.
    """

    def __init__(self, folder: Path | str, agent: str, compute_fingerprint: Callable[[Path], str]) -> None:
        self.folder, self._compute = Path(folder), compute_fingerprint
        self._next = self.folder.with_name(f"{self.folder.name}.{agent}.{NEXT}")
        self._former = self.folder.with_name(f"{self.folder.name}.{FORMER}")
        self._files: dict[str, bytes] | None = None
        """The documents of the library that was prepared last; None if there is none."""
        self._can_go_back = False
        self._busy = Lock()

    def recover(self) -> None:
        """Undo a replacement that was interrupted by a kill or a power cut, and remove what was prepared.

        It was not acknowledged, so all agents go back.
        """
        if not self.folder.parent.is_dir():
            return
        with self._lock("recovering"):
            if not self.folder.exists() and self._former.is_dir():
                self._former.rename(self.folder)
        self._discard()

    def prepare(self, files: Files) -> str:
        """Write a new library beside the present one, wait until it is on disk, and check it.

        Parameters
        ----------
        files
            The documents of the new library.

        Returns
        -------
        str
            Why it cannot be used; empty if it can.
        """
        with self._busy:
            self._discard()
            if sum(map(len, files.values())) > MOST_BYTES:
                return f"is larger than {MOST_BYTES // 1_000_000} MB"
            try:
                with convert_os_errors(self._next, "writing"):
                    _write(self._next, files)
                self._compute(self._next)
                self._files = read_library_files(self._next)
            except (UnderstudyError, OSError, ValueError) as error:
                self._discard()
                return str(error)
            self._can_go_back = not self._contains(self._files)
            return ""

    def switch(self) -> str:
        """Replace the folder by the prepared library; return why that is impossible, or nothing."""
        if not self._busy.acquire(blocking=False):
            return "is still checking another library"
        try:
            if self._files is None or not self._next.is_dir():
                return "has no library prepared"
            with self._lock("replacing"):
                if not self._contains(self._files):  # otherwise another agent of this computer was first
                    self._replace()
            shutil.rmtree(self._next, ignore_errors=True)
            return ""
        except UnderstudyError as error:
            return str(error)
        finally:
            self._busy.release()

    def settle(self) -> None:
        """Keep a library that was taken over: from now on, `forget` does not go back to the former one."""
        self._can_go_back = False

    def forget(self) -> str:
        """Remove a prepared library, and go back to the former one if it was taken over and is not settled.

        Returns
        -------
        str
            Why going back is impossible; empty if the folder is the former one.
        """
        with self._busy:
            try:
                if self._files is not None and self._can_go_back:
                    with self._lock("going back"):
                        if self._contains(self._files):  # otherwise another agent of this computer was first
                            self._go_back()
            except UnderstudyError as error:
                return str(error)
            self._discard()
            return ""

    @contextmanager
    def _lock(self, doing: str) -> Iterator[None]:
        """Keep the other agents of this computer from replacing the folder; raise a FileError if that fails."""
        with convert_os_errors(self.folder, doing), lock_folder(self.folder.parent):
            yield

    def _contains(self, files: Files) -> bool:
        """Return whether the folder has exactly these documents; False if one of its documents cannot be read."""
        try:
            return read_library_files(self.folder) == files
        except (UnderstudyError, OSError):
            return False

    def _replace(self) -> None:
        # If there is no folder, an agent was killed between the renames, and the former library is the only one.
        if self.folder.exists():
            shutil.rmtree(self._former, ignore_errors=True)
            self.folder.rename(self._former)
        try:
            self._next.rename(self.folder)
        except OSError:
            if self._former.is_dir():
                self._former.rename(self.folder)
            raise
        sync_folder(self.folder.parent)

    def _go_back(self) -> None:
        shutil.rmtree(self._next, ignore_errors=True)
        self.folder.rename(self._next)
        try:
            if self._former.is_dir():  # otherwise there was no library
                self._former.rename(self.folder)
        except OSError:
            self._next.rename(self.folder)
            raise
        sync_folder(self.folder.parent)

    def _discard(self) -> None:
        self._files, self._can_go_back = None, False
        shutil.rmtree(self._next, ignore_errors=True)


def _write(folder: Path, files: Files) -> None:
    """Write documents to a new folder, and wait until they are on disk."""
    for name, content in files.items():
        path = folder.joinpath(*_split(name))
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, content)
    for each in (folder, *(path for path in folder.rglob("*") if path.is_dir())):
        sync_folder(each.parent)


def _split(name: str) -> tuple[str, ...]:
    """Split a path within a library; raise ValueError if it would lead out of it."""
    parts = PurePosixPath(name).parts
    if not parts or not name.endswith(".json") or any(part in ("..", "/") or ":" in part for part in parts):
        raise ValueError(f"{name!r:.80} is no path of a library's document")
    return parts
