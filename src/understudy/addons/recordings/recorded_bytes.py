"""The bytes and the text of a recorded file: decompressed, in whatever encoding it has."""

from __future__ import annotations

import bz2
import gzip
import lzma
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from understudy.errors import FileError
from understudy.extras import ExtraMissing

POINTER = b"version https://git-lfs.github.com/spec/"
"""How a file begins that git-lfs put in the place of another one."""
COMPRESSED = frozenset({".gz", ".bz2", ".xz", ".zst", ".zstd", ".zip"})
"""The ends of the names of compressed files."""


def strip_compression(path: Path | str) -> Path:
    """Return the path of a file without the end that says how it is compressed: drive.csv for drive.csv.gz."""
    path = Path(path)
    return path.with_suffix("") if path.suffix.lower() in COMPRESSED else path


def read_bytes(path: Path | str, *, remedy: str) -> bytes:
    """Read a file, decompressed; FileError is raised if it cannot be read, or only a pointer of git-lfs is there."""
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        gone = isinstance(error, FileNotFoundError)
        problem = "there is no such file" if gone else f"it cannot be read ({error.strerror or error})"
        raise FileError(path=path, place="", problem=problem, remedy=remedy) from None
    refuse_pointer(path, content)
    for magic, decompress in DECOMPRESSORS.items():
        if content.startswith(magic):
            try:
                return decompress(content)
            except (OSError, EOFError, ValueError, lzma.LZMAError, zipfile.BadZipFile, zlib.error) as error:
                problem = f"it cannot be decompressed ({error})"
                raise FileError(
                    path=path, place="", problem=problem, remedy="restore it, or decompress what is whole"
                ) from None
    return content


def refuse_pointer(path: Path, content: bytes) -> None:
    """Refuse a file that begins as a pointer of git-lfs does."""
    if content.startswith(POINTER):
        raise FileError(
            path=path,
            place="",
            problem="it is a pointer of git-lfs, and not the file itself",
            remedy="fetch the file: git lfs pull",
        )


@contextmanager
def open_decompressed(path: Path, *, remedy: str) -> Iterator[Path]:
    """Yield the path of a file, or of a temporary one with what a compressed one has; folders stay as they are."""
    if path.is_dir():
        yield path
    elif path.suffix.lower() in COMPRESSED:
        with TemporaryDirectory(prefix="understudy-") as folder:
            plain = Path(folder) / strip_compression(path).name
            plain.write_bytes(read_bytes(path, remedy=remedy))
            yield plain
    else:
        if path.is_file():
            with path.open("rb") as file:
                refuse_pointer(path, file.read(len(POINTER)))
        yield path


def read_text(path: Path | str, notes: list[str], *, remedy: str) -> str:
    """Read the text of a file, compressed or not, in UTF-8, UTF-16 or as Windows writes it; add what was guessed."""
    content = read_bytes(path, remedy=remedy)
    for mark, encoding in MARKS.items():
        if content.startswith(mark):
            return _decode(path, content, encoding, remedy)
    if content[:2000].count(0) > len(content[:2000]) // 4:  # every second byte of Latin text in UTF-16
        encoding = "utf-16-le" if content[1:2] == b"\0" else "utf-16-be"
        return _decode(path, content, encoding, remedy)
    if content.endswith(b"\0"):
        notes.append(f"{path}: its end was never written; what comes before is used")
        content = content.rstrip(b"\0")
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        if b"\0" in content:
            place = f"byte {content.index(0)}"
            raise FileError(path=path, place=place, problem="it is no text", remedy=remedy) from None
        line = content.count(b"\n", 0, error.start) + 1
        notes.append(f"{path} at line {line}: a letter is not in UTF-8; the file was read as Windows-1252")
        return content.decode("cp1252", errors="replace")


def _decode(path: Path | str, content: bytes, encoding: str, remedy: str) -> str:
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        problem = f"it is not {encoding} as it begins ({error.reason} at byte {error.start})"
        raise FileError(path=path, place="", problem=problem, remedy=remedy) from None


def _decompress_zstd(content: bytes) -> bytes:
    try:
        import zstandard
    except ImportError:
        raise ExtraMissing(what="a file compressed with Zstandard", extra="ros2") from None
    try:
        with zstandard.ZstdDecompressor().stream_reader(BytesIO(content)) as reader:
            return reader.read()
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None


def _extract_only_file(content: bytes) -> bytes:
    with zipfile.ZipFile(BytesIO(content)) as archive:
        names = [each for each in archive.namelist() if not each.endswith("/") and "__MACOSX" not in each]
        if len(names) != 1:
            raise ValueError(f"it has {len(names)} files, and one is expected")
        return archive.read(names[0])


DECOMPRESSORS: Mapping[bytes, Callable[[bytes], bytes]] = {
    b"\x1f\x8b": gzip.decompress,
    b"BZh": bz2.decompress,
    b"\xfd7zXZ\0": lzma.decompress,
    b"\x28\xb5\x2f\xfd": _decompress_zstd,
    b"PK\x03\x04": _extract_only_file,
}
"""The function that decompresses a file, by how it begins."""
MARKS: Mapping[bytes, str] = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
"""The encoding of a text, by how its file begins."""
