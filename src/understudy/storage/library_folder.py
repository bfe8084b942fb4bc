"""Libraries on disk: a folder with one document per automaton and all earlier versions of each.

    library/forage.json
    library/versions/forage/0001 2026-11-21 10.15.00.json

No document is lost or half written if a program is killed: each document is replaced as a whole, after its earlier
version has been stored.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from unicodedata import normalize
from urllib.parse import unquote

from understudy.errors import (
    DefinitionError,
    FileError,
    OtherKit,
    RecursionRefused,
    UnderstudyError,
    UnknownName,
)
from understudy.model.library import (
    Kit,
    Library,
    TrainedAutomaton,
    check_trained_automaton,
    list_dependencies,
)
from understudy.storage.atomic_write import convert_os_errors, lock_folder, sync_folder, write_atomically
from understudy.storage.document import (
    KIT,
    Learn,
    LoadedDocument,
    decode_document,
    decode_recorded_kit,
    encode_document,
)
from understudy.storage.kit_parts import join_kits

LONGEST = 150
"""The largest number of bytes of a file name without its ending; all file systems allow 255."""

_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10))}


def make_file_stem(name: str) -> str:
    """Return the file name of an automaton without its ending; refuse a name that is empty, too long or unprintable.

    Letters, digits, _, - and inner spaces stay; other characters become %XX.
    """
    written, length = "", 0
    try:
        written = "".join(map(_safe, name))
        if written != written.strip():
            written = written.replace(" ", "%20")
        if written.lower() in _DEVICES:
            written = _percent(written[0]) + written[1:]
        length = len(written.encode("utf-8"))
    except UnicodeEncodeError:
        pass
    if not 0 < length <= LONGEST or not name.isprintable():
        raise DefinitionError(
            what=f"automaton {name!r}",
            problem="no file can be called so",
            remedy=f"give it a name of 1 to {LONGEST} letters, digits and other printable characters",
        )
    return written


def _safe(character: str) -> str:
    return character if character.isalnum() or character in "_- " else _percent(character)


def _percent(character: str) -> str:
    return "".join(f"%{byte:02X}" for byte in character.encode("utf-8"))


def normalize_name(name: str) -> str:
    """Normalize the letter case and Unicode form of a name.

    Some file systems treat names that differ only in these as equal.
    """
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())


VERSIONS = "versions"
_DOCUMENT = re.compile(rb'"automaton"\s*:\s*\{')
"""What the beginning of an automaton's document has, and no other JSON file of ours."""
_BEGINNING = 4096
_VERSION = re.compile(r"(\d{4,})(?: (\d{4}-\d\d-\d\d \d\d\.\d\d\.\d\d))?\.json")


@dataclass(frozen=True, slots=True)
class LoadedLibrary:
    """The result of reading a library's folder file by file.

    `library` has the automata that could be read. `opened` has their documents by name of the automaton, and
    `problems` the errors of the other files by file name: of those that are damaged, and of automata of another kit.
    """

    folder: Path
    library: Library
    opened: dict[str, LoadedDocument]
    problems: dict[str, UnderstudyError]

    @property
    def rebuilt(self) -> dict[str, str]:
        """The reasons why transition functions were learned again, by name of the automaton."""
        return {name: each.rebuilt for name, each in self.opened.items() if each.rebuilt is not None}

    def refuse_damaged(self) -> None:
        """Raise the error of the first damaged file; or of the first left out, if all others need what is left out."""
        damaged = [each for each in self.problems.values() if not isinstance(each, OtherKit)]
        is_usable = any(map(self._is_whole, self.opened))
        for problem in damaged or ([] if is_usable else self.problems.values()):
            raise problem

    def _is_whole(self, name: str) -> bool:
        """Return whether an automaton needs none that was left out."""
        automata = [self.library.automaton(each) for each in list_dependencies(self.library, name)]
        return all(state.behavior not in self.library.left_out for each in automata for state in each.states)


@dataclass(frozen=True, slots=True)
class SavedVersion:
    """An earlier version of an automaton: number (from 1), time it was saved (UTC, None if unknown), and file."""

    number: int
    saved: datetime | None
    file: Path


def open_library(folder: Path | str, kit: Kit, learn: Learn | None = None) -> LoadedLibrary:
    """Open all automata in a library's folder.

    Parameters
    ----------
    folder
        The library's folder.
    kit
        The features, basic behaviors and targets that the automata use.
    learn
        Function that learns transition functions from a lesson, for documents whose stored ones are missing or
        outdated. None: such documents are refused.

    Returns
    -------
    LoadedLibrary
        The library in `library`, and the documents by name in `opened`. Automata of another kit are left out, each
        with its reason in `library.left_out`; whatever needs one of them is refused with it.

    Raises
    ------
    FileError
        If the folder or a file cannot be read or has invalid content; the error names the file and place. OtherKit if
        all automata are of another kit.
    RecursionRefused
        If an automaton contains itself.
    """
    loaded = open_each_automaton(folder, kit, learn)
    loaded.refuse_damaged()
    return loaded


def open_each_automaton(folder: Path | str, kit: Kit | None, learn: Learn | None = None) -> LoadedLibrary:
    """Open each file of a library separately, so that one invalid file does not hide the others.

    Without a kit, features are taken from the documents, so that any library can be viewed. To a kit, what lessons of
    recordings need is added.
    """
    if kit is not None:
        kit = join_kits([(kit, ""), *find_recorded_kits(folder)])
    library = Library(Kit.from_parts() if kit is None else kit)
    opened: dict[str, LoadedDocument] = {}
    problems: dict[str, UnderstudyError] = {}
    for path in list_documents(folder):
        try:
            document = open_document(path, kit, learn)
            library = add_automaton(library, document.taught, path)
            opened[document.taught.automaton.name] = document
        except UnderstudyError as error:
            problems[path.name] = error
    left_out = {
        unquote(Path(name).stem): str(each) for name, each in problems.items() if isinstance(each, OtherKit)
    }
    library = replace(library, left_out=MappingProxyType(left_out))
    return LoadedLibrary(Path(folder), library, opened, problems)


def find_recorded_kits(folder: Path | str) -> list[tuple[Kit, Path]]:
    """Find what lessons of a folder need that no program defines, with their files.

    A file that is invalid has none, and automata of the folder are no basic behaviors.
    """
    kits = []
    for path in list_documents(folder):
        try:
            data = path.read_bytes() if path.is_file() else b""
            if KIT in data and (kit := decode_recorded_kit(data, path=path)) is not None:
                automata = {other.stem for other in list_documents(folder)}
                behaviors = {
                    name: each for name, each in kit.behaviors.items() if make_file_stem(name) not in automata
                }
                kits.append((replace(kit, behaviors=behaviors), path))
        except (OSError, UnderstudyError):
            continue  # whoever opens the file is told what is wrong
    return kits


def list_documents(folder: Path | str) -> list[Path]:
    """List the documents in a folder by name, without those that are still being written."""
    folder = Path(folder)
    with convert_os_errors(folder, "opening the library"):
        return sorted(path for path in folder.iterdir() if path.suffix == ".json" and path.name[0] != ".")


def count_automata(folder: Path | str) -> int:
    """Count the documents of automata in a folder by how they begin; 0 if it cannot be read."""
    try:
        return sum(map(_begins_as_document, Path(folder).glob("[!.]*.json")))
    except OSError:
        return 0


def _begins_as_document(path: Path) -> bool:
    if not path.is_file():  # a pipe would be waited for without end
        return False
    with path.open("rb") as file:
        return _DOCUMENT.search(file.read(_BEGINNING)) is not None


def open_document(path: Path | str, kit: Kit | None, learn: Learn | None = None) -> LoadedDocument:
    """Open the automaton in a file of a library; refuse a file that is not named after its automaton."""
    path = Path(path)
    opened = read_document(path, kit, learn)
    name = opened.taught.automaton.name
    expected = f"{make_file_stem(name)}.json"
    if normalize("NFC", path.name) != normalize("NFC", expected):
        also = f", as {expected} beside it does" if path.with_name(expected).exists() else ""
        problem = f"it contains automaton {name!r}{also}"
        remedy = f"remove it, rename the file to {expected}, or rename the automaton in it"
        raise FileError(path=path, place="$.automaton.name", problem=problem, remedy=remedy)
    return opened


def read_document(path: Path | str, kit: Kit | None, learn: Learn | None = None) -> LoadedDocument:
    """Read the automaton in a file of any name."""
    path = Path(path)
    if path.exists() and not path.is_file():  # a pipe would be waited for without end
        raise FileError(path=path, place="", problem="it is not a file", remedy="remove it, or rename it")
    with convert_os_errors(path, "reading", remedy="see that the file exists and that you may read it"):
        data = path.read_bytes()
    return decode_document(data, kit, path=path, learn=learn)


def add_automaton(library: Library, taught: TrainedAutomaton, path: Path | str) -> Library:
    """Return the library with the automaton read from `path` added; refuse it if its name is taken."""
    name = taught.automaton.name
    for other in library.taught:
        if normalize_name(other) == normalize_name(name):
            problem = (
                f"automaton {name!r} is also called {other!r} beside it, but for case or the form of letters"
            )
            raise FileError(
                path=path, place="$.automaton.name", problem=problem, remedy="rename or remove one of the two"
            )
    try:
        return library.with_automaton(taught)
    except DefinitionError as error:
        place = "$.automaton.name"
        raise FileError(path=path, place=place, problem=error.problem, remedy=error.remedy) from error
    except RecursionRefused as error:
        raise RecursionRefused(cycle=error.cycle, path=path) from error


def save_automaton(folder: Path | str, taught: TrainedAutomaton) -> Path:
    """Save an automaton in a library's folder, and keep the former version; do nothing if nothing changed.

    When this returns, the document is on disk and survives a power cut. When it raises, the folder is unchanged.

    Parameters
    ----------
    folder
        The library's folder. It is created if it does not exist.
    taught
        The automaton with its lesson.

    Returns
    -------
    Path
        The file of the automaton.

    Raises
    ------
    DefinitionError
        If `taught` is no TrainedAutomaton or could not be read back unchanged, no file can have the automaton's
        name, or another automaton in the folder has a name that differs in case or Unicode form only.
    KindError
        If a value of an example is outside its feature's kind.
    FileError
        If the folder cannot be written to.
    """
    check_trained_automaton(taught)
    folder = Path(folder)
    path = folder / f"{make_file_stem(taught.automaton.name)}.json"
    data = encode_document(taught)
    if folder.exists() and not folder.is_dir():
        remedy = "name a folder to keep the library in"
        raise FileError(path=folder, place="", problem="it is a file, not a folder", remedy=remedy)
    with convert_os_errors(path, "saving", remedy="see that the disk has room and that you may write there"):
        folder.mkdir(parents=True, exist_ok=True)
        with lock_folder(folder):
            _refuse_alike(taught.automaton.name, path)
            former = path.read_bytes() if path.exists() else None
            if former == data:
                return path
            if former is not None:
                _keep(path, former)
            write_atomically(path, data)
    return path


def rename_automaton(folder: Path | str, former: str, taught: TrainedAutomaton) -> Path:
    """Rename an automaton's document and earlier versions; `taught` is the automaton under its new name.

    If the program is killed meanwhile, the folder contains it under both names, and each version under one of them.
    """
    check_trained_automaton(taught)
    folder = Path(folder)
    path, name = folder / f"{make_file_stem(former)}.json", make_file_stem(taught.automaton.name)
    renamed, data = folder / f"{name}.json", encode_document(taught)
    with convert_os_errors(path, "renaming"), lock_folder(folder):
        _refuse_alike(taught.automaton.name, renamed)
        if renamed.exists():
            raise DefinitionError(
                what=f"automaton {taught.automaton.name!r}",
                problem=f"{renamed.name} is there already",
                remedy="give it another name",
            )
        write_atomically(renamed, data)
        _move_versions(folder / VERSIONS / make_file_stem(former), folder / VERSIONS / name)
        path.unlink()
        sync_folder(folder)
    return renamed


def _move_versions(source: Path, target: Path) -> None:
    """Move versions to another folder, with numbers after those of the versions already there."""
    moving = _versions(source)
    if not moving:
        return
    target.mkdir(parents=True, exist_ok=True)
    there = _versions(target)
    number = there[-1].number if there else 0
    for offset, version in enumerate(moving, start=1):
        version.file.rename(target / f"{number + offset:04}{version.file.name.lstrip('0123456789')}")
    for each in (target, source, target.parent):
        sync_folder(each)


def _refuse_alike(name: str, path: Path) -> None:
    for other in path.parent.glob("*.json"):
        if other.name != path.name and normalize_name(unquote(other.stem)) == normalize_name(name):
            raise DefinitionError(
                what=f"automaton {name!r}",
                problem=f"{other.name} has that name already, but for case or the form of letters",
                remedy="give it another name",
            )


def _keep(path: Path, former: bytes) -> None:
    """Store an earlier version, unless it equals the last one stored.

    It equals the last one if a program was killed while saving.
    """
    folder = path.parent / VERSIONS / path.stem
    folder.mkdir(parents=True, exist_ok=True)
    versions = _versions(folder)
    if versions and versions[-1].file.read_bytes() == former:
        return
    saved = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    number = versions[-1].number + 1 if versions else 1
    with lock_folder(folder):
        write_atomically(folder / f"{number:04} {saved:%Y-%m-%d %H.%M.%S}.json", former)
    sync_folder(folder.parent)
    sync_folder(path.parent)


def list_versions(folder: Path | str, name: str) -> tuple[SavedVersion, ...]:
    """List the earlier versions of an automaton, oldest first, without the current one."""
    return _versions(Path(folder) / VERSIONS / make_file_stem(name))


def _versions(folder: Path) -> tuple[SavedVersion, ...]:
    if not folder.is_dir():
        return ()
    files = [(match, path) for path in folder.iterdir() if (match := _VERSION.fullmatch(path.name))]
    listed = [SavedVersion(int(match[1]), _date(match[2]), path) for match, path in files]
    return tuple(sorted(listed, key=lambda version: version.number))


def _date(text: str | None) -> datetime | None:
    try:
        return None if text is None else datetime.strptime(text, "%Y-%m-%d %H.%M.%S").replace(tzinfo=UTC)
    except ValueError:
        return None


def load_version(
    folder: Path | str, name: str, number: int, kit: Kit | None, learn: Learn | None = None
) -> LoadedDocument:
    """Load an earlier version of an automaton by its number, from 1."""
    files = {version.number: version.file for version in list_versions(folder, name)}
    if number not in files:
        where = f"automaton {name!r} in {folder}"
        raise UnknownName(what="version", name=str(number), where=where, known=[str(each) for each in files])
    return read_document(files[number], kit, learn)
