"""No test decides by the clock: only timed tests sleep and compare the real time, and they are few.

`tests.real_time` says what counts. A test waits for a state with `tests.waiting`, or runs in simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.real_time import (
    TESTS,
    Offence,
    find_comparisons,
    find_marks,
    find_sleeps,
    list_importers,
    list_timed,
    name_of,
    read_tests,
)

MOST_TIMED = 60
"""Test functions that may need real processes or sockets in real time, outside `tests/browser`."""
WAITS = {
    "simulated_clock.py": "bounds how long it waits for threads",
    "waiting.py": "looks at a state again and again until it is reached",
    "browser/window.py": "looks at a page again and again until a state is reached",
    "browser/jupyter.py": "bounds how long a program takes to start",
}
"""Modules by which all tests may wait for a state: they may sleep and compare the time."""
OF_TIMED_TESTS = {
    "robots/agent_scale.py": "a measurement",
    "robots/agent_trials.py": "a measurement",
    "robots/plain_zenoh.py": "a program that publishes for a while",
    "robots/rover.py": "a program that publishes at a rate",
    "robots/skill_decider.py": "a program that ticks",
    "robots/skill_servers.py": "a program that serves until it is killed",
    "robots/skill_times.py": "a measurement",
    "robots/test_lossy_links.py": "programs that send at a rate",
    "robots/test_watchdog.py": "a transport that is slow",
    "robots/test_zenoh.py": "a program that publishes at a rate",
    "robots/trial_decider.py": "a program that ticks",
    "robots/trial_robot.py": "a program that publishes at a rate",
    "robots/trials.py": "a measurement",
}
"""Modules that only timed tests use or start as processes, and why they sleep or compare the time."""
IN_BROWSER = {
    "browser/foraging.py": "without the test's clock, which pictures.py does",
    "browser/pictures.py": "draws the pictures of the documents",
    "browser/speed.py": "a measurement",
    "browser/test_soak.py": "takes hours in real time",
}
"""Programs and tests in real time with a browser, which no test of `make test-all` uses so."""


RULE_BOOKS = (Path(__file__), TESTS / "real_time.py")
"""Modules that only name others."""


def list_offenders(find: Callable[[Path], list[Offence]], *, excused: set[str]) -> dict[str, list[str]]:
    """List what all files but some do wrong, each with its lines."""
    found = {}
    for path in read_tests():
        name = path.relative_to(TESTS).as_posix()
        if path not in RULE_BOOKS and name not in excused and (offences := find(path)):
            found[name] = [f"tests/{name}:{line}: {text.splitlines()[0][:80]}" for line, text in offences]
    return found


def list_test_modules(part: Path) -> set[Path]:
    """List the modules of tests that use a module, directly or by way of modules without tests."""
    users = {user for user in list_importers(name_of(part)) if user not in RULE_BOOKS}
    tests = {user for user in users if user.name.startswith("test_")}
    return tests.union(*(list_test_modules(user) for user in users - tests))


def find_waits_for_times(path: Path) -> list[Offence]:
    lines = read_tests()[path].splitlines()
    return [(number, line.strip()) for number, line in enumerate(lines, 1) if "wait_for_timeout(" in line]


RULES: list[tuple[Callable[[Path], list[Offence]], set[str]]] = [  # finds offences, the files that may
    (find_sleeps, {*WAITS, *OF_TIMED_TESTS}),
    (find_comparisons, {*WAITS, *OF_TIMED_TESTS, *IN_BROWSER}),
    (find_marks, set()),
    (find_waits_for_times, {"browser/window.py", *IN_BROWSER}),
]


@pytest.mark.xdist_group("real time")  # tests are read once
@pytest.mark.parametrize(("find", "may"), RULES, ids=[find.__name__ for find, _ in RULES])
def test_no_test_decides_by_the_clock(find: Callable[[Path], list[Offence]], may: set[str]) -> None:
    found = list_offenders(find, excused=may)
    offences = [line for lines in found.values() for line in lines]
    assert not offences, "in tests that are not timed:\n" + "\n".join(offences)


@pytest.mark.xdist_group("real time")
def test_few_test_functions_are_timed() -> None:
    timed = {
        path.relative_to(TESTS).as_posix(): list_timed(path)
        for path in read_tests()
        if "browser" not in path.relative_to(TESTS).parts
    }
    count = sum(map(len, timed.values()))
    assert count <= MOST_TIMED, f"{count} test functions are timed:\n" + "\n".join(
        f"{name}: {', '.join(tests)}" for name, tests in timed.items() if tests
    )


@pytest.mark.xdist_group("real time")
def test_parts_of_timed_tests_are_of_no_others() -> None:
    """Test modules that use them have timed tests; what else uses them is listed, too."""
    found = []
    for part in OF_TIMED_TESTS:
        path = TESTS / part
        if not path.exists() or not (find_sleeps(path) or find_comparisons(path)):
            found.append(f"{part} neither sleeps nor compares the time; take it off the list")
            continue
        for user in list_test_modules(path):
            name = user.relative_to(TESTS).as_posix()
            if name not in OF_TIMED_TESTS and not list_timed(user):
                found.append(f"{part} is used by tests/{name}, which has no timed test")
    assert not found, "\n".join(found)


SAMPLE = """
import time
from time import monotonic as now
import pytest

def wait():
    time.sleep(1)

def rest():
    time.sleep(2)

class Team:
    def begin(self):
        self.began = now()

    def ends(self):
        return now() - self.began > 1

@pytest.mark.timed
def test_one():
    wait(); rest()

def test_other(clock):
    rest()
    until = now() + 3
    while clock() < 3: clock.sleep(1)
    assert max(0, until) > 2
    assert run(now()) > 2
    run("import time; time.sleep(4)")

pytestmark = pytest.mark.timed
"""


def test_offences_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    path = TESTS / "unwritten"
    monkeypatch.setitem(read_tests(), path, SAMPLE)
    assert find_sleeps(path) == [(10, "time.sleep(2)"), (29, "'import time; time.sleep(4)'")]
    assert find_comparisons(path) == [(17, "now() - self.began > 1"), (27, "max(0, until) > 2")]
    assert find_marks(path) == [(31, "pytest.mark.timed")]
    assert list_timed(path) == ["test_one", "test_other"]
