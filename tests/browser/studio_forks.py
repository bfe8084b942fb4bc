"""Studios as forks of one process that has imported everything: `python -m tests.browser.studio_forks`.

Each line on standard input starts a studio or ends one, and is answered by a line on standard output. When standard
input ends, because whoever wrote to it is gone, all studios are killed.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from select import select
from unittest.mock import patch

import msgspec
from tests.browser.shared_clock import SharedClock

from understudy.ui.controller.beside import Beside
from understudy.ui.controller.score_keeper import LessonScoreKeeper

DIE_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of prctl."""
END_S = 60.0
"""How long a studio may take to end before it is killed."""


class Start(msgspec.Struct, tag=True):
    """Start a command; the answer is the number of its process."""

    arguments: list[str]
    output: str
    """The named pipe in which what it prints is written."""
    folder: str
    path: list[str]
    """Folders in which modules of the test are."""
    environment: dict[str, str]
    clock: str = ""
    """The file whose time is that of the world; empty for real time."""
    scores: bool = False
    """Whether what is trained is run in new worlds after each press, which takes processors from what is tested."""


class End(msgspec.Struct, tag=True):
    """Send a studio a signal and wait until it has ended; the answer is its wait status."""

    process: int
    signal: int


def leave_out(score: LessonScoreKeeper, _: Beside) -> None:
    """Begin no runs."""
    score.begin = lambda work: None


_read = msgspec.json.Decoder(Start | End).decode


def main() -> None:
    """Answer requests until there are no more."""
    scores = patch.object(LessonScoreKeeper, "run_beside", leave_out)
    scores.start()
    load_studio()
    running: set[int] = set()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin.buffer:
        request = _read(line)
        if isinstance(request, Start):
            said = os.open(request.output, os.O_WRONLY)
            answer = os.fork()
            if answer == 0:
                if request.scores:
                    scores.stop()
                become_studio(request, said)
                return
            os.close(said)
            running.add(answer)
        else:
            answer = end_process(request.process, request.signal)
            running.discard(request.process)
        sys.stdout.write(f"{answer}\n")
        sys.stdout.flush()
    for process in running:
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
    os._exit(0)  # at once: there is nothing to save


def load_studio() -> None:
    """Import what studios need, and load the kernels of a short lesson."""
    from tempfile import TemporaryDirectory

    import understudy.ui.cli.commands.studio
    import understudy.ui.cli.commands.studio_drive
    import understudy.ui.web.drive_app
    import understudy.ui.web.recording_app  # noqa: F401
    from understudy.sim.catalog import find_scenario
    from understudy.sim.kit import make_scenario_kit
    from understudy.ui.controller.training_plan import LessonChoices
    from understudy.ui.web.actions import session
    from understudy.ui.web.server import StudioServer
    from understudy.ui.web.session_host import SessionHost

    scenario = find_scenario("forage")
    with TemporaryDirectory() as folder:
        host = SessionHost(scenario, Path(folder) / "library", make_scenario_kit(scenario))
        server = StudioServer(host)
        choices = LessonChoices(states=["forward", "rotate_left"], features=["distance_to(station)"])
        session.begin_automaton(host, "warm", choices, discard=False)
        for state in ("forward", "rotate_left"):
            host.active_trainer.press(state)
            for _ in range(3):
                host.step()
        server.show()
        host.close()


def become_studio(start: Start, said: int) -> None:
    """Be the process of a command from here on, which ends when the first process does."""
    end_with_parent()
    nothing = os.open(os.devnull, os.O_RDONLY)
    for stream, file in enumerate((nothing, said, said)):
        os.dup2(file, stream)
    os.close(nothing)
    os.close(said)
    sys.stdin, sys.stdout, sys.stderr = os.fdopen(0), os.fdopen(1, "w", 1), os.fdopen(2, "w", 1)
    os.chdir(start.folder)
    os.environ.update(start.environment)
    sys.path[:0] = [start.folder, *start.path]
    sys.argv = ["understudy", *start.arguments]
    if start.clock:
        run_by_clock(Path(start.clock))
    from understudy.ui.cli import run_command_line

    run_command_line()


def run_by_clock(file: Path) -> None:
    """Let worlds run by the time in a file, which a test sets, in place of real time."""
    from understudy.ui.cli.commands import studio_drive
    from understudy.ui.web.session_host import SessionHost

    read = SharedClock(file).read
    for run in (SessionHost.__init__, studio_drive.make_drive_server):
        defaults = run.__kwdefaults__ or {}
        assert "wall" in defaults
        defaults["wall"] = read


def end_with_parent() -> None:
    """Let the system kill this process when the one that started it ends."""
    ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)


def end_process(process: int, how: int) -> int:
    """Send a child a signal, wait until it has ended, and return its status; kill it if it does not end."""
    os.kill(process, how)
    ended = os.pidfd_open(process)
    on_time = bool(select([ended], [], [], END_S)[0])
    os.close(ended)
    if not on_time:
        os.kill(process, signal.SIGKILL)
    _, status = os.waitpid(process, 0)
    return status if on_time else -1


if __name__ == "__main__":
    main()
