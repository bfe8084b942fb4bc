"""The bytes and the text of a recorded file: decompressed, in whatever encoding it has."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
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
            except (
                OSError, EOFError, ValueError, RuntimeError, lzma.LZMAError, zipfile.BadZipFile, zlib.error
            ) as error:  # fmt: skip
                problem = f"it cannot be decompressed ({error})"
                raise FileError(
                    path=path, place="", problem=problem, remedy="restore it, or decompress what is whole"
                ) from None
    return content


def refuse_pointer(path: Path | str, content: bytes) -> None:
    """Refuse a file that begins as a pointer of git-lfs does."""
    if content.startswith(POINTER):
        raise FileError(
            path=path,
            place="",
            problem="it is a pointer of git-lfs, and not the file itself",
            remedy="fetch the file: git lfs pull",
        )


@contextmanager
def open_decompressed(path: Path | str, *, remedy: str) -> Iterator[Path]:
    """Yield the path of a file, or of a temporary one with what a compressed one has; folders stay as they are."""
    path = Path(path)
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


def read_lines(path: Path | str, notes: list[str], *, remedy: str) -> list[str]:
    """Read the lines of a text, compressed or not, in UTF-8, UTF-16 or as Windows writes it; add what was guessed."""
    text = _read_text(path, notes, remedy)
    # str.splitlines would also split at marks that texts in cells may have.
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return lines[:-1] if not lines[-1] else lines


def _read_text(path: Path | str, notes: list[str], remedy: str) -> str:
    content = read_bytes(path, remedy=remedy)
    encoding = next((each for mark, each in MARKS.items() if content.startswith(mark)), "")
    if not encoding:
        head = content[:2000].rstrip(b"\0")
        even, odd = head[::2].count(0), head[1::2].count(0)
        if max(even, odd) > len(head) // 4 and min(even, odd) == 0:
            encoding = "utf-16-le" if odd else "utf-16-be"  # which has 0 as every second byte of Latin text
    if encoding.startswith(("utf-16", "utf-32")):
        return _decode(path, content, encoding, notes, remedy)
    written = content.rstrip(b"\0")
    is_holey = b"\0" in written
    if len(written) < len(content) or is_holey:
        line = content.count(b"\n", 0, content.index(0)) + 1
        notes.append(f"{path} at line {line}: bytes that were never written; left out")
        content = re.sub(rb"\0+", b"\n", written)
    try:
        return content.decode(encoding or "utf-8")
    except UnicodeDecodeError as error:
        if error.reason == "unexpected end of data":
            return _decode(path, content, encoding or "utf-8", notes, remedy)
        line = content.count(b"\n", 0, error.start) + 1
        if is_holey:
            raise FileError(path=path, place=f"line {line}", problem="it is no text", remedy=remedy) from None
        notes.append(f"{path} at line {line}: a letter is not in UTF-8; the file was read as Windows-1252")
        return content.decode("cp1252", errors="replace")


def _decode(path: Path | str, content: bytes, encoding: str, notes: list[str], remedy: str) -> str:
    """Decode a text, which may have been cut within its last letter."""
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        if error.start < len(content) - 4:
            problem = f"it is not {encoding} as it begins ({error.reason} at byte {error.start})"
            raise FileError(path=path, place="", problem=problem, remedy=remedy) from None
        notes.append(f"{path}: it ends in the middle of a letter; what comes before is used")
        return content[: error.start].decode(encoding)


def _decompress_zstd(content: bytes) -> bytes:
    try:
        import zstandard
    except ImportError:
        raise ExtraMissing(what="a file compressed with Zstandard", extra="ros2") from None
    whole = BytesIO()
    try:
        while (
            content
        ):  # there may be several frames, and a reader of streams does not tell that the last one is cut
            frame = zstandard.ZstdDecompressor().decompressobj()
            whole.write(frame.decompress(content))
            if not frame.eof:
                raise ValueError("it ends in the middle")
            content = frame.unused_data
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None
    return whole.getvalue()


def _extract_only_file(content: bytes) -> bytes:
    with zipfile.ZipFile(BytesIO(content)) as archive:
        names = [each for each in archive.namelist() if not each.endswith("/") and "__MACOSX" not in each]
        if len(names) != 1:
            raise ValueError(f"it has {len(names)} files, and one is expected; unpack it")
        return archive.read(names[0])


DECOMPRESSORS: Mapping[bytes, Callable[[bytes], bytes]] = {
    b"\x1f\x8b": gzip.decompress,
    b"BZh": bz2.decompress,
    b"\xfd7zXZ\0": lzma.decompress,
    b"\x28\xb5\x2f\xfd": _decompress_zstd,
    b"PK\x03\x04": _extract_only_file,
}
"""The function that decompresses a file, by how it begins."""
MARKS: Mapping[bytes, str] = {
    b"\xef\xbb\xbf": "utf-8-sig",
    b"\xff\xfe\0\0": "utf-32",
    b"\xff\xfe": "utf-16",
    b"\xfe\xff": "utf-16",
}
"""The encoding of a text, by how its file begins."""
