"""A studio in a hurry: `python -m tests.browser.hurried LIBRARY TIMES`, whose second lasts so many seconds."""

from __future__ import annotations

import sys
from pathlib import Path
from time import monotonic

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.web.access import listen
from understudy.ui.web.app import serve
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost


def main(library: Path, times: float) -> None:
    """Serve the forage world."""
    scenario = find_scenario("forage")
    host = SessionHost(scenario, library, make_scenario_kit(scenario), wall=lambda: monotonic() * times)
    address = listen("127.0.0.1", 0, None)

    def ready() -> None:
        sys.stdout.write(f"The studio is at {address.link}\n")

    serve(StudioServer(host), address, ready=ready)


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]))
