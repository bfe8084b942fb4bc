"""The foreign programs that exports run in: what each needs to be installed, and how it is started.

Versions that the repository pins are part of what a recorded answer stands for; compilers and emulators are those of
the system.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[2]
NODE_MODULES = ROOT / "build" / "node_peers" / "node_modules"
NODE_PINS = ROOT / "tools" / "node_peers" / "package.json"
BTCPP = ROOT / "build" / "behaviortree_cpp"
BUILD = "make -f tools/export_peers.mk"
MICROPYTHON = "@micropython/micropython-webassembly-pyscript"
SCION, XSTATE = "@scion-scxml/scxml", "xstate"
COMPILED_FOR_QT = TemporaryDirectory(prefix="understudy-qt-")
"""A folder of the program that runs statecharts in Qt, by the hash of its source, once it is compiled."""


@dataclass(frozen=True, slots=True)
class Peer:
    """A foreign program that exports run in.

    `words` follow `make` where no other command is given. `find_missing` says what must be installed for it, or
    nothing. `version` is its version where the repository pins it. `prepare` is called with the folder of an export
    before the peer runs there.
    """

    words: tuple[str, ...]
    find_missing: Callable[[], str]
    version: str = ""
    prepare: Callable[[Path], None] = lambda _: None


def _programs(packages: str, *programs: str) -> Callable[[], str]:
    """Say which programs are missing, and the packages of Debian that have them."""

    def find() -> str:
        missing = [program for program in programs if shutil.which(program) is None]
        return f"needs {', '.join(missing)}: apt-get install {packages}" if missing else ""

    return find


def _read_node_pin(name: str) -> str:
    return str(json.loads(NODE_PINS.read_text())["dependencies"][name])


def _node_package(name: str) -> Callable[[], str]:
    """Say whether Node, or the pinned version of a package, is missing."""

    def find() -> str:
        installed = NODE_MODULES / name / "package.json"
        if shutil.which("node") is None:
            return "needs node: apt-get install nodejs"
        if not installed.exists() or json.loads(installed.read_text())["version"] != _read_node_pin(name):
            return f"needs {name}@{_read_node_pin(name)}: {BUILD} node"
        return ""

    return find


def _read_behaviortreepy_pin() -> str:
    found = re.search(r'"(behaviortreepy==[^;"]+)', (ROOT / "pyproject.toml").read_text())
    assert found is not None
    return found[1].strip()


def _behaviortreepy() -> str:
    pin = _read_behaviortreepy_pin()
    try:
        return "" if version("behaviortreepy") == pin.partition("==")[2] else f"needs {pin}"
    except PackageNotFoundError:  # there is no wheel for Python 3.14
        return f"needs {pin}"


def _behaviortree_cpp() -> str:
    missing = _programs("g++", "g++")()
    if not missing and not (BTCPP / "lib" / "libbehaviortree_cpp.so").exists():
        return f"needs BehaviorTree.CPP: {BUILD} behaviortree_cpp"
    return missing


def _qt() -> str:
    packages = "g++ pkg-config qt6-scxml-dev libqt6scxml6-bin"
    missing = _programs(packages, "g++", "pkg-config")()
    if not missing and subprocess.run(["pkg-config", "--exists", "Qt6Scxml"], check=False).returncode:
        return f"needs Qt6Scxml: apt-get install {packages}"
    return missing


def _link_node_modules(folder: Path) -> None:
    (folder / "node_modules").symlink_to(NODE_MODULES)


def _put_program_for_qt(folder: Path) -> None:
    """Put the program that runs statecharts into a folder: it is the same for all of them, and compiled once.

    It is copied by another process. One that this process wrote cannot be run ("Text file busy") while a process that
    another thread has just started, such as one that compiles kernels, still has it open.
    """
    program, source = folder / "conformance-qt", (folder / "conformance.cpp").read_bytes()
    kept = Path(COMPILED_FOR_QT.name) / sha256(source).hexdigest()
    if kept.exists():
        subprocess.run(["cp", kept, program], check=True)
        return
    subprocess.run(["make", program.name], cwd=folder, check=True, capture_output=True)
    subprocess.run(["cp", program, kept], check=True)


_ARM = ("gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm", "arm-none-eabi-gcc", "qemu-system-arm")
_AVR = ("gcc-avr avr-libc simavr", "avr-gcc", "simavr")


@cache
def list_peers() -> dict[str, Peer]:
    """List the peers by name."""
    return {
        "gcc": Peer(("test", "CC=gcc"), _programs("gcc", "gcc")),
        "g++": Peer((), _programs("gcc g++", "gcc", "g++")),
        "clang": Peer(("test", "CC=clang"), _programs("clang", "clang")),
        "sanitizers": Peer(("sanitize", "CC=gcc"), _programs("gcc", "gcc")),
        "cortex-m3": Peer(("test-cortex-m3",), _programs(*_ARM)),
        "avr": Peer(("test-avr",), _programs(*_AVR)),
        "sizes": Peer(("sizes",), _programs(f"{_ARM[0]} {_AVR[0]}", _ARM[1], _AVR[1])),
        "node": Peer(("test",), _programs("nodejs", "node")),
        "micropython": Peer((), _node_package(MICROPYTHON), _read_node_pin(MICROPYTHON)),
        "scion": Peer(("test",), _node_package(SCION), _read_node_pin(SCION), _link_node_modules),
        "xstate": Peer(("test",), _node_package(XSTATE), _read_node_pin(XSTATE), _link_node_modules),
        "qt": Peer(("test-qt",), _qt, prepare=_put_program_for_qt),
        "behaviortreepy": Peer(("test",), _behaviortreepy, _read_behaviortreepy_pin()),
        "behaviortree-cpp": Peer(("test-cpp",), _behaviortree_cpp, _read_behaviortreepy_pin()),
        "ros2-node": Peer((), _programs("cmake make g++", "cmake", "make", "g++")),
    }


def run_peer(
    peer: Peer, folder: Path, words: tuple[str, ...], given: str
) -> subprocess.CompletedProcess[str]:
    """Run a command in the folder of an export, with what a peer needs there; `given` is its standard input."""
    peer.prepare(folder)
    places = {"PYTHON": sys.executable, "BTCPP": str(BTCPP), "NODE_PEERS": str(NODE_MODULES)}
    return subprocess.run(
        words,
        cwd=folder,
        input=given,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **places, "PYTHONDONTWRITEBYTECODE": "1"},
    )
