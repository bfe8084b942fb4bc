"""A patrol written by hand: robots that wander and servo, and a coordinator that sends them out and home."""

from __future__ import annotations

from understudy_lab.bench.patrol import lead, library, make_libraries, scenario

__all__ = ["ROBOTS", "SCENARIO", "lead", "make_libraries"]

SCENARIO = scenario()
ROBOTS = library()
