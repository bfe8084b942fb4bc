"""What tests of exports share."""

from __future__ import annotations

import os

import pytest
from tests.export.recorded_answers import ANSWERS, PEERS, RECORD, Answers, Ask, name_test, read_record


@pytest.fixture(scope="session")
def answers(pytestconfig: pytest.Config) -> Answers:
    """Of peers, as they are recorded."""
    if ANSWERS not in pytestconfig.stash:
        recorded = read_record(RECORD.read_text(encoding="utf-8"))
        pytestconfig.stash[ANSWERS] = Answers(recorded, asks_all=os.environ.get(PEERS) == "run")
    return pytestconfig.stash[ANSWERS]


@pytest.fixture
def ask(answers: Answers, request: pytest.FixtureRequest) -> Ask:
    """Asks foreign programs, or looks up what they answered before."""
    return Ask(answers, name_test(request.node.nodeid))
