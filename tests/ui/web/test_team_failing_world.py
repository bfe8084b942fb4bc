"""A failing world of a team in the studio: its coordinator is opened before the mistake, and corrected by a press."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.falsification.team_kept import keep_team
from tests.falsification.test_team_failure import WRONG_S, teach_lead
from tests.make.studios import Wall, open_page, serve_studio
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.addons.checks.falsification.open_failure import BEFORE_S
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost


def test_a_coordinator_is_opened_and_corrected(tmp_path: Path) -> None:
    library = keep_team(tmp_path, teach_lead())
    host = SessionHost(SCENARIO, library, ROBOTS.kit, wall=Wall(), failures=tmp_path / "failures")
    made = StudioServer(host, wall=Wall(glance=0.01))
    with serve_studio(made) as client, open_page(client) as person:
        person.done("open_failure", name="patrol-1")
        trainer = host.active_trainer
        assert (trainer.name, host.sort, host.paused) == ("lead", "patrol", True)
        assert host.world.time_s == pytest.approx(WRONG_S - BEFORE_S)
        assert "3.0 s before it goes wrong" in host.status.text
        while person.news["session"] is None:
            person.wait_for_news()
        assert (person.news["sort"], person.news["session"]["name"]) == ("patrol", "lead")
        other = "home" if trainer.session_view.state != "home" else "out"
        person.done("press", state=other)
        person.done("step")
        assert trainer.session_view.state == other
        assert trainer.has_unsaved_changes
        person.done("save")
        assert (library / "patrol" / "lead.json").exists()
        person.done("leave_failure")
        assert (host.active_trainer.name, host.sort, host.world.time_s) == ("lead", "patrol", 0.0)
        assert host.failures.find_open(host.scenario) is None
        person.done("step")
