"""Retrain published rows with tests whose sources have changed, and record those that pass in `reproduced.json`.

python -m tests.lab.renew           files whose sources differ from the recorded ones
python -m tests.lab.renew --all     all files
python -m tests.lab.renew test_forage.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import msgspec
import tests.conftest
import tests.lab.conftest
from tests.lab.reproduced import (
    TESTS,
    find_test_sources,
    hash_test,
    is_reproduced,
    list_retraining_files,
    write_record,
)

from understudy_lab.sources import PACKAGES, find_sources


def main() -> int:
    """Retrain, and return how many files of tests failed."""
    files, chosen = list_retraining_files(), sys.argv[1:]
    if chosen:
        wanted = [file for file in files if "--all" in chosen or file.name in chosen]
    else:
        wanted = [file for file in files if not is_reproduced(file)]
    failed = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for file, problem in zip(wanted, pool.map(find_problem, wanted), strict=True):
            failed += problem is not None
            if problem is None:
                write_record({file.name: hash_test(file)})
            sys.stdout.write(f"{file.name}: {problem or 'reproduced'}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(wanted) - failed} of {len(wanted)} files reproduced what was published.\n")
    if len(wanted) > failed:
        sys.stdout.write(
            "Commit tests/lab/reproduced.json, so that they are not retrained until sources change.\n"
        )
    return failed


def find_problem(file: Path) -> str | None:
    """Run the retraining tests of a file by themselves; return why they do not count, or None."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "loaded.json"
        command = [
            sys.executable,
            "-m",
            "pytest",
            str(file),
            "-q",
            "-m",
            "retrains",
            "-p",
            "no:cacheprovider",
        ]
        done = subprocess.run(
            command,
            cwd=TESTS.parent,
            env={**os.environ, tests.lab.conftest.REPORT: str(report)},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            return f"failed\n{done.stdout}{done.stderr}"
        if " skipped" in done.stdout:
            return f"skipped\n{done.stdout}"
        loaded = {Path(path) for path in msgspec.json.decode(report.read_bytes(), type=list[str])}
    always = find_sources(
        [Path(str(tests.conftest.__file__)), Path(str(tests.lab.conftest.__file__))], [*PACKAGES, TESTS]
    )
    unknown = sorted(loaded - find_test_sources(file) - always)
    if unknown:
        return f"uses files that are not known as its sources: {', '.join(map(str, unknown))}"
    return None


if __name__ == "__main__":
    sys.exit(main())
