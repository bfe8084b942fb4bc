"""Writing of an export into its folder, which holds a whole export at every moment, and nothing else."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path

from understudy.errors import FileError
from understudy.export.manifest import FORMAT, MANIFEST
from understudy.storage.atomic_write import UNFINISHED, convert_os_errors, sync_folder


def write_export(folder: Path | str, files: Mapping[str, bytes]) -> None:
    """Write the files of an export to a folder that is empty, does not exist, or holds only an earlier export.

    Anything else is refused with FileError, and nothing is changed. The files are written to a folder beside it,
    which then takes its place.
    """
    folder = Path(folder)
    check_export_folder(folder)
    with convert_os_errors(folder, "writing the export"):
        folder.parent.mkdir(parents=True, exist_ok=True)
        place = folder.resolve()
        made = place.with_name(f".{place.name}.{os.getpid()}{UNFINISHED}")
        former = place.with_name(f".{place.name}.{os.getpid()}.former{UNFINISHED}")
        try:
            for name, content in files.items():
                path = made / name
                path.parent.mkdir(parents=True, exist_ok=True)
                with path.open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
            if place.exists():
                place.rename(former)
            try:
                made.rename(place)
            except OSError:
                if former.exists():
                    former.rename(place)
                raise
            sync_folder(place.parent)
        finally:
            for left in (made, former):
                shutil.rmtree(left, ignore_errors=True)


def check_export_folder(folder: Path | str) -> None:
    """Refuse a folder that holds something else than an export, with FileError."""
    folder = Path(folder)
    with convert_os_errors(folder, "reading the folder of the export"):
        if not folder.exists():
            return
        if not folder.is_dir():
            raise FileError(path=folder, place="", problem="it is not a folder", remedy="name a new folder")
        if Path.cwd().is_relative_to(folder.resolve()):
            problem, remedy = "it is the working folder, which cannot be replaced", "name a folder inside it"
            raise FileError(path=folder, place="", problem=problem, remedy=remedy)
        there = {
            path.relative_to(folder).as_posix()
            for path in folder.rglob("*")
            if path.is_symlink() or not path.is_dir()
        }
    if not there:
        return
    known = _list_files(folder)
    folders = tuple(each for each in known if each.endswith("/"))
    others = sorted(each for each in there - known if not each.startswith(folders))
    if others:
        raise FileError(
            path=folder,
            place="",
            problem=f"{others[0]} is there, which is not of an export",
            remedy="name a new folder, or move what you want to keep",
        )


def _list_files(folder: Path) -> set[str]:
    """List the files of the export in a folder by its manifest, and what its Makefile makes of them."""
    try:
        manifest = json.loads((folder / MANIFEST).read_bytes())
        if manifest["format"] != FORMAT:
            return set()
        return {MANIFEST, *map(str, manifest["files"]), *map(str, manifest.get("makes", ()))}
    except (OSError, ValueError, LookupError, TypeError):
        return set()
