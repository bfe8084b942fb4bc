"""Domains and namespaces that tests running at the same time do not share."""

from __future__ import annotations

import os
from itertools import count
from zlib import crc32

DOMAINS = 100
"""The number of domains, from 1 on, whose ports lie below those that Linux gives to any program."""
_NUMBERS = count()


def own_domain(further: int = 0) -> int:
    """Return a domain for this worker, or a further one: no other of its test run has it, one of another hardly ever.

    Those of workers follow each other, so that `further` is to be at least the number of workers.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID", str(os.getpid()))
    return (crc32(run.encode()) + int(worker) + further) % DOMAINS + 1


def new_namespace(name: str = "rover") -> str:
    """Return a namespace that no other test uses."""
    return f"/{name}_{os.getpid()}_{next(_NUMBERS)}"
