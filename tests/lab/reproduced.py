"""Which tests that retrain published rows have passed with just these sources, and so need not retrain again.

`reproduced.json` has a hash for each test file: of the file, of all sources on which it depends, and of the published
rows. `python -m tests.lab.renew` brings it up to date.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import msgspec

from understudy_lab.results import EXPECTED
from understudy_lab.sources import LABORATORY, PACKAGES, describe_environment, find_sources, hash_sources

FOLDER = Path(__file__).parent
RECORD = FOLDER / "reproduced.json"
TESTS = FOLDER.parent
MARKED = "@pytest.mark.retrains"


class Reproduced(msgspec.Struct):
    """The environment in which tests retrained published rows, and the hash of the sources of each test file then."""

    environment: str
    sources: Mapping[str, str]


@cache
def read_record() -> Reproduced:
    """What was reproduced last."""
    return msgspec.json.decode(RECORD.read_bytes(), type=Reproduced)


def write_record(hashes: Mapping[str, str]) -> None:
    """Record hashes of test files; those of another environment are forgotten, and those of files that are gone."""
    known = read_record()
    kept = known.sources if known.environment == describe_environment() else {}
    sources = {name: hashed for name, hashed in {**kept, **hashes}.items() if (FOLDER / name).is_file()}
    record = Reproduced(describe_environment(), dict(sorted(sources.items())))
    RECORD.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=1) + b"\n")
    read_record.cache_clear()


def is_reproduced(file: Path) -> bool:
    """Whether the retraining tests of a file have passed with the present sources in this environment."""
    known = read_record()
    name = file.name
    return known.environment == describe_environment() and known.sources.get(name) == hash_test(file)


@cache
def hash_test(file: Path) -> str:
    """Hash a test file, all sources on which it depends, and the published rows of the studies among these."""
    sources = find_test_sources(file)
    folders = {path.parent for path in sources if path.is_relative_to(LABORATORY)}
    published = {path for folder in folders for name in EXPECTED if (path := folder / name).is_file()}
    return hash_sources(sources | published)


def find_test_sources(file: Path) -> set[Path]:
    """All files on which a test file depends, itself included."""
    return find_sources([file], [*PACKAGES, TESTS])


def list_retraining_files() -> list[Path]:
    """The files of tests that retrain published rows."""
    return [path for path in sorted(FOLDER.glob("test_*.py")) if MARKED in path.read_text(encoding="utf-8")]
