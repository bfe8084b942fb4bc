"""Writing of a new folder, which is either complete or not there."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from understudy.errors import FileError
from understudy.storage.atomic_write import UNFINISHED, check_folder_place, convert_os_errors, sync_folder

WRITING = "writing the data set"


def check_new_folder(folder: Path | str) -> None:
    """Refuse a folder that exists or that cannot be made, with FileError, before what it will hold is read."""
    folder = Path(folder)
    if folder.exists() or folder.is_symlink():
        raise FileError(path=folder, place="", problem="already exists", remedy="name a new folder")
    check_folder_place(folder, WRITING)


@contextmanager
def create_folder(folder: Path | str) -> Iterator[Path]:
    """Create a folder whose files are written inside: to a folder beside it, which is renamed at the end.

    Parameters
    ----------
    folder
        A path at which nothing exists. Missing folders around it are created.

    Yields
    ------
    Path
        The unfinished folder, to write the files to. It is removed if an exception is raised inside.

    Raises
    ------
    FileError
        If something exists at the path, or the file system refuses.
    """
    folder = Path(folder)
    check_new_folder(folder)
    with convert_os_errors(folder, WRITING):
        folder.parent.mkdir(parents=True, exist_ok=True)
        place = folder.parent.resolve() / folder.name
        unfinished = place.with_name(f".{place.name}.{os.getpid()}{UNFINISHED}")
        try:
            unfinished.mkdir()
            yield unfinished
            unfinished.rename(place)
            sync_folder(place.parent)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
