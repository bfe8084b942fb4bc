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
}
"""Modules by which all tests may wait for a state: they may sleep and compare the time."""
OF_TIMED_TESTS: dict[str, str] = {}
"""Modules that only timed tests use or start as processes, and why they sleep or compare the time."""
SLEEPING = {
    "browser/jupyter.py",
    "browser/test_notebook.py",
    "jit/test_cache.py",
    "jit/test_switch.py",
    "lab/test_parts.py",
    "peers/test_hostile_peers.py",
    "peers/test_peers.py",
    "robots/agent_processes.py",
    "robots/agent_scale.py",
    "robots/agent_trials.py",
    "robots/dds_skill_servers.py",
    "robots/rover.py",
    "robots/skill_decider.py",
    "robots/skill_servers.py",
    "robots/skill_times.py",
    "robots/slow_agents.py",
    "robots/test_agent_security.py",
    "robots/test_arming_permits.py",
    "robots/test_dds.py",
    "robots/test_diagnostics.py",
    "robots/test_frame_tree.py",
    "robots/test_guard.py",
    "robots/test_library_push.py",
    "robots/test_lossy_links.py",
    "robots/test_recorded_training.py",
    "robots/test_recording.py",
    "robots/test_simulation_clock.py",
    "robots/test_skills.py",
    "robots/test_team_push.py",
    "robots/test_transport.py",
    "robots/test_watchdog.py",
    "robots/test_zenoh.py",
    "robots/test_zenoh_network.py",
    "robots/trial_decider.py",
    "robots/trial_robot.py",
    "robots/trials.py",
    "sim_mujoco/test_processes.py",
    "storage/test_library_folder.py",
    "training/test_killed.py",
    "ui/controller/test_live_drive.py",
    "ui/notebook/test_show_session.py",
    "ui/tui/test_real_robot.py",
    "ui/web/test_coach.py",
    "ui/web/test_drive_app.py",
    "ui/web/test_fastest.py",
    "ui/web/test_real_robots.py",
    "ui/web/test_serving.py",
}
"""Files that still sleep."""
COMPARING = {
    "browser/foraging.py",
    "browser/jupyter.py",
    "browser/teacher.py",
    "browser/test_forage.py",
    "browser/test_soak.py",
    "browser/test_tour.py",
    "jit/test_switch.py",
    "peers/test_hostile_peers.py",
    "peers/test_peers.py",
    "robots/agent_processes.py",
    "robots/agent_scale.py",
    "robots/agent_trials.py",
    "robots/plain_zenoh.py",
    "robots/rover.py",
    "robots/skill_decider.py",
    "robots/slow_agents.py",
    "robots/test_agent_security.py",
    "robots/test_dds.py",
    "robots/test_diagnostics.py",
    "robots/test_frame_tree.py",
    "robots/test_guard.py",
    "robots/test_recorded_training.py",
    "robots/test_simulation_clock.py",
    "robots/test_skills.py",
    "robots/test_transport.py",
    "robots/test_watchdog.py",
    "robots/test_zenoh.py",
    "robots/test_zenoh_network.py",
    "robots/trial_robot.py",
    "robots/trials.py",
    "sim/test_placement.py",
    "sim_mujoco/test_simulated_robots.py",
    "training/test_killed.py",
    "ui/controller/test_live_drive.py",
    "ui/tui/test_teach_command.py",
    "ui/web/test_arming_over_network.py",
    "ui/web/test_drive_app.py",
    "ui/web/test_library_zip.py",
    "ui/web/test_real_robots.py",
    "ui/web/test_serving.py",
}
"""Files that still compare the real time."""
MARKED_WHOLE = {
    "browser/test_running_team.py",
    "lab/bench/test_robot_latency.py",
    "robots/test_agent_recording.py",
    "robots/test_recorded_training.py",
    "robots/test_team_run.py",
}
"""Files that are still marked as timed as a whole."""
WAITING_IN_BROWSER = {
    "browser/curriculum.py",
    "browser/foraging.py",
    "browser/hand.py",
    "browser/jupyter.py",
    "browser/pictures.py",
    "browser/speed.py",
    "browser/teacher.py",
    "browser/test_axe.py",
    "browser/test_coach.py",
    "browser/test_driving.py",
    "browser/test_failing_worlds.py",
    "browser/test_first_use.py",
    "browser/test_notebook.py",
    "browser/test_page.py",
    "browser/test_small_screens.py",
    "browser/test_soak.py",
    "browser/test_team.py",
    "browser/test_touch.py",
    "browser/test_tour.py",
    "browser/test_unseen_worlds.py",
    "browser/test_world.py",
}
"""Files that still wait for times in a browser."""


def list_offenders(find: Callable[[Path], list[Offence]], *, excused: set[str]) -> dict[str, list[str]]:
    """List what all files but some do wrong, each with its lines."""
    found = {}
    for path in read_tests():
        name = path.relative_to(TESTS).as_posix()
        if path != Path(__file__) and name not in excused and (offences := find(path)):
            found[name] = [f"tests/{name}:{line}: {text.splitlines()[0][:80]}" for line, text in offences]
    return found


def find_waits_for_times(path: Path) -> list[Offence]:
    lines = read_tests()[path].splitlines()
    return [(number, line.strip()) for number, line in enumerate(lines, 1) if "wait_for_timeout(" in line]


RULES: list[
    tuple[Callable[[Path], list[Offence]], set[str], set[str]]
] = [  # finds it, still do so, may do so
    (find_sleeps, SLEEPING, {*WAITS, *OF_TIMED_TESTS}),
    (find_comparisons, COMPARING, {*WAITS, *OF_TIMED_TESTS}),
    (find_marks, MARKED_WHOLE, set()),
    (find_waits_for_times, WAITING_IN_BROWSER, set()),
]


@pytest.mark.xdist_group("real time")  # tests are read once
@pytest.mark.parametrize(("find", "still", "may"), RULES, ids=[find.__name__ for find, *_ in RULES])
def test_no_test_decides_by_the_clock(
    find: Callable[[Path], list[Offence]], still: set[str], may: set[str]
) -> None:
    found = list_offenders(find, excused=may)
    more = [line for name, lines in found.items() if name not in still for line in lines]
    assert not more, "in tests that are not timed:\n" + "\n".join(more)
    mended = sorted(still - set(found))
    assert not mended, "these do so no more; take them off the list:\n" + "\n".join(mended)


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
        for user in list_importers(name_of(path)):
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
