"""Hand a library to all agents of a team: each checks it first, then all take it over, or none does."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath

from understudy.errors import FileError, UnderstudyError

MOST_BYTES = 50_000_000
"""The largest size of a library that an agent takes over, bytes."""
FORMER, NEXT = "former", "next"

Files = Mapping[str, bytes]
"""The documents of a library by their paths within its folder."""


def read_library_files(folder: Path | str) -> dict[str, bytes]:
    """Read the documents of a library with those of its subfolders; refuse a folder without any with a FileError."""
    folder = Path(folder)
    found = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*.json"))
        if not any(part.startswith(".") for part in path.relative_to(folder).parts)
    }
    if not found:
        raise FileError(
            path=folder, place="", problem="has no automata", remedy="name the folder of a library"
        )
    return found


class LibraryFolder:
    """An agent's folder of automata, which can be replaced as a whole.

    The former content stays beside it, in a folder whose name ends with `.former`.

    Parameters
    ----------
    folder
        The folder.
    agent
        The name of the agent, which keeps those of several agents of one computer apart.
    compute_fingerprint
        A function that opens the library in a folder and returns its fingerprint; it raises an UnderstudyError if the
        library cannot be used.
    """

    def __init__(self, folder: Path | str, agent: str, compute_fingerprint: Callable[[Path], str]) -> None:
        self.folder, self._compute = Path(folder), compute_fingerprint
        self._next = self.folder.with_name(f"{self.folder.name}.{agent}.{NEXT}")
        self._former = self.folder.with_name(f"{self.folder.name}.{FORMER}")

    def recover(self) -> None:
        """Complete a replacement that was interrupted: afterwards the folder is the new one or the former one."""
        if not self.folder.exists():
            for left in (self._next, self._former):
                if left.is_dir():
                    left.rename(self.folder)
                    break
        self.forget()

    def prepare(self, files: Files) -> str:
        """Write a new library beside the present one and check it.

        Parameters
        ----------
        files
            The documents of the new library.

        Returns
        -------
        str
            Why it cannot be used; empty if it can.
        """
        self.forget()
        if sum(map(len, files.values())) > MOST_BYTES:
            return f"is larger than {MOST_BYTES // 1_000_000} MB"
        try:
            for name, content in files.items():
                path = self._next.joinpath(*_split(name))
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            self._compute(self._next)
        except (UnderstudyError, OSError, ValueError) as error:
            self.forget()
            return str(error)
        return ""

    def switch(self) -> str:
        """Take the prepared library over; return why that is impossible, or nothing."""
        if not self._next.is_dir():
            return "has no library prepared"
        if self.folder.is_dir() and self._compute(self.folder) == self._compute(self._next):
            self.forget()  # another agent of this computer was first
            return ""
        if self.folder.exists():
            shutil.rmtree(self._former, ignore_errors=True)
            self.folder.rename(self._former)
        self._next.rename(self.folder)
        return ""

    def forget(self) -> None:
        """Remove a prepared library."""
        shutil.rmtree(self._next, ignore_errors=True)


def _split(name: str) -> tuple[str, ...]:
    """Split a path within a library; raise ValueError if it would lead out of it."""
    parts = PurePosixPath(name).parts
    if not parts or not name.endswith(".json") or any(part in ("..", "/") or ":" in part for part in parts):
        raise ValueError(f"{name!r:.80} is no path of a library's document")
    return parts
