"""Worlds: simulated robots, many worlds side by side, made from scenarios, of which some are built in."""

from understudy.kernel_cache import choose_cache_folder

choose_cache_folder()
