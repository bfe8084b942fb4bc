"""Worlds: simulated bodies, many worlds side by side as rows. The catalog lists those that ship."""

from understudy.compiling import find_cache

find_cache()
