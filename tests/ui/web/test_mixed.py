"""In the studio a robot of another type has a library of its own: choosing it opens that."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.make.studios import make_studio, open_page, serve_studio, to_json

ROAM: dict[str, Any] = {
    "do": "new",
    "name": "roam",
    "states": ["forward"],
    "features": ["sonar_front"],
    "flags": [],
}


def test_choosing_a_robot_opens_the_library_of_its_type(tmp_path: Path) -> None:
    made = make_studio(tmp_path / "library", world="salvage")
    with serve_studio(made) as client, open_page(client) as person:
        assert "load" not in made.host.kit.behaviors
        person.done(**ROAM)
        person.done("pause", paused=True)
        person.done("press", state="forward")
        person.done("step")
        assert "unsaved changes" in str(person.say("select_agent", agent=5)["error"])
        person.done("save")
        assert (tmp_path / "library" / "scout" / "roam.json").is_file()
        person.done("select_agent", agent=5)
        assert (made.host.agent, list(made.host.library_view.library.taught)) == (5, [])
        assert {"load", "unload"} <= {each["name"] for each in to_json(made.host.scene())["behaviors"]}
        person.done("select_agent", agent=2)
        assert list(made.host.library_view.library.taught) == ["roam"]
        person.done("select_agent", agent=0, sort="crew")
        assert {"roam", "load", "forward"} <= set(made.host.kit.behaviors)
