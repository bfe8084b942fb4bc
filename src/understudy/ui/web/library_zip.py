"""Parcels: a library's documents as one zip file, and the automata of a zip that somebody gives.

A zip is judged by what is in it, never by what it says of itself; nothing of it is written while it is read.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo
from zlib import error as ZlibError

from understudy.errors import FileError, UnderstudyError
from understudy.learning.fit import learn
from understudy.model.kit import Kit
from understudy.model.library import Library
from understudy.storage.atomic import failing
from understudy.storage.document import decode, parse
from understudy.storage.filenames import stem
from understudy.storage.library_folder import documents

MOST_PACKED = 16 * 2**20
"""Bytes of a zip that is taken in."""
MOST_UNPACKED = 64 * 2**20
"""Bytes of all that is in it."""
MOST_FILES = 1_000
_UNUSABLE = (BadZipFile, EOFError, NotImplementedError, OSError, RuntimeError, ValueError, ZlibError)
"""What reading a zip raises where it is cut, broken, encrypted or packed in another way."""


def packed(folder: Path) -> bytes:
    """The documents of a library's folder; no former versions, no journals, no trash."""
    made = BytesIO()
    with failing(folder, "packing the library"), ZipFile(made, "w", ZIP_DEFLATED) as archive:
        for path in documents(folder) if folder.exists() else ():
            if path.is_file():
                archive.writestr(path.name, path.read_bytes())
    return made.getvalue()


def unpacked(data: bytes, kit: Kit) -> Library:
    """The automata in a zip; FileError for the first thing in it that is no document of this kit."""
    library = Library(kit)
    left = MOST_UNPACKED
    try:
        with ZipFile(BytesIO(data)) as archive:
            members = archive.infolist()
            if not 0 < len(members) <= MOST_FILES:
                problem = "it is empty" if not members else f"it has more than {MOST_FILES} files"
                raise _wrong("the zip", problem, "give one with the documents of a library")
            for member in members:
                _check_name(member)
                content = _read(archive, member, left)
                left -= len(content)
                library = _joined(library, member.filename, content)
    except _UNUSABLE as error:
        problem = f"it cannot be read as a zip: {str(error) or type(error).__name__}"
        raise _wrong("the zip", problem, "give one that is whole and not encrypted") from error
    return library


def _check_name(member: ZipInfo) -> None:
    name = member.filename
    plain = not any(character in "/\\:\0" for character in name)
    if not plain or not name.endswith(".json") or name.startswith(".") or not name.isprintable():
        shown = f"{name[:100]!r} in the zip"
        problem = "it is not the plain name of a document"
        raise _wrong(shown, problem, "put documents into the zip, and no folders")


def _read(archive: ZipFile, member: ZipInfo, most: int) -> bytes:
    """What a file of the zip holds, read no further than it may be long."""
    with archive.open(member) as file:
        content = file.read(most + 1)
    if len(content) > most:
        problem = f"it holds more than {MOST_UNPACKED // 2**20} MB"
        raise _wrong("the zip", problem, "give several smaller ones")
    return content


def _joined(library: Library, file: str, content: bytes) -> Library:
    shown = f"{file} in the zip"
    lesson = parse(content, path=shown)[0].lesson
    if lesson is not None:  # its columns are packed once more
        columns = 1 + len(lesson.record.readings)
        if 8 * lesson.record.moments * columns > MOST_UNPACKED:
            raise _wrong(shown, f"its record is longer than {MOST_UNPACKED // 2**20} MB", "leave it out")
    taught = decode(content, library.kit, path=shown, learn=learn).taught
    name = taught.automaton.name
    if file != f"{stem(name)}.json":
        raise _wrong(shown, f"it holds automaton {name!r}", f"call it {stem(name)}.json")
    if name in library.taught:
        raise _wrong(shown, "it is in the zip twice", "leave one of them out")
    try:
        return library.with_taught(taught)
    except UnderstudyError as error:
        raise _wrong(shown, str(error), "leave it out") from error


def _wrong(where: str, problem: str, remedy: str) -> FileError:
    return FileError(path=where, place="", problem=problem, remedy=f"{remedy}; nothing was changed")
