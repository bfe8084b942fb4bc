"""Export a library as a zip file, and import the automata of an uploaded zip.

Limits apply to the actual content of a zip, whatever its headers claim. Nothing is written while it is read.
"""

from __future__ import annotations

from asyncio import wrap_future
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from secrets import compare_digest
from typing import Literal, TypeAlias, get_args
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile, ZipInfo
from zlib import error as ZlibError

from understudy.errors import FileError, SessionError, UnderstudyError
from understudy.learning.fit import learn
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.document import (
    check_apart,
    check_documents,
    decode_document,
    encode_document,
    parse_document,
)
from understudy.storage.library_folder import list_documents, make_file_stem, save_automaton
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.file_requests import FileReply, FileRequest, RequestRefused, answer_json
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.library import LibraryView

MOST_PACKED = 16 * 2**20
"""The greatest size of an uploaded zip, in bytes."""
MOST_UNPACKED = 64 * 2**20
"""The greatest total size of the files in a zip, in bytes."""
MOST_DOCUMENT = 16 * 2**20
"""The greatest size of one document in a zip, in bytes."""
MOST_FILES = 1_000
UNCHANGED = "nothing was changed"
_UNUSABLE = (BadZipFile, EOFError, NotImplementedError, OSError, RuntimeError, ValueError, ZlibError)
"""What reading a zip raises where it is cut, broken, encrypted or packed in another way."""
PATH = "/library.zip"
HEADERS = {"Content-Disposition": 'attachment; filename="library.zip"'}


def zip_library(folder: Path) -> bytes:
    """Return a zip of the documents of a library's folder, without former versions, journals and trash."""
    buffer = BytesIO()
    with convert_os_errors(folder, "packing the library"), ZipFile(buffer, "w", ZIP_DEFLATED) as archive:
        for path in list_documents(folder) if folder.exists() else ():
            if path.is_file():
                archive.writestr(path.name, path.read_bytes())
    return buffer.getvalue()


Check = Callable[[Sequence[tuple[str, bytes]]], None]
"""A function that raises FileError for the first invalid document of some, each after its name."""


def unzip_library(data: bytes, kit: Kit, check: Check = check_apart) -> Library:
    """Return the automata in a zip; FileError for the first file in it that is no document of this kit."""
    library = Library(kit)
    left = MOST_UNPACKED
    try:
        with ZipFile(BytesIO(data)) as archive:
            members = archive.infolist()
            if not 0 < len(members) <= MOST_FILES:
                problem = "it is empty" if not members else f"it has more than {MOST_FILES} files"
                raise _wrong("the zip", problem, "give one with the documents of a library")
            contents: list[tuple[str, bytes]] = []
            for member in members:
                _check_name(member)
                contents.append((member.filename, _read(archive, member, left)))
                left -= len(contents[-1][1])
    except _UNUSABLE as error:
        problem = f"it cannot be read as a zip: {str(error) or type(error).__name__}"
        raise _wrong("the zip", problem, "give one that is whole and not encrypted") from error
    try:
        check([(f"{file} in the zip", content) for file, content in contents])
    except FileError as error:
        raise FileError(
            path=error.path, place=error.place, problem=error.problem, remedy=f"{error.remedy}; {UNCHANGED}"
        ) from error
    for file, content in contents:
        library = _joined(library, file, content)
    return library


def _check_name(member: ZipInfo) -> None:
    name = member.filename
    plain = not any(character in "/\\:\0" for character in name)
    if not plain or not name.endswith(".json") or name.startswith(".") or not name.isprintable():
        place = f"{name[:100]!r} in the zip"
        problem = "it is not the plain name of a document"
        raise _wrong(place, problem, "put documents into the zip, and no folders")


def _read(archive: ZipFile, member: ZipInfo, most: int) -> bytes:
    """Return the content of a file in the zip; FileError if it is too long."""
    with archive.open(member) as file:
        content = file.read(min(most, MOST_DOCUMENT) + 1)
    if len(content) > MOST_DOCUMENT:
        where, problem = f"{member.filename} in the zip", f"it is longer than {MOST_DOCUMENT // 2**20} MB"
        raise _wrong(where, problem, "leave it out")
    if len(content) > most:
        problem = f"it holds more than {MOST_UNPACKED // 2**20} MB"
        raise _wrong("the zip", problem, "give several smaller ones")
    return content


def _joined(library: Library, file: str, content: bytes) -> Library:
    place = f"{file} in the zip"
    lesson = parse_document(content, path=place, checked=True)[0].lesson
    if lesson is not None:  # its columns are packed once more
        columns = 1 + len(lesson.record.readings)
        if 8 * lesson.record.moments * columns > MOST_UNPACKED:
            raise _wrong(place, f"its record is longer than {MOST_UNPACKED // 2**20} MB", "leave it out")
    taught = decode_document(content, library.kit, path=place, learn=learn, checked=True).taught
    name = taught.automaton.name
    if file != f"{make_file_stem(name)}.json":
        raise _wrong(place, f"it contains automaton {name!r}", f"call it {make_file_stem(name)}.json")
    if name in library.taught:
        raise _wrong(place, "it occurs twice in the zip", "leave one of them out")
    try:
        return library.with_automaton(taught)
    except UnderstudyError as error:
        raise _wrong(place, str(error), "leave it out") from error


def _wrong(where: str, problem: str, remedy: str) -> FileError:
    return FileError(path=where, place="", problem=problem, remedy=f"{remedy}; {UNCHANGED}")


Taken: TypeAlias = Literal["refuse", "replace", "keep"]
"""How to treat automata of which the library has a different one: refuse, replace, or keep the library's."""


class NameTaken(SessionError, json_type="AlreadyThere"):
    """The library already has different automata with these names."""

    def __init__(self, names: list[str]) -> None:
        self.names = names
        super().__init__(f"the library already has a different {', '.join(names)}: replace it, or leave it")


async def transfer_library(studio: StudioServer, request: FileRequest) -> FileReply:
    """Export the library, or import the zip that a request sends.

    The query has `key`, that of the page in control, and `conflicts`: how to treat automata that are there already.
    """
    if request.sends:
        return await _import_zip(studio, request)
    folder = studio.host.library_view.folder
    content = await wrap_future(studio.host.beside.at_once.submit(zip_library, folder))
    return FileReply(content, "application/zip", headers=HEADERS)


async def _import_zip(studio: StudioServer, request: FileRequest) -> FileReply:
    taken = request.find("conflicts", "refuse")
    if taken not in get_args(Taken):
        raise RequestRefused(400, f"taken is {taken[:20]!r}: give one of {', '.join(get_args(Taken))}")
    _refuse_others(studio, request)
    problem = f"the zip is larger than {MOST_PACKED // 2**20} MB: give several smaller ones"
    content = await request.read(MOST_PACKED, problem)
    beside = studio.host.beside
    check = check_apart if beside.has_processes else check_documents
    library = await wrap_future(beside.at_once.submit(unzip_library, content, studio.host.kit, check))
    _refuse_others(studio, request)  # it took a while
    try:
        sentence = import_automata(studio.host, library, taken)
    except NameTaken as error:
        raise RequestRefused(409, str(error), conflicts=error.names) from None
    studio.show()
    return answer_json({"message": sentence})


def _refuse_others(studio: StudioServer, request: FileRequest) -> None:
    director = studio.viewers.director
    if director is None or not compare_digest(director.key.encode(), request.find("key").encode()):
        problem = "this page is not in control: only the page in control may import a library"
        raise RequestRefused(403, problem)


def import_automata(host: SessionHost, imported: Library, taken: str) -> str:
    """Save all automata into the library, or none, and return a sentence about the result."""
    host.refresh_library()
    here = host.library_view
    different = [name for name, taught in imported.taught.items() if _taken(here, taught)]
    if different and taken == "refuse":
        raise NameTaken(different)
    trainer = host.trainer
    if trainer is not None and trainer.name in different and taken == "replace":
        raise SessionError(f"{trainer.name} is being trained: open another automaton before replacing it")
    wanted = [name for name in imported.taught if taken == "replace" or name not in different]
    library = here.library
    for name in wanted:
        library = library.with_automaton(imported.taught[name])  # refuses one that would contain itself
    new = [name for name in wanted if name not in here.library.taught]
    for name in wanted:
        save_automaton(here.folder, imported.taught[name])
    host.refresh_library()
    replaced = [name for name in different if name in wanted]
    sentence = f"Imported {', '.join(new)}" if new else "The zip contains nothing new"
    sentence += f"; replaced {', '.join(replaced)}, former versions are kept" if replaced else ""
    host.status = StatusMessage(sentence, "recorded")
    return sentence


def _taken(library_view: LibraryView, taught: TrainedAutomaton) -> bool:
    """Return whether the library has a different automaton of this name; SessionError for a similar name."""
    name = taught.automaton.name
    if name in library_view.library.taught or name in library_view.problems:
        path = library_view.folder / f"{make_file_stem(name)}.json"
        with convert_os_errors(path, "reading"):
            return path.read_bytes() != encode_document(taught)
    library_view.refuse_taken(name, remedy="rename one of the two")
    return False
