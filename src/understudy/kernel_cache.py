"""Choice of a folder for compiled kernels, which exists even in a read-only install without a home folder."""

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
"""The patterns of files with kernels, and of those that define the records in which kernels keep their data."""
MODE = "UNDERSTUDY_KERNELS"
COMPILED, CHECKED, PYTHON = "compiled", "checked", "python"
"""The modes in which kernels run: compiled; compiled with bounds checks; as plain Python.

Checked kernels raise IndexError for an index beyond an array's end. Plain Python also refuses an index below 0, which
the others count from the array's end.
"""


PARTS = "UNDERSTUDY_KERNEL_PARTS"
OWN_PARTS, ALL_PARTS = "own", "all"
"""The parts of kernels that are compiled for a world: those that it uses; or all, once for all worlds."""


def read_kernel_mode() -> str:
    """Return the mode of kernels in this process, from the environment variable UNDERSTUDY_KERNELS; else COMPILED."""
    return _read_choice(MODE, COMPILED, CHECKED, PYTHON)


def read_kernel_parts() -> str:
    """Return the parts to compile, from the environment variable UNDERSTUDY_KERNEL_PARTS; else OWN_PARTS."""
    return _read_choice(PARTS, OWN_PARTS, ALL_PARTS)


def _read_choice(setting: str, *known: str) -> str:
    """Return the value of an environment variable, or the first of those known if it is not set."""
    chosen = os.environ.get(setting) or known[0]
    if chosen not in known:
        remedy = f"give one of {', '.join(known)}"
        raise SettingError(where="environment", setting=setting, problem=f"is {chosen!r}", remedy=remedy)
    return chosen


def choose_cache_folder() -> None:
    """Choose a folder for compiled kernels if the usual ones, beside the source and at home, cannot be written.

    Call it before Numba is first imported. A folder that the user named in NUMBA_CACHE_DIR stays.
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
    """Return whether a folder, or the nearest existing folder above it, can be written to."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return os.access(folder, os.W_OK)


def _temporary() -> Path:
    """Make a folder that only this user can write to, because compiled code of others must never be run."""
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
    """Return a folder for kernels compiled with checks, inside the named folder for kernels if there is one."""
    return str((Path(named) if named else _temporary()) / CHECKED)


def hash_kernel_sources() -> str:
    """Hash the sources of all kernels, and of the records that they use.

    Numba keeps a compiled kernel until its own file changes, and does not notice an edit of another file that has the
    kernels it calls or the records it uses. Its cache key includes the variables that a function closes over: so such
    a kernel is made in a function that is given this hash.
    """
    here = Path(__file__).parent
    files = sorted({file for pattern in KERNELS for file in here.glob(pattern)})
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


@contextmanager
def pause_garbage_collection() -> Iterator[None]:
    """Pause the garbage collector while kernels are compiled, where it takes a tenth of the time and finds nothing."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
