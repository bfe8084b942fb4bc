"""Worlds: simulated robots, many worlds side by side, made from scenarios, of which some are built in."""

from understudy.compiling import find_cache

find_cache()
