"""How fast the page draws, and what the server takes for it: `python -m tests.browser.speed`.

A crowd drives in circles at 30 ticks a second, with one viewer. Measured in headless Chromium, without a graphics card.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil, sqrt
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright
from tests.browser.studio import READY
from tests.browser.window import WINDOW, find_chromium, launch

CROWDS = (200, 1000)
SECONDS = 10
SETTLING_S = 3

SCENARIO = """
understudy = "scenario"
version = 1
name = "crowd-{robots}"
size = [{size}, {size}]
tick_s = 0.03333333333333333

[[objects]]
name = "flag"
color = "red"

[types.rover]
radius = 0.2
speed = 0.5
turning_deg = 70

[[types.rover.sensors]]
kind = "locator"

[types.rover.behaviors]
forward = {{ drive = 1 }}
veer = {{ drive = 1, turn = 0.5 }}

[[robots]]
type = "rover"
count = {robots}

[targets]
flag = {{ object = "flag", doc = "Where to go." }}
"""

WATCH = """
(() => {
  const spent = (window.spent = { decoding: [], drawing: [], screens: 0 });
  let decoding = 0;
  const ask = window.requestAnimationFrame;
  const count = () => { spent.screens += 1; ask(count); };
  ask(count);
  window.requestAnimationFrame = (show) => ask((now) => {
    const began = performance.now();
    show(now);
    spent.drawing.push(performance.now() - began + decoding);
    decoding = 0;
  });
  const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage");
  Object.defineProperty(WebSocket.prototype, "onmessage", { set(take) {
    set.call(this, (event) => {
      const began = performance.now();
      take(event);
      const took = performance.now() - began;
      if (typeof event.data === "string") return;
      spent.decoding.push(took);
      decoding += took;
    });
  } });
})();
"""


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured of one crowd."""

    robots: int
    screens_per_s: float
    """How often the screen could be drawn."""
    drawn_per_s: float
    """How often it was: not where nothing moved since."""
    decode_and_draw_p95_ms: float
    received_per_s: float
    server_share: float

    def __str__(self) -> str:
        return (
            f"{self.robots:6} {self.screens_per_s:9.1f} {self.drawn_per_s:9.1f} {self.decode_and_draw_p95_ms:19.1f} "
            f"{self.received_per_s:12.1f} {self.server_share:14.0%}"
        )


def main() -> None:
    """Print a table."""
    _say("robots  frames/s   drawn/s  decode+draw p95, ms   received/s   server, core")
    with sync_playwright() as playwright:
        found = find_chromium() or ""
        browser = launch(playwright, found)
        for robots in CROWDS:
            with serve_studio_with_crowd(robots) as (address, process):
                page = browser.new_page(viewport=WINDOW)
                page.add_init_script(WATCH)
                page.goto(address)
                page.get_by_role("toolbar", name="Direct the robot").wait_for()
                page.get_by_role("button", name="Resume").click()
                _say(str(measure_page(page, process, robots)))
                page.close()
        browser.close()


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def measure_page(page: Page, process: int, robots: int) -> Measured:
    """Watch for a while."""
    page.wait_for_timeout(SETTLING_S * 1e3)
    page.evaluate(
        "spent.decoding.length = spent.drawing.length = spent.screens = 0; spent.since = performance.now()"
    )
    before = cpu_s(process)
    page.wait_for_timeout(SECONDS * 1e3)
    taken = cpu_s(process) - before
    spent = page.evaluate("({ ...spent, seconds: (performance.now() - spent.since) / 1e3 })")
    drawing, seconds = spent["drawing"], spent["seconds"]
    return Measured(
        robots=robots,
        screens_per_s=spent["screens"] / seconds,
        drawn_per_s=len(drawing) / seconds,
        decode_and_draw_p95_ms=float(np.percentile(drawing, 95)),
        received_per_s=len(spent["decoding"]) / seconds,
        server_share=taken / seconds,
    )


def cpu_s(process: int) -> float:
    """What a process took so far, s of one core."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def serve_studio_with_crowd(robots: int) -> Iterator[tuple[str, int]]:
    """A studio with a crowd, in a process of its own: its address and the process's number."""
    command = [sys.executable, "-m", "tests.browser.speed", str(robots)]
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, cwd=Path.cwd(), env=make_environment(folder)
        ) as process,
    ):
        assert process.stdout is not None
        line = next((found for line in process.stdout if (found := READY.search(line))), None)
        assert line is not None, "the studio did not start"
        yield line[1], process.pid
        process.terminate()


def make_environment(folder: str) -> dict[str, str]:
    return {**os.environ, "PYTHONUNBUFFERED": "1", "LIBRARY": folder}


def serve_crowd(robots: int, folder: Path) -> None:
    """The studio: one robot is trained, the others drive in circles."""
    from understudy.sim.kit import make_scenario_kit
    from understudy.sim.scenario.files import parse_scenario
    from understudy.ui.controller.training_plan import LessonChoices
    from understudy.ui.web.access import listen
    from understudy.ui.web.actions import session
    from understudy.ui.web.app import serve
    from understudy.ui.web.server import StudioServer
    from understudy.ui.web.session_host import SessionHost

    scenario = parse_scenario(SCENARIO.format(robots=robots, size=ceil(sqrt(robots) * 1.2)))
    host = SessionHost(scenario, folder / "library", make_scenario_kit(scenario))
    choices = LessonChoices(states=["forward", "veer"], features=["distance_to(flag)", "angle_to(flag)"])
    session.begin_automaton(host, "crowd", choices, discard=False)
    trainer = host.active_trainer
    trainer.session.set_other_agents("veer")
    trainer.press("veer")
    host.pause(True)
    address = listen("127.0.0.1", 0, None)
    serve(StudioServer(host), address, ready=lambda: _say(f"The studio is at {address.link}"))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_crowd(int(sys.argv[1]), Path(os.environ["LIBRARY"]))
    else:
        main()
