"""Worlds: simulated robots, many worlds side by side, made from scenarios, of which some are built in."""

from understudy.kernel_cache import find_cache

find_cache()
