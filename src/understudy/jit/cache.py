"""Files of compiled kernels: one for each kernel and types of its arguments, named by a hash of all it depends on."""

import logging
import os
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import time

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

SETTING = "UNDERSTUDY_KERNEL_CACHE"
KERNELS = (
    "**/kernels/*.py",
    "**/_*kernels.py",
    "sim/sensing/sectors.py",
    "jit/decorators.py",
    "jit/intrinsics.py",
    "jit/linked.py",
)
"""The patterns of files with kernels, and of those that define the records in which kernels keep their data."""
SHIPPED = Path(__file__).parents[1] / "compiled"
"""The folder of kernels that were compiled when the package was built."""
SUFFIX = ".kernel"
HALF_WRITTEN_S = 3600.0
MOST_BYTES = 400_000_000
"""The size beyond which the kernels that were not used for longest are deleted."""


@cache
def hash_kernel_sources() -> str:
    """Hash the sources of all kernels, and of the records that they use."""
    here = Path(__file__).parents[1]
    files = sorted({file for pattern in KERNELS for file in here.glob(pattern)})
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def find_cache_folder() -> Path:
    """Find the folder for compiled kernels: UNDERSTUDY_KERNEL_CACHE, or the user's cache folder, or a temporary one."""
    named = os.environ.get(SETTING)
    if named:
        return Path(named)
    for folder in _at_home():
        if _is_writable(folder):
            return folder / "understudy" / "kernels"
    return _make_temporary()


def read_kernel(key: str) -> bytes | None:
    """Return the content of the file with this key, or None if there is no complete file."""
    for folder in (find_cache_folder(), SHIPPED):
        path = folder / (key + SUFFIX)
        try:
            content = path.read_bytes()
        except OSError:
            continue
        if sha256(content[32:]).digest() == content[:32]:
            _mark_used(path)
            return zlib.decompress(content[32:])
    return None


def write_kernel(key: str, data: bytes) -> None:
    """Write a file atomically; warn once if that is impossible."""
    packed = zlib.compress(data, 1)
    try:
        folder = find_cache_folder()
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".", delete=False) as file:
            try:
                file.write(sha256(packed).digest() + packed)
                file.close()
                Path(file.name).replace(folder / (key + SUFFIX))
            except BaseException:
                Path(file.name).unlink()
                raise
        _delete_unused(folder)
    except OSError as error:
        _warn(f"{error.strerror}: {error.filename}")


@contextmanager
def lock_kernel(key: str) -> Iterator[None]:
    """Hold the lock of a file, so that another process waits for a kernel instead of compiling it, too.

    The system releases the lock when the process ends. Where there are no locks, nothing waits.
    """
    with ExitStack() as opened:
        if fcntl is not None:
            with suppress(OSError):
                folder = find_cache_folder()
                folder.mkdir(parents=True, exist_ok=True, mode=0o700)
                path = folder / f".{key}.lock"
                file = opened.enter_context(path.open("wb"))
                fcntl.flock(file, fcntl.LOCK_EX)
                opened.callback(path.unlink, missing_ok=True)
        yield


@cache
def _warn(problem: str) -> None:
    """Warn that compiled kernels are not kept."""
    logging.getLogger(__name__).warning(
        "Compiled kernels are not kept (%s); set %s to a folder that can be written to", problem, SETTING
    )


def _mark_used(path: Path) -> None:
    """Renew the time of a file, by which files are deleted."""
    with suppress(OSError):
        os.utime(path)


def _delete_unused(folder: Path) -> None:
    """Delete the kernels that were not used for longest, and unfinished files of processes that have ended."""
    entries, total, now = [], 0, time()
    for path in folder.iterdir():
        try:
            status = path.stat()
            if path.suffix == SUFFIX:
                entries.append((status.st_mtime, status.st_size, path))
                total += status.st_size
            elif path.name.startswith(".") and now - status.st_mtime > HALF_WRITTEN_S:
                path.unlink()
        except OSError:  # another process deleted it
            continue
    for _, size, path in sorted(entries):
        if total <= MOST_BYTES:
            break
        path.unlink(missing_ok=True)
        total -= size


def _at_home() -> tuple[Path, ...]:
    """Return the user's folder for caches, if any."""
    try:
        home = Path.home()
    except RuntimeError:  # this user has no home folder
        return ()
    if sys.platform == "darwin":
        return (home / "Library" / "Caches",)
    if sys.platform == "win32":
        return (Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local"),)
    return (Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache"),)


def _is_writable(folder: Path) -> bool:
    """Return whether a folder, or the nearest existing folder above it, can be written to."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return os.access(folder, os.W_OK)


@cache
def _make_temporary() -> Path:
    """Make a folder that only this user can write to, because compiled code of others must never be run."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"understudy-kernels-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        if status.st_mode & 0o077 == 0 and status.st_uid == user and not folder.is_symlink():
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="understudy-kernels-"))
