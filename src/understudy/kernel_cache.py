"""Where compiled kernels are kept: they must find a place even in a read-only install without a home."""

from __future__ import annotations

import gc
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from understudy.errors import SettingError

SETTING = "NUMBA_CACHE_DIR"
KERNELS = ("**/kernels/*.py", "**/_*kernels.py", "sim/sensing/sectors.py")
"""The files of kernels, and those that say what kernels find in memory."""
MODE = "UNDERSTUDY_KERNELS"
COMPILED, CHECKED, PYTHON = "compiled", "checked", "python"
"""How kernels run: compiled; compiled so that an index beyond an array's end raises IndexError; as plain Python.

Plain Python refuses an index below 0 too, which the others count from the array's end.
"""


def read_kernel_mode() -> str:
    """How kernels run in this process: what the environment variable UNDERSTUDY_KERNELS names, else COMPILED."""
    chosen, known = os.environ.get(MODE) or COMPILED, (COMPILED, CHECKED, PYTHON)
    if chosen not in known:
        remedy = f"give one of {', '.join(known)}"
        raise SettingError(where="environment", setting=MODE, problem=f"is {chosen!r}", remedy=remedy)
    return chosen


def choose_cache_folder() -> None:
    """Name a folder for compiled kernels where the usual ones - beside the source, then at home - cannot be written.

    To be called before Numba is first imported. A folder that the user named stays.
    """
    if SETTING in os.environ or any(map(_writable, (Path(__file__).parent, *_at_home()))):
        return
    os.environ[SETTING] = str(_temporary())


def _at_home() -> tuple[Path, ...]:
    try:
        return (Path.home() / ".cache",)
    except RuntimeError:  # nobody's home is known
        return ()


def _writable(folder: Path) -> bool:
    """Whether a folder, or the nearest above it that exists, can be written to."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return os.access(folder, os.W_OK)


def _temporary() -> Path:
    """A folder for this user alone: compiled code from somebody else's must never be run."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"understudy-kernels-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        kept = folder.lstat()
        if kept.st_mode & 0o077 == 0 and kept.st_uid == user and not folder.is_symlink():
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="understudy-kernels-"))


def make_checked_cache_path(named: str) -> str:
    """A folder for kernels compiled with checks, in the one that is named for kernels, if any."""
    return str((Path(named) if named else _temporary()) / CHECKED)


def hash_kernel_sources() -> str:
    """Hash the sources of all kernels, and of the records that they find in memory.

    Numba keeps a compiled kernel until its own file changes, and does not notice an edit in another file whose
    kernels it calls, or that says where a record has its fields. It does key what it keeps by the variables that a
    function closes over: so such a kernel is built in a function that is given this hash.
    """
    here = Path(__file__).parent
    files = sorted({file for pattern in KERNELS for file in here.glob(pattern)})
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


@contextmanager
def pause_garbage_collection() -> Iterator[None]:
    """While kernels are compiled, the garbage collector rests: it takes a tenth of the time, and finds nothing."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
