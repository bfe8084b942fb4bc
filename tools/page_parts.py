"""Fetch what the studio's page without a server is made of, by the hashes of tools/page_parts.lock.

Everything is kept in build/page-parts, so that it is fetched once. msgspec has no wheel for this Python in browsers;
its C source is compiled with clang and LLVM's linker, against the headers of any CPython of the same version and of
Emscripten's C library. Emscripten's compiler is not needed.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zipfile import ZipFile

ROOT = Path(__file__).parents[1]
LOCK = Path(__file__).with_suffix(".lock")
CACHE = ROOT / "build" / "page-parts"
SYSCONFIG = "_sysconfigdata__emscripten_wasm32-emscripten.py"
"""Where the standard library of Pyodide says what its pyconfig.h was."""
LINKERS = ("wasm-ld", *(f"wasm-ld-{version}" for version in range(22, 13, -1)))


class PartMissing(Exception):
    """A part that cannot be had here, with a sentence that says what would help."""


def read_lock() -> dict[str, dict[str, Any]]:
    """Read the lock file."""
    return tomllib.loads(LOCK.read_text())


def fetch_pyodide(lock: Mapping[str, Any]) -> Path:
    """Return the folder with the files of Pyodide that the lock names."""
    files: dict[str, str] = lock["files"]
    folder = CACHE / f"pyodide-{lock['version']}"
    if not all(_has_hash(folder / name, sha256) for name, sha256 in files.items()):
        with ZipFile(fetch_distribution(lock)) as wheel:
            folder.mkdir(parents=True, exist_ok=True)
            for name in files:
                (folder / name).write_bytes(wheel.read(f"{lock['folder']}/{name}"))
        for name, sha256 in files.items():
            if not _has_hash(folder / name, sha256):
                raise PartMissing(f"{name} of {lock['distribution']} is not what {LOCK.name} says")
    return folder


def fetch_distribution(lock: Mapping[str, Any], *options: str) -> Path:
    """Return the file of a distribution, which pip downloads if it is not there."""
    name, release, sha256 = lock["distribution"], lock["release"], str(lock["sha256"])
    if found := [path for path in CACHE.glob("*") if path.is_file() and _has_hash(path, sha256)]:
        return found[0]
    CACHE.mkdir(parents=True, exist_ok=True)
    wanted = CACHE / "wanted.txt"
    wanted.write_text(f"{name}=={release} --hash=sha256:{sha256}\n")
    command = [
        sys.executable,
        "-m",
        "pip",
        "download",
        "--quiet",
        "--no-deps",
        "--dest",
        str(CACHE),
        *options,
    ]
    done = subprocess.run(
        [*command, "--requirement", str(wanted)], capture_output=True, text=True, check=False
    )
    wanted.unlink()
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise PartMissing(f"{name} {release} cannot be fetched with pip ({last})")
    return fetch_distribution(lock)


def build_msgspec(lock: Mapping[str, Mapping[str, Any]], python: Path, pyodide: Path) -> Path:
    """Return the folder of the package msgspec for Pyodide."""
    release, abi = lock["msgspec"]["release"], lock["pyodide"]["abi"]
    built = CACHE / f"msgspec-{release}-{abi}"
    package = built / "msgspec"
    library = package / f"_core.{abi}.so"
    if library.is_file():
        return package
    source = fetch_distribution(lock["msgspec"], "--no-binary", ":all:")
    shutil.rmtree(built, ignore_errors=True)
    with tarfile.open(source) as archive:
        archive.extractall(built, filter="data")
    (found,) = built.glob("msgspec-*/src/msgspec")
    headers = _make_python_headers(python, pyodide, built / "include")
    _compile(found / "_core.c", [headers, *_find_c_headers(lock["headers"])], built / "core.so")
    shutil.copytree(found, package, ignore=shutil.ignore_patterns("*.c", "*.h", "*.pyi", "__pycache__"))
    (built / "core.so").rename(library)
    return package


def find_python(version: str) -> Path:
    """Find a CPython of a version, whose headers and compiler of bytecode are used."""
    names = [f"python{version}", sys.executable]
    if uv := shutil.which(os.environ.get("UV", "uv")):
        names.append(_ask([uv, "python", "find", version]))
    names += [str(path) for path in sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))]
    for name in filter(None, names):
        is_same = "import sys; print('.'.join(map(str, sys.version_info[:2])), sys.executable)"
        found, _, path = _ask([name, "-c", is_same]).partition(" ")
        if found == version:
            return Path(path)
    raise PartMissing(f"there is no Python {version} here, whose headers the page's Python needs: install it")


def _make_python_headers(python: Path, pyodide: Path, folder: Path) -> Path:
    """Copy the headers of a CPython, with the pyconfig.h of Pyodide."""
    include = Path(_ask([str(python), "-c", "import sysconfig; print(sysconfig.get_path('include'))"]))
    if not (include / "Python.h").is_file():
        raise PartMissing(f"Python {python.name} has no headers: install its package of development files")
    shutil.copytree(include, folder)
    with ZipFile(pyodide / "python_stdlib.zip") as library:
        variables: dict[str, Any] = {"PYODIDE_ROOT": ""}
        source = library.read(SYSCONFIG).decode()
    exec(compile(source, SYSCONFIG, "exec"), variables)
    values: dict[str, object] = variables["build_time_vars"]
    names = re.findall(r"^(?:#define|/\* #undef)\s+(\w+)", (include / "pyconfig.h").read_text(), re.MULTILINE)
    lines = [f"#define {name} {values[name]}" for name in dict.fromkeys(names) if _is_defined(name, values)]
    text = "\n".join(["#ifndef Py_PYCONFIG_H", "#define Py_PYCONFIG_H", *lines, "#endif", ""])
    (folder / "pyconfig.h").write_text(text)
    return folder


def _is_defined(name: str, values: Mapping[str, Any]) -> bool:
    """Return whether pyconfig.h defines a name; sizes also where they are 0."""
    if name == "Py_PYCONFIG_H" or name not in values:
        return False
    return name.startswith(("SIZEOF", "ALIGNOF")) or values[name] not in (0, "", "0")


def _find_c_headers(lock: Mapping[str, Any]) -> list[Path]:
    """Find the headers of Emscripten's C library: installed, or unpacked from Debian's package."""
    package, inside = str(lock["package"]), str(lock["folder"])
    for root in (Path("/"), unpack_debian(package)):
        if root is not None and (root / inside / "stdlib.h").is_file():
            return [root / inside / "compat", root / inside]
    raise PartMissing(f"there are no headers of {package}: on Debian, apt-get install {package}")


def unpack_debian(package: str) -> Path | None:
    """Unpack a package of Debian beside the system, if this is one; None if it cannot be had."""
    folder = CACHE / package
    if folder.is_dir():
        return folder
    if shutil.which("apt-get") is None or shutil.which("dpkg") is None:
        return None
    CACHE.mkdir(parents=True, exist_ok=True)
    subprocess.run(["apt-get", "download", "-qq", package], cwd=CACHE, capture_output=True, check=False)
    for archive in CACHE.glob(f"{package}_*.deb"):
        subprocess.run(["dpkg", "-x", str(archive), str(folder)], check=True)
        archive.unlink()
    return folder if folder.is_dir() else None


def _compile(source: Path, headers: Sequence[Path], target: Path) -> None:
    """Compile a C file into a library that Pyodide loads."""
    clang = next(filter(None, map(shutil.which, ("clang", "clang-14"))), None)
    if clang is None:
        raise PartMissing("there is no clang, which compiles msgspec for browsers: install clang and lld")
    version = re.search(r"version (\d+)", _ask([clang, "--version"]))
    linker = next(filter(None, map(shutil.which, LINKERS)), None)
    if linker is None and version and (unpacked := unpack_debian(f"lld-{version[1]}")):
        linker = next((str(path) for path in unpacked.glob("usr/lib/llvm-*/bin/wasm-ld")), None)
    if linker is None:
        raise PartMissing("there is no wasm-ld, which links msgspec for browsers: install lld")
    code = target.with_suffix(".o")
    include = [option for folder in headers[1:] for option in ("-isystem", str(folder))]
    subprocess.run(
        [
            clang, "--target=wasm32-unknown-emscripten", "-Os", "-w", "-fPIC", "-DNDEBUG", "-DPY_CALL_TRAMPOLINE",
            "-D__EMSCRIPTEN__", "-mbulk-memory", "-nostdlibinc", *include, "-I", str(headers[0]),
            "-fno-strict-overflow", f"-ffile-prefix-map={CACHE}=.", "-c", str(source), "-o", str(code),
        ],
        check=True,
    )  # fmt: skip
    subprocess.run(
        [
            linker, "-shared", "--experimental-pic", "--no-entry", "--allow-undefined", "--export=PyInit__core",
            "--strip-debug", "-O2", str(code), "-o", str(target),
        ],
        check=True,
    )  # fmt: skip


def _ask(command: Sequence[str]) -> str:
    """Return what a command prints; empty if it fails or is not there."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def _has_hash(path: Path, sha256: object) -> bool:
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == sha256
