"""Where compiled kernels are kept: they must find a place even in a read-only install without a home."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

SETTING = "NUMBA_CACHE_DIR"


def find_cache() -> None:
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
