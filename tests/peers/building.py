"""Peers that nobody here wrote the middleware of: compiled once, from the sources beside this file."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
PACKAGES = "apt-get install --no-install-recommends g++ libfastrtps-dev cyclonedds-dev cyclonedds-tools"
"""What a Debian system needs for all of them."""


@cache
def missing() -> str:
    """Why peers cannot be built here; empty where they can be."""
    for program in ("g++", "gcc", "idlc"):
        if shutil.which(program) is None:
            return f"needs {program}: {PACKAGES}"
    for language, header in (("c++", "fastdds/dds/domain/DomainParticipant.hpp"), ("c", "dds/dds.h")):
        include = f"#include <{header}>\n".encode()
        command = ["gcc", "-fsyntax-only", "-x", language, "-"]
        if subprocess.run(command, input=include, capture_output=True, check=False).returncode:
            return f"needs {header}: {PACKAGES}"
    return ""


def fast_dds(folder: Path, program: str = "peer") -> Path:
    """A program on Fast DDS, built in a folder: the peer, or `raw`, which publishes any bytes."""
    source = HERE / "fastdds" / f"{program}.cpp"
    strict = ["g++", "-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror"]

    def build(target: Path, _: Path) -> None:
        _run([*strict, str(source), "-o", str(target), "-lfastrtps", "-lfastcdr"])

    return _once(folder, f"fast_dds-{program}", [source, HERE / "fastdds" / "messages.hpp"], build)


def cyclone(folder: Path, *options: str) -> Path:
    """The peer on Cyclone DDS, as a program in a folder; with `-t` it tells nobody what its types are made of."""
    sources = [HERE / "cyclone" / name for name in ("peer.c", "messages.idl")]

    def build(target: Path, scratch: Path) -> None:
        _run(["idlc", *options, "-o", str(scratch), str(sources[1])])
        strict = ["gcc", "-O1", "-Wall", "-Wextra", "-Werror", f"-I{scratch}"]
        _run([*strict, str(sources[0]), str(scratch / "messages.c"), "-o", str(target), "-lddsc"])

    return _once(folder, "-".join(("cyclone", *options)), sources, build)


def _once(folder: Path, name: str, sources: Sequence[Path], build: Callable[[Path, Path], None]) -> Path:
    """What was built of just these sources before, or is now; several may do so at once."""
    content = hashlib.sha256(b"".join(source.read_bytes() for source in (*sources, Path(__file__))))
    target = folder / f"{name}-{content.hexdigest()[:16]}"
    if not target.exists():
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            made = Path(scratch) / name
            build(made, Path(scratch))
            made.replace(target)
    return target


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, check=True)
