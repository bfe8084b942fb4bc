"""What most tests of the studio have: a studio whose world moves only when told, and a page of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.make.studios import Page, make_studio, open_page, serve_studio

from understudy.ui.web.server import StudioServer


@pytest.fixture
def server(tmp_path: Path) -> StudioServer:
    """A studio with an empty library."""
    return make_studio(tmp_path / "library")


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    """The page of a person, which is in control."""
    with serve_studio(server) as client, open_page(client) as here:
        yield here
