"""Record what foreign programs answer to exports: python -m tests.export.record_conformance.

Answers that are recorded for just the same exports are kept, and those that no test asks for are removed. With
--list-missing nothing is asked or written: it lists what would have to be asked, and exits with 1 if there is any.
With --all every peer is asked, as after an update of a compiler.
"""

from __future__ import annotations

import argparse
import sys

import pytest
from tests.export.peers import ROOT
from tests.export.recorded_answers import ANSWERS, RECORD, Answers, name_test, read_record, write_record

HEADING = (
    "# What foreign programs answered to exports, by the hash of what they were given: test, peer, hash, outcome, "
    "answer. Written by python -m tests.export.record_conformance"
)


class AskingTests:
    """Keeps of all tests those that ask peers, and gives them the answers."""

    def __init__(self, answers: Answers) -> None:
        self.answers = answers
        self.bad: dict[str, str] = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        """Take the place of the answers that tests use otherwise."""
        config.stash[ANSWERS] = self.answers

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out the tests that ask no peer."""
        items[:] = [item for item in items if "ask" in getattr(item, "fixturenames", ())]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a test that failed or was skipped, with the reason."""
        if not report.passed:
            reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext
            self.bad[name_test(report.nodeid)] = reason.strip().splitlines()[-1]


def main() -> int:
    """Record answers, or list what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--list-missing", action="store_true", help="exit with 1 if a peer has to be asked")
    parser.add_argument("--all", action="store_true", help="ask every peer again")
    arguments = parser.parse_args()
    old = read_record(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    kept = {} if arguments.all else old
    answers = Answers(kept, is_listing=arguments.list_missing)
    tests = AskingTests(answers)
    quiet = ("-q", "--no-header", "--no-summary", "-m", "not soak", "-p", "no:cacheprovider")
    ended = pytest.main([str(ROOT / "tests" / "export"), f"--rootdir={ROOT}", *quiet], plugins=[tests])
    if arguments.list_missing:
        missing = sorted({(peer, test) for peer, test, answer in answers.asked.values() if answer is None})
        for peer, test in missing:
            say(f"{peer} has to be asked by {test}")
        say(f"{len(missing)} of {len(answers.asked)} answers are not recorded")
        return int(bool(missing or ended != pytest.ExitCode.OK))
    # An answer that a failed test got is not recorded: it is wrong, or what it was compared with is.
    good = {key: each for key, each in answers.asked.items() if key in kept or each[1] not in tests.bad}
    RECORD.write_text(write_record(good, HEADING), encoding="utf-8")
    say(f"{len(good)} answers, {len(good.keys() - old.keys())} of them new: {RECORD}")
    say(*(f"not recorded: {name}: {reason}" for name, reason in tests.bad.items()))
    return int(bool(ended != pytest.ExitCode.OK or tests.bad))


def say(*lines: str) -> None:
    """Print lines."""
    sys.stdout.write("".join(f"{line}\n" for line in lines))


if __name__ == "__main__":
    raise SystemExit(main())
