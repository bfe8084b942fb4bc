"""What tests of robots over Zenoh share: a router, one for each module."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from tests.robots.routers import Router


@pytest.fixture(scope="module")
def router() -> Iterator[Router]:
    """A Zenoh router on a free port."""
    with Router() as opened:
        yield opened
