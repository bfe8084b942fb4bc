"""Teams' files for agents: what is refused, and with which sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.robots.scale_team import make_plan

from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.errors import FileError, UnderstudyError

ROBOT = """
format = "understudy-robot/1"
name = "{name}"
world = "patrol"
domain = {domain}
{more}
[limits]
speed_m_s = 0.5
turn_rad_s = 1.0
[commands]
drive_m_s = 0.4
turn_rad_s = 1.0
"""
TEAM = """
format = "understudy-robots/1"
name = "patrol"
robots = ["pioneer_1.toml", "pioneer_2.toml", "last.toml"]
"""


def write_team(
    folder: Path, settings: str = "", *, name: str = "pioneer_3", more: str = "", domain: int = 113
) -> Path:
    """Write the files of a team; the last robot's name, domain and further keys may be given."""
    for number in (1, 2):
        (folder / f"pioneer_{number}.toml").write_text(
            ROBOT.format(name=f"pioneer_{number}", domain=110 + number, more="")
        )
    (folder / "last.toml").write_text(ROBOT.format(name=name, domain=domain, more=more))
    file = folder / "team.toml"
    file.write_text(TEAM + settings)
    return file


def test_a_team_that_is_right(tmp_path: Path) -> None:
    team = load_team_plan(
        write_team(tmp_path, '[agents.runs]\npioneer = "forwards"\n[agents.each.patrol_0]\n')
    )
    assert team.agents == ("pioneer_1", "pioneer_2", "pioneer_3", "patrol_0")


SETTINGS = [  # what the file says of agents, what the error says
    ("[agents]\nlease_s = -1.0\n", "at agents.lease_s: is -1; give from 0.3 (three ticks) to 60"),
    ("[agents]\nlease_s = nan\n", "at agents.lease_s: is nan"),
    ("[agents]\nlease_s = inf\n", "at agents.lease_s: is inf"),
    ("[agents]\nlease_s = 0.1\n", "at agents.lease_s: is 0.1"),
    (
        '[agents.each.pioner_1]\nlibrary = "x"\n',
        "at agents.each.pioner_1: is no agent of this team; name one of",
    ),
    ('[agents.bind.patrol]\nx = "red"\n', "at agents.bind.patrol: is of a sort that runs nothing"),
    ('[agents.runs]\nsubmarine = "x"\n', "at agents.runs.submarine: is no sort of agents"),
    ('[agents.deputies]\npatrol_0 = ["nobody"]\n', "names 'nobody', which is no agent"),
    ('[agents.runs]\npioneer = "dance"\n', "no behavior 'dance'"),
]


@pytest.mark.parametrize(("settings", "says"), SETTINGS)
def test_settings_that_are_refused(tmp_path: Path, settings: str, says: str) -> None:
    with pytest.raises(UnderstudyError) as caught:
        load_team_plan(write_team(tmp_path, settings))
    assert says in str(caught.value)


ROBOTS = [  # what differs in the last robot's file, what the error says
    ({"name": "pioneer_1"}, "has two robots of the name 'pioneer_1'"),
    ({"name": "patrol_0"}, "'patrol_0', which is that of a squad"),
    ({"name": "a/b *"}, "has the name 'a/b *'; give a name without / * ? # $"),
    ({"name": ""}, "has the name ''"),
    ({"more": "tick_s = 0.05"}, "differ in tick_s: pioneer_1 has 0.1, pioneer_3 0.05"),
    ({"domain": 111}, "pioneer_1 and pioneer_3, which would get the same commands"),
]


@pytest.mark.parametrize(("last", "says"), ROBOTS)
def test_robots_that_are_refused(tmp_path: Path, last: dict[str, str], says: str) -> None:
    with pytest.raises(FileError) as caught:
        load_team_plan(write_team(tmp_path, **last))  # type: ignore[arg-type]
    assert says in str(caught.value)


def test_long_ticks_are_refused(tmp_path: Path) -> None:
    file = write_team(tmp_path, more="tick_s = 0.6")
    for number in (1, 2):
        robot = tmp_path / f"pioneer_{number}.toml"
        robot.write_text(robot.read_text().replace("domain", "tick_s = 0.6\ndomain"))
    with pytest.raises(FileError, match=r"have a tick_s of 0\.6; give agents at most 0\.2"):
        load_team_plan(file)


@pytest.mark.parametrize("name", ["my*team", "my/team", "", "a # b"])
def test_names_of_teams_that_are_refused(tmp_path: Path, name: str) -> None:
    file = write_team(tmp_path)
    file.write_text(file.read_text().replace('"patrol"', f'"{name}"'))
    with pytest.raises(FileError, match="at name: has the name"):
        load_team_plan(file)


def test_a_library_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no such folder"):
        load_team_plan(write_team(tmp_path), library=tmp_path / "nowhere")


def test_who_asks_agents_does_not_listen_where_they_do(tmp_path: Path) -> None:
    """On the same computer, the address would be in use."""
    here, there = "tcp/0.0.0.0:7447", "tcp/0.0.0.0:7448"
    settings = f'[agents.network]\nlisten = ["{here}"]\n[agents.each.patrol_0]\nlisten = ["{there}"]\n'
    team = load_team_plan(write_team(tmp_path, settings))
    of = {name: list(team.make_network_options(name).listen) for name in ("pioneer_1", "patrol_0", None)}
    assert of == {"pioneer_1": [here], "patrol_0": [there], None: []}


def test_deputies_are_few_where_a_squad_is_large() -> None:
    """Each of them hears all members, so that a squad of a hundred must not have a hundred."""
    few, many = make_plan(6), make_plan(11)
    assert few.list_candidates("squad_0") == ("squad_0", "robot_0", "robot_1", "robot_2", "robot_3")
    assert many.list_candidates("squad_0") == ("squad_0", "robot_0", "robot_1")
    assert many.list_candidates("company_0") == ("company_0", "squad_0")
