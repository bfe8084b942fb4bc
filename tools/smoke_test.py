"""Install the wheel and the sdist of a folder into empty environments, and try each as a new user would.

    python tools/smoke_test.py dist

The demo is run, the studio must answer with its page, and an extra that is missing must be named with the command that
installs it. The wheel must hold no tests, and no file above 1 MB but the studio's page.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import venv
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.request import urlopen

ROOT = Path(__file__).parents[1]
LARGEST = 1_000_000


def check_contents(wheel: Path) -> None:
    """Refuse tests in the wheel, and large files but the page's."""
    with zipfile.ZipFile(wheel) as archive:
        for info in archive.infolist():
            if "tests/" in info.filename or info.filename.endswith((".pyc", ".nbi", ".nbc")):
                sys.exit(f"{wheel.name} holds {info.filename}")
            if info.file_size > LARGEST and "/static/" not in info.filename:
                sys.exit(f"{wheel.name} holds {info.filename}, {info.file_size / 1e6:.1f} MB")


def holds_kernels(distribution: Path) -> bool:
    """Return whether a distribution carries compiled kernels."""
    if distribution.suffix != ".whl":
        return False
    with zipfile.ZipFile(distribution) as archive:
        return any(name.endswith(".kernel") for name in archive.namelist())


def install(distribution: Path, folder: Path) -> Path:
    """Make an environment with only a distribution and what it requires; return its folder of programs."""
    venv.create(folder, with_pip=True)
    programs = folder / "bin"
    pip = [str(programs / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "--require-hashes", "-r", str(ROOT / "requirements.lock")], check=True)
    subprocess.run([*pip, "--no-deps", "--no-build-isolation", str(distribution)], check=True)
    return programs


def try_commands(programs: Path, folder: Path) -> None:
    """Run the demo, and ask for something whose extra is not installed."""
    understudy = str(programs / "understudy")
    subprocess.run([understudy, "--version"], check=True, cwd=folder)
    done = subprocess.run(
        [understudy, "demo", "--json"], check=True, cwd=folder, capture_output=True, text=True
    )
    json.loads(done.stdout)
    missing = subprocess.run(
        [understudy, "run", "forage", "--behavior", "forward", "--trace", "run.parquet"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if missing.returncode != 2 or "pip install 'understudy-robots[parquet]'" not in missing.stderr:
        sys.exit(f"a missing extra is not named: {missing.stderr}")


def try_studio(programs: Path, folder: Path) -> None:
    """Start the studio, and fetch its page."""
    command = [str(programs / "understudy"), "studio", "--no-browser", "--library", "library"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as studio:
        try:
            for line in studio.stdout or ():
                found = re.search(r"http://\S+", line)
                if found:
                    with urlopen(found[0], timeout=60) as answer:
                        if b"<title>" not in answer.read():
                            sys.exit("the studio answers without its page")
                    return
            sys.exit("the studio said no address")
        finally:
            studio.terminate()


def main(folder: Path) -> None:
    """Try every distribution of a folder."""
    for distribution in sorted([*folder.glob("*.whl"), *folder.glob("*.tar.gz")]):
        if distribution.suffix == ".whl":
            check_contents(distribution)
        with TemporaryDirectory() as scratch:
            kernels = Path(scratch) / "kernels"
            os.environ["UNDERSTUDY_KERNEL_CACHE"] = str(kernels)
            programs = install(distribution.resolve(), Path(scratch) / "environment")
            try_commands(programs, Path(scratch))
            try_studio(programs, Path(scratch))
            compiled = sorted(kernels.glob("*.kernel"))
            if compiled and holds_kernels(distribution):
                sys.exit(f"{distribution.name} holds kernels, but {len(compiled)} were compiled")
        sys.stdout.write(f"{distribution.name}: installed, demo, studio and messages are fine\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
