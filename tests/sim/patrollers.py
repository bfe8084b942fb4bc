"""A patrol written by hand: robots that wander and servo, and a coordinator that sends them out and home."""

from __future__ import annotations

from understudy_lab.bench.patrol import known, lead, library, scenario

__all__ = ["ROBOTS", "SCENARIO", "known", "lead"]

SCENARIO = scenario()
ROBOTS = library()
